"""A page in the browser for one folder of benches: add recordings, state what is known,
correct, run, see the results.

Holds no physics and no measuring: it calls what the command line calls, and stores what
it is told in the files that the command line reads."""
