"""Draws pictures, frames and tracks with known truth, for tests, benchmarks and
samples."""
