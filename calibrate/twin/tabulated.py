"""Simulations that stand in CSV tables in the place of the twin's own: read as strictly as what people write of their bench."""

from vision.evidence.tables import read_numbers

__all__ = ["read_numbers"]
