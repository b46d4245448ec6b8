"""A blind proof of `benchtwin diagnose`: cases with a concealed effect, sealed keys, scores.

Nothing here imports the measuring, simulating or diagnosing code: another integrator, other formulas, a camera of its own. The
solver is met only through files and a process of its own, so that a mistake shared with it cannot pass for agreement.
"""
