"""A heap in the simulation: out of a box through its gate, or under a lifted
cylinder."""

from dataclasses import replace
from typing import Any

from benchtwin.rigs.pile.tells import whole_plate
from benchtwin.sim.motion import Motion
from benchtwin.sim.picture import Camera
from benchtwin.sim.rigs.cylinder import LiftedCylinder, run_cylinder
from benchtwin.sim.rigs.pile import Pile, run_pile
from benchtwin.twin.setup import Setup, level_line, of_heaps
from benchtwin.vision.recording import Recording


def cylinder(recording: Recording) -> Setup | None:
    """The lifted cylinder, where the recording states one."""
    return CYLINDER if recording.pile.cylinder_mm else None


def along_channel(recording: Recording, camera: Camera) -> Camera:
    """A channel is seen from its box to its far end."""
    if recording.pile.channel_mm is None:
        return camera
    seen = whole_plate({"channel_mm": recording.pile.channel_mm})
    x, y, z = (1e-3 * v for v in seen.pop("target_mm"))
    return replace(camera, target_m=(x, y, z), **seen)


def in_channel(recording: Recording, given: dict[str, Any]) -> dict[str, Any]:
    """A channel's floor is the plate, and box and gate are as wide as it, where nothing
    is stated of them."""
    if recording.pile.channel_mm is None:
        return given
    width = given["channel_m"][1]
    (length, _, box_high), (_, gate_high) = Pile.box_m, Pile.gate_m
    usual = {"box_m": (length, width, box_high), "gate_m": (width, gate_high)}
    return {"plate_m": given["channel_m"], **usual, **given}


def plate_seen(rig: Any, camera: Camera, motion: Motion) -> dict[str, Any]:
    """Where the plate's surface, z = 0, is seen at mid-depth, left and right [px]:
    seeds may hide it from the measuring code."""
    x, y, _ = camera.target_m
    half = 0.45e-3 * camera.mm_per_px * camera.width_px
    return {"baseline_px": level_line(camera, (x - half, x + half), y, 0.0)}


SETUP = of_heaps(
    Pile,
    run_pile,
    Camera(2400, 1600, 0.1, (0.1, 0.0, 0.055), 10.0),
    begins=True,
    truth=("repose_angle_deg", "centroid_angle_deg"),
    variant=cylinder,
    told=plate_seen,
    aimed=along_channel,
    fitting=in_channel,
    besides=("roi_px", "window_pct", "plain"),
)
CYLINDER = replace(
    SETUP,
    describe=LiftedCylinder,
    run=run_cylinder,
    camera=Camera(3000, 1300, 0.1, (0.0, 0.0, 0.045), 10.0),
)
