"""benchtwin compare-engines: the same piles, of the same law and packings, through our
engine and LAMMPS."""
