"""A seed let go on an incline that rolls out on the level: from its travel to a finding.

diagnose_roll(read_rolls(folder), rng) → Finding      # diagnose.py; read_rolls is in twin.roll_tracks
"""
