"""Reads the evidence of a recording: photos, frames, videos, sound, tables, keys."""
