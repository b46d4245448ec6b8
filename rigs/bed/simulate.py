"""Seeds that fall on a bed, in the simulation."""

from benchtwin.sim.picture import Camera, Look
from benchtwin.sim.rigs.bed import Bed, run_bed
from benchtwin.twin.setup import Setup

SETUP = Setup(
    Bed,
    run_bed,
    500.0,
    Camera(700, 1300, 0.16, (0.0, 0.0, 0.095), 10.0),
    Look(grey=True),
    soft_pa=1e7,
    step=0.3,
    many=True,
    in_lammps=False,
    truth=("bed_rebound_mm",),
)
