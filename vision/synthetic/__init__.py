"""Drawn truth: pictures, frames and tracks with known answers and the bench's difficulties as options.

Shipped with the tool: tests, benchmarks and samples are made of it. What is drawn here is never called measured.
"""
