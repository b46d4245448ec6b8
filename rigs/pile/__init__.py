"""Heaps: what surfaces in photos tell of cohesion, walls, gate, shaking, tilt and
shape."""
