"""A rotating drum in the simulation."""

from benchtwin.sim.picture import Camera, Look
from benchtwin.sim.rigs.drum import Drum, run_drum
from benchtwin.twin.setup import Setup

SETUP = Setup(
    Drum,
    run_drum,
    25.0,
    Camera(900, 900, 0.15, (0.0, 0.0, 0.0), 10.0),
    Look(),
    soft_pa=3e6,
    many=True,
    truth=("flowing_angle_deg",),
)
