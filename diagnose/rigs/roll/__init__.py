"""A seed that rolls down an incline and out on the level: diagnose_roll(read_rolls(folder), rng)
→ Finding.
"""
