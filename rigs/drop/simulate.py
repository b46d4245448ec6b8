"""A drop in the simulation, on a smooth plate or on a plate of seeds."""

from dataclasses import replace

from benchtwin.sim.picture import Camera, Look
from benchtwin.sim.rigs.drop import Drop, run_drop
from benchtwin.sim.rigs.seed_drop import SeedDrop, run_seed_drop
from benchtwin.twin.setup import Setup
from benchtwin.vision.recording import Recording


def seeds_below(recording: Recording) -> Setup | None:
    """The plate of seeds, where the recording states one."""
    return ON_SEEDS if recording.drop.plate else None


SETUP = Setup(
    Drop,
    run_drop,
    1000.0,
    Camera(800, 1280, 0.27, (0.0, 0.0, 0.155), 10.0),
    Look(grey=True),
    one_seed=True,
    besides=("height_sd_mm", "impacts_added_s", "impacts_struck_s"),
    variant=seeds_below,
)
ON_SEEDS = replace(
    SETUP,
    describe=SeedDrop,
    run=run_seed_drop,
    one_seed=False,
    in_lammps=False,
    truth=("rebound_height_mm",),
    besides=(*SETUP.besides, "plate", "coverage_sd", "plate_mm"),
)
