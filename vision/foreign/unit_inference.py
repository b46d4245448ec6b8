"""Converts tracks of a file to millimetres and seconds, y up, and infers units that the file does not state.

A stated unit is used, even where a fall contradicts it: then there is a question. An unstated unit is the one in which a fall has the
acceleration of gravity; where none or several fit, lengths stay pixels, with a question.
"""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from vision.foreign.contents import Contents, PointTrack, require_tracks
from vision.foreign.free_fall import Fall, fits_gravity, free_falls, unit_doubt
from vision.foreign.units import FRAMES, LENGTH, PIXELS, TIME
from vision.measurement import MeasurementError

_WITHOUT_UNIT = ("m", "cm", "mm", "in", "ft")
_SLOWEST_STEP_S = 0.2  # from frame to frame; a larger step is of milliseconds


def infer_units(
    path: Path, tool: str, tracks: Sequence[PointTrack | None], time_unit: str, length_unit: str, up: str,
    keys: dict[str, dict[str, Any]] | None = None, guesses: list[str] | None = None, questions: list[str] | None = None,
) -> Contents:  # fmt: skip
    """The tracks in mm and s, y up, as contents of the file; MeasurementError where there is no track.

    time_unit: of TIME or FRAMES; length_unit: of LENGTH or PIXELS; up: "up" or "down"; "" where the file does not state it.
    keys: of recording.toml that the file states; guesses, questions: of its reader.
    """
    keys, guesses, questions, unitless = keys or {}, list(guesses or ()), list(questions or ()), False
    read = require_tracks(path, tracks)
    seconds, time_unit = _clock(path, read, time_unit, guesses, questions)
    found = tuple(replace(t, time=t.time * seconds, y=-t.y if up == "down" else t.y) for t in read)
    falls = [f for t in found for f in free_falls(t.time, t.x, t.y)]
    fall = max(falls, key=lambda f: f.worth, default=None)
    if not up:
        found, fall = _y_up(found, fall, guesses, questions)
    if not length_unit:
        mm, length_unit, unitless = _length(found, fall, time_unit, guesses, questions)
    elif length_unit in PIXELS:
        mm, length_unit = 1.0, "px"
        if not any("mm_per_px" in q for q in questions) and "mm_per_px" not in keys.get("camera", {}):
            questions.append("lengths are pixels: how many millimetres is one ([camera] mm_per_px)? Without it, ratios only")
    else:
        mm, length_unit = _factor(path, "length", length_unit, LENGTH), "mm"
    found = tuple(replace(t, x=t.x * mm, y=t.y * mm) for t in found)
    doubt = ""
    if time_unit == "s" and length_unit == "mm":
        doubt = unit_doubt(falls, mm, seconds, all((t.time == np.round(t.time)).all() for t in read))
    return Contents(
        tool, found, time_unit, length_unit, keys=keys, guesses=tuple(guesses), questions=tuple(questions), doubt=doubt, unitless=unitless
    )


def _factor(path: Path, what: str, unit: str, units: dict[str, float]) -> float:
    if unit not in units:
        raise MeasurementError(f"{path}: its unit of {what} is {unit[:30]!r}; known are {', '.join(list(units)[:12])} …")
    return units[unit]


def _clock(path: Path, tracks: Sequence[PointTrack], time_unit: str, guesses: list[str], questions: list[str]) -> tuple[float, str]:
    """The file's unit of time in seconds, and "s"; or 1 and "frame"."""
    asked = "times are frame numbers: how many frames a second did the camera take ([camera] fps)? Without it, ratios only"
    if time_unit in FRAMES:
        questions.append(asked)
        return 1.0, "frame"
    if time_unit:
        return _factor(path, "time", time_unit, TIME), "s"
    step = float(np.median(np.concatenate([np.diff(t.time) for t in tracks])))
    if step == round(step) and all((t.time == np.round(t.time)).all() for t in tracks) and step < 10:
        guesses.append("times are frame numbers: they are whole, one after the other")
        questions.append(asked)
        return 1.0, "frame"
    if step > _SLOWEST_STEP_S:
        guesses.append(f"times in milliseconds, which the file does not say: the rows are {step:.4g} apart")
        return 1e-3, "s"
    guesses.append(f"times in seconds, which the file does not say: the rows are {step:.4g} apart")
    return 1.0, "s"


def _y_up(
    tracks: tuple[PointTrack, ...], fall: Fall | None, guesses: list[str], questions: list[str]
) -> tuple[tuple[PointTrack, ...], Fall | None]:
    if fall is None:
        questions.append("is y up in it? Nothing falls freely by which to tell; taken as up")
        return tracks, fall
    if fall.acceleration < 0:
        return tracks, fall
    guesses.append("y is down in the file, as in a picture: the fall goes towards greater y; turned to y up")
    return tuple(replace(t, y=-t.y) for t in tracks), replace(fall, acceleration=-fall.acceleration)


def _length(
    tracks: tuple[PointTrack, ...], fall: Fall | None, time_unit: str, guesses: list[str], questions: list[str]
) -> tuple[float, str, bool]:
    """The unstated unit of length in millimetres, and "mm"; or 1 and "px"; and whether even that is unknown."""
    if all((np.append(t.x, t.y) == np.round(np.append(t.x, t.y))).all() for t in tracks):
        guesses.append("lengths are pixels: they are whole numbers")
        questions.append("how many millimetres is a pixel ([camera] mm_per_px)? Without it, ratios only")
        return 1.0, "px", False
    fitting = [u for u in _WITHOUT_UNIT if fall is not None and time_unit == "s" and fits_gravity(fall.acceleration * LENGTH[u])]
    if len(fitting) == 1 and fall is not None:
        found = abs(fall.acceleration) * LENGTH[fitting[0]] / 1000
        guesses.append(f"lengths in {fitting[0]}, which the file does not say: so the fall accelerates by {found:.3g} m/s²")
        return LENGTH[fitting[0]], "mm", False
    questions.append("in which unit are its lengths? Taken as pixels: [camera] mm_per_px says how many millimetres is one")
    return 1.0, "px", True
