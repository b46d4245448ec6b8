"""Contact parameters → motion of multi-sphere seeds → pictures. Knows nothing of
measuring. SI units throughout."""
