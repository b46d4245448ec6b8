"""Whether LAMMPS can be run here: what needs it is left out elsewhere."""

from benchtwin.sim.lammps.program import Unavailable, program


def installed() -> bool:
    try:
        program()
    except Unavailable:
        return False
    return True
