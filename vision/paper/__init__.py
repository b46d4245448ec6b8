"""Millimetre graph paper in a picture → scale, tilt, perspective."""
