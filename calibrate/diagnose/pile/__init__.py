"""Heaps: what the surface in a photo, and what differs between photos, tells of cohesion, walls, gate, shaking, tilt and shape.

flanks.py    surface → each flank in shares of its height and length, its angle; what a photo's conditions are
usual.py     what heaps usually look like (simulated ones, and room for others), and how much they scatter
problem.py   flanks of all photos → a Problem: profiles, angles, the plate's line
decide.py    evidence → a verdict that no photo can contradict
diagnose.py  all of it
"""
