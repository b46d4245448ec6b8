"""A page in the browser for one folder of benches: bring recordings, say what is known, look, run, believe.

Holds no physics and no measuring: it calls what the command line calls, and stores what it is told in the files that the
command line reads.
"""
