"""Heaps: what surfaces in photos tell of cohesion, walls, gate, shaking, tilt and grain shape.

flanks.py, creep.py: flanks in shares of their height and length; change between photos.
heap_priors.py, scatter.py: usual shapes; roughness and packing scatter from the heaps themselves.
problem.py, diagnose.py: flanks of all photos as a Problem, and its finding.
resimulation.py, simulated_heaps.py: heaps run again in the DEM.
"""
