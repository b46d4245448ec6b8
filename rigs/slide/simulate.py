"""A slide in the simulation."""

from typing import Any

from benchtwin.sim.picture import Camera, Look
from benchtwin.sim.rigs.slide import Slide, run_slide
from benchtwin.twin.setup import Setup
from benchtwin.vision.recording import Recording


def with_count(recording: Recording, given: dict[str, Any]) -> dict[str, Any]:
    """As many seeds taped together as the recording states."""
    count = recording.seed.count
    return given if count is None else given | {"count": count}


SETUP = Setup(
    Slide,
    run_slide,
    50.0,
    Camera(1280, 800, 0.2, (0.095, 0.0, 0.055), 10.0),
    Look(grey=True),
    straight=True,
    fitting=with_count,
)
