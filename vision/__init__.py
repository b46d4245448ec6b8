"""Pictures, frames, videos and tracks from the bench → measurements with standard deviations. Knows nothing of simulating."""
