"""The only drawing on pictures: what was found, drawn on what it was found in. Arrays in, uint8 RGB arrays out."""
