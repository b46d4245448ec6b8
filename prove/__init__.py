"""A blind test of `benchtwin diagnose`: cases with a concealed effect, hashed answer
keys, scores.

Nothing here imports the measuring, simulating or diagnosing code, so that a mistake
shared with it cannot pass for agreement. The solver is reached through files and a
process of its own."""
