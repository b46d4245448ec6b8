"""A recording's description ↔ the rig, the bench and the camera that the simulation
takes."""

from collections.abc import Callable
from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np
from benchtwin.bench import keys
from benchtwin.sim.picture import Camera, Look, project
from benchtwin.sim.rigs.cylinder import LiftedCylinder, run_cylinder
from benchtwin.sim.rigs.drop import Drop, run_drop
from benchtwin.sim.rigs.drum import Drum, run_drum
from benchtwin.sim.rigs.pile import Pile, run_pile
from benchtwin.sim.rigs.roll import Roll, run_roll
from benchtwin.sim.rigs.slide import Slide, run_slide
from benchtwin.vision.recording import Recording

UNITS = (("_m_s", "_mm_s"), ("_m", "_mm"))


@dataclass(frozen=True)
class Setup:
    """One kind of rig: its description, what runs it, the frame rate and camera where a
    recording states none, and its look."""

    describe: type
    run: Callable
    fps: float
    camera: Camera
    look: Look


SETUPS = {
    "drop": Setup(
        Drop,
        run_drop,
        1000.0,
        Camera(800, 1280, 0.27, (0.0, 0.0, 0.155), 10.0),
        Look(grey=True),
    ),
    "slide": Setup(
        Slide,
        run_slide,
        50.0,
        Camera(1280, 800, 0.2, (0.095, 0.0, 0.055), 10.0),
        Look(grey=True),
    ),
    "roll": Setup(
        Roll,
        run_roll,
        200.0,
        Camera(1280, 400, 0.26, (0.125, 0.0, 0.02), 10.0),
        Look(grey=True),
    ),
    "pile": Setup(
        Pile, run_pile, 0.0, Camera(2400, 1600, 0.1, (0.1, 0.0, 0.055), 10.0), Look()
    ),
    "drum": Setup(
        Drum, run_drum, 25.0, Camera(900, 900, 0.15, (0.0, 0.0, 0.0), 10.0), Look()
    ),
    "cylinder": Setup(
        LiftedCylinder,
        run_cylinder,
        0.0,
        Camera(3000, 1300, 0.1, (0.0, 0.0, 0.045), 10.0),
        Look(),
    ),
}


def setup_of(recording: Recording) -> Setup:
    """The setup of a recording's rig; a pile with a cylinder in its description is a
    lifting cylinder."""
    rig = recording.need_rig()
    return SETUPS["cylinder" if rig == "pile" and recording.pile.cylinder_mm else rig]


def rig_of(recording: Recording) -> Any:
    """The rig as described, lengths in metres; what is not stated has the paper's
    value. ValueError names what does not fit."""
    kind = setup_of(recording).describe
    section = getattr(recording, recording.need_rig())
    given = {}
    for field in fields(kind):
        value = getattr(section, key_of(field.name), None)
        if value is not None:
            given[field.name] = (
                _scaled(value, 1e-3) if key_of(field.name) != field.name else value
            )
    if kind is Roll and recording.roll.level is False:
        raise ValueError(
            f"{recording.toml}: [roll] level = false: the twin's rolls run out on a"
            " level plate, none stays on its incline"
        )
    if kind is Roll and recording.roll.rail_gap_mm:
        raise ValueError(
            f"{recording.toml}: [roll] rail_gap_mm: the twin has no rails, its seeds"
            " roll on a plate"
        )
    if kind is Slide and recording.seed.count is not None:
        given["count"] = recording.seed.count
    return kind(**given)


def section_of(rig: Any, section: Any) -> Any:
    """A recording's section with everything that the rig knows of itself."""
    stated = {}
    for field in fields(rig):
        key, value = key_of(field.name), getattr(rig, field.name)
        if key in type(section).model_fields and value is not None:
            stated[key] = _rounded(_scaled(value, 1e3)) if key != field.name else value
    return section.model_copy(update=stated)


def key_of(name: str) -> str:
    """recording.toml's key of a field: millimetres where the simulation has metres."""
    for metres, millimetres in UNITS:
        if name.endswith(metres):
            return name.removesuffix(metres) + millimetres
    return name


def _scaled(value, factor: float):
    if isinstance(value, tuple | list):
        return tuple(factor * v for v in value)
    return factor * value


def _rounded(value):
    """0.105 m are 105 mm, not 104.99999999999999."""
    if isinstance(value, tuple):
        return tuple(float(f"{v:.9g}") for v in value)
    return float(f"{value:.9g}")


def camera_of(recording: Recording) -> Camera:
    """The camera as the recording describes it, else where the rig's own stands."""
    stated, camera = recording.camera, setup_of(recording).camera
    given: dict[str, Any] = {
        "width_px": stated.width_px,
        "height_px": stated.height_px,
        "mm_per_px": stated.mm_per_px,
        "target_m": (
            None if stated.target_mm is None else _scaled(stated.target_mm, 1e-3)
        ),
        "distance_m": None if stated.distance_mm is None else 1e-3 * stated.distance_mm,
        "roll_deg": stated.plumb_deg,
        "distortion": stated.distortion,
        "exposure_s": stated.exposure_s,
    }
    camera = replace(
        camera, **{key: value for key, value in given.items() if value is not None}
    )
    if (
        recording.rig == "roll"
        and recording.roll.direction == "-x"
        and stated.target_mm is None
    ):
        x, y, z = camera.target_m
        camera = replace(camera, target_m=(-x, y, z))
    return camera


def camera_section(camera: Camera, fps: float, section: keys.Camera) -> keys.Camera:
    """A recording's [camera] that states all of it."""
    stated = {
        "width_px": camera.width_px,
        "height_px": camera.height_px,
        "mm_per_px": camera.mm_per_px,
        "mm_per_px_sd": (
            section.mm_per_px_sd
            if section.mm_per_px_sd is not None
            else 1e-4 * camera.mm_per_px
        ),
        "plumb_deg": camera.roll_deg,
        "plumb_sd_deg": (
            section.plumb_sd_deg if section.plumb_sd_deg is not None else 0.02
        ),
        "target_mm": _rounded(_scaled(camera.target_m, 1e3)),
        "distance_mm": 1e3 * camera.distance_m,
        "distortion": camera.distortion,
        "exposure_s": camera.exposure_s or None,
        "fps": fps or section.fps,
    }
    return section.model_copy(update=stated)


def baseline(camera: Camera) -> tuple[float, float, float, float]:
    """Where the plate's surface, z = 0, is seen at mid-depth, left and right [px]:
    seeds may hide it from the measuring code."""
    x, y, _ = camera.target_m
    half = 0.45e-3 * camera.mm_per_px * camera.width_px
    ends = project(camera, np.array([[x - half, y, 0.0], [x + half, y, 0.0]]))
    x1, y1, x2, y2 = (float(f"{v:.6g}") for v in ends.ravel())
    return x1, y1, x2, y2


def sees(camera: Camera, points_m: np.ndarray) -> np.ndarray:
    """Which points (n, 3) the picture shows."""
    at = project(camera, points_m)
    return np.all(
        (at >= 0) & (at <= np.array([camera.width_px - 1, camera.height_px - 1])),
        axis=1,
    )
