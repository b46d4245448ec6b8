"""LAMMPS as a second engine: a `World` written as its input, run as its own program,
and read back as the same motion."""
