"""Pictures, frames, videos and tracks from the bench → evidence: outlines, tracks,
impact times, readings, each with standard deviations. Knows nothing of simulating."""
