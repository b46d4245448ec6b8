"""Bench recordings and their simulated twin → contact parameters, and what is missing. The only package that knows both sides."""
