"""Photo of a pile → angle of repose (`repose.py`)."""
