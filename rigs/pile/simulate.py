"""A heap in the simulation: out of a box through its gate, or under a lifted
cylinder."""

from dataclasses import replace
from typing import Any

from benchtwin.sim.motion import Motion
from benchtwin.sim.picture import Camera
from benchtwin.sim.rigs.cylinder import LiftedCylinder, run_cylinder
from benchtwin.sim.rigs.pile import Pile, run_pile
from benchtwin.twin.setup import Setup, level_line, of_heaps
from benchtwin.vision.recording import Recording

MARGIN_MM = 20.0  # of a picture beside a channel


def cylinder(recording: Recording) -> Setup | None:
    """The lifted cylinder, where the recording states one."""
    return CYLINDER if recording.pile.cylinder_mm else None


def along_channel(recording: Recording, camera: Camera) -> Camera:
    """A channel is seen from its box to its far end."""
    if recording.pile.channel_mm is None:
        return camera
    length = recording.pile.channel_mm[0]
    scale = (length + MARGIN_MM) / camera.width_px
    middle = (length / 2000, 0.0, 0.4e-3 * scale * camera.height_px)
    return replace(camera, mm_per_px=scale, target_m=middle)


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
    besides=("roi_px", "window_pct"),
)
CYLINDER = replace(
    SETUP,
    describe=LiftedCylinder,
    run=run_cylinder,
    camera=Camera(3000, 1300, 0.1, (0.0, 0.0, 0.045), 10.0),
)
