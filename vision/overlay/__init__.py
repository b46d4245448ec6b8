"""Overlays: what was found, drawn on the picture; arrays in, uint8 RGB arrays out."""
