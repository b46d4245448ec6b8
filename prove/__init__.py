"""A blind test of `benchtwin diagnose`: cases with a concealed effect, hashed answer keys, scores.

Nothing here imports the measuring, simulating or diagnosing code: the integrator, the formulas and the camera are its own. The
solver is reached only through files and a process of its own, so that a mistake shared with it cannot pass for agreement.
"""
