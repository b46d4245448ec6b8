"""A slide in the simulation: of taped seeds on a smooth plate, or of a card of seeds on
a plate of seeds."""

from dataclasses import replace
from typing import Any

from benchtwin.sim.picture import Camera, Look
from benchtwin.sim.rigs.seed_slide import SeedSlide, run_seed_slide
from benchtwin.sim.rigs.slide import Slide, run_slide
from benchtwin.twin.setup import Setup, as_stated
from benchtwin.vision.recording import Recording


def with_count(recording: Recording, given: dict[str, Any]) -> dict[str, Any]:
    """As many seeds taped together as the recording states."""
    count = recording.seed.count
    return given if count is None else given | {"count": count}


def seeds_below(recording: Recording) -> Setup | None:
    """The plate of seeds, where the recording states one."""
    return ON_SEEDS if recording.slide.plate else None


SETUP = Setup(
    Slide,
    run_slide,
    50.0,
    Camera(1280, 800, 0.2, (0.095, 0.0, 0.055), 10.0),
    Look(grey=True),
    straight=True,
    fitting=with_count,
    variant=seeds_below,
)
# by angle, not by time: there is nothing to film
ON_SEEDS = replace(
    SETUP,
    describe=SeedSlide,
    run=run_seed_slide,
    in_lammps=False,
    truth=("slide_angle_deg",),
    filmed=False,
    fitting=as_stated,
    besides=("plate", "coverage_sd", "plate_mm", "start_mm", "start_deg"),
)
