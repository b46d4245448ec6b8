"""Heaps: what the surface in a photo, and what differs between photos, tells of cohesion, walls, gate, shaking, tilt and shape.

flanks.py, creep.py   surface → each flank in shares of its height and length, its angle; what goes on between photos; conditions
heap_priors.py, scatter.py  what every heap has, as priors; roughness and packings, from the heaps themselves
problem.py            flanks of all photos → a Problem: profiles, angles, the plate's line
diagnose.py           alternatives, what nobody listed, and what is asked of them
resimulation.py, slices.py   heaps run again in the DEM
"""
