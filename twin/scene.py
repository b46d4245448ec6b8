"""A recording's description ↔ the rig, the bench and the camera that the simulation
takes."""

from dataclasses import fields, replace
from typing import Any

import numpy as np

from benchtwin.bench import keys
from benchtwin.bench.rigs import RIGS
from benchtwin.sim.picture import Camera, project
from benchtwin.twin.setup import Setup, setup_for
from benchtwin.vision.recording import Recording

UNITS = (("_m_s", "_mm_s"), ("_m", "_mm"))


def setup_of(recording: Recording) -> Setup:
    """How a recording's rig is simulated."""
    setup = setup_for(recording.need_rig())
    return setup.variant(recording) or setup


def rig_of(recording: Recording) -> Any:
    """The rig as described, lengths in metres; what is not stated has the paper's
    value. ValueError names what does not fit."""
    setup, section = setup_of(recording), getattr(recording, recording.need_rig())
    given: dict[str, Any] = {}
    for field in fields(setup.describe):
        key = key_of(field.name)
        value = getattr(section, key, None)
        if value is not None:
            given[field.name] = _scaled(value, 1e-3) if key != field.name else value
    _check_simulated(recording, setup)
    return setup.describe(**setup.fitting(recording, given))


def _check_simulated(recording: Recording, setup: Setup) -> None:
    """ValueError for a stated key that the simulation has no place for: its answer
    would be that of another rig."""
    name = recording.need_rig()
    known = {key_of(field.name) for field in fields(setup.describe)}
    known |= {*setup.besides, *RIGS[name].per_recording, *RIGS[name].weighed}
    stated = getattr(recording, name).model_dump(exclude_none=True)
    if lost := sorted(set(stated) - known):
        has = ", ".join(sorted(key_of(f.name) for f in fields(setup.describe)))
        raise ValueError(
            f"[{name}] {lost[0]} = {stated[lost[0]]}: the simulation of this {name} has"
            f" no such number; it has {has}"
        )


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
    stated, setup = recording.camera, setup_of(recording)
    camera = setup.aimed(recording, setup.camera)
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
    return replace(
        camera, **{key: value for key, value in given.items() if value is not None}
    )


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
        "readout_s": None,  # it reads all rows at once
    }
    return section.model_copy(update=stated)


def sees(camera: Camera, points_m: np.ndarray) -> np.ndarray:
    """Which points (n, 3) the picture shows."""
    at = project(camera, points_m)
    return np.all(
        (at >= 0) & (at <= np.array([camera.width_px - 1, camera.height_px - 1])),
        axis=1,
    )
