"""A drop in the simulation."""

from benchtwin.sim.picture import Camera, Look
from benchtwin.sim.rigs.drop import Drop, run_drop
from benchtwin.twin.setup import Setup

SETUP = Setup(
    Drop,
    run_drop,
    1000.0,
    Camera(800, 1280, 0.27, (0.0, 0.0, 0.155), 10.0),
    Look(grey=True),
    one_seed=True,
    besides=("height_sd_mm", "impacts_added_s", "impacts_struck_s"),
)
