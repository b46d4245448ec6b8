"""A roll in the simulation: down an incline, out on a level plate."""

from dataclasses import replace
from typing import Any

from benchtwin.bench.language import tr
from benchtwin.sim.picture import Camera, Look
from benchtwin.sim.rigs.roll import Roll, run_roll
from benchtwin.twin.setup import Setup
from benchtwin.vision.recording import Recording


def runs_out(recording: Recording, given: dict[str, Any]) -> dict[str, Any]:
    """ValueError for a roll that stays on its incline, or runs on rails."""
    if recording.roll.level is False:
        raise ValueError(
            tr(
                "{}: [roll] level = false: the twin's rolls run out on a level plate,"
                " none stays on its incline",
                recording.toml,
            )
        )
    if recording.roll.rail_gap_mm:
        raise ValueError(
            tr(
                "{}: [roll] rail_gap_mm: the twin has no rails, its seeds roll on a"
                " plate",
                recording.toml,
            )
        )
    return given


def aimed(recording: Recording, camera: Camera) -> Camera:
    """Where the seed rolls."""
    x, y, z = camera.target_m
    ahead = -x if recording.roll.direction == "-x" else x
    return replace(camera, target_m=(ahead, y, z))


SETUP = Setup(
    Roll,
    run_roll,
    200.0,
    Camera(1280, 400, 0.26, (0.125, 0.0, 0.02), 10.0),
    Look(grey=True),
    one_seed=True,
    straight=True,
    fitting=runs_out,
    besides=("level", "rail_gap_mm"),
    aimed=aimed,
)
