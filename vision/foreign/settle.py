"""Trails as a file states them → millimetres and seconds, y up, with what had to be assumed and what remains to be asked.

A unit that the file states is kept, even where a fall contradicts it: then it is asked. A unit that it does not state is taken
for the one in which the fall is a fall, and said; where none or several would do, lengths stay pixels, and it is asked.
"""

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from vision.foreign.fall import Fall, fits_gravity, free_falls, unit_doubt
from vision.foreign.found import Found, Trail
from vision.foreign.units import FRAMES, LENGTH, PIXELS, TIME
from vision.measurement import MeasurementError

_WITHOUT_UNIT = ("m", "cm", "mm", "in", "ft")
_SLOWEST_STEP_S = 0.2  # from frame to frame; a larger step is of milliseconds


@dataclass(frozen=True)
class Stated:
    """Trails as read. time_unit, length_unit: in TIME or FRAMES, LENGTH or PIXELS; "" not stated. up: "up", "down", "" not stated."""

    path: Path
    tool: str
    trails: tuple[Trail, ...]
    time_unit: str
    length_unit: str
    up: str


def settled(stated: Stated, keys: dict[str, dict[str, Any]], guesses: list[str], questions: list[str]) -> Found:
    """What the file comes down to. keys: of recording.toml that it states; guesses, questions: what its reader has to say before."""
    guesses, questions, bare = list(guesses), list(questions), False
    seconds, time_unit = _clock(stated, guesses, questions)
    trails = tuple(replace(t, time=t.time * seconds) for t in stated.trails)
    if stated.up == "down":
        trails = tuple(replace(t, y=-t.y) for t in trails)
    falls = [f for t in trails for f in free_falls(t.time, t.x, t.y)]
    fall = max(falls, key=lambda f: f.worth, default=None)
    if not stated.up:
        trails, fall = _upright(trails, fall, guesses, questions)
    if not stated.length_unit:
        mm, length_unit, bare = _length(trails, fall, time_unit, guesses, questions)
    elif stated.length_unit in PIXELS:
        mm, length_unit = 1.0, "px"
        if not any("mm_per_px" in q for q in questions) and "mm_per_px" not in keys.get("camera", {}):
            questions.append("lengths are pixels: how many millimetres is one ([camera] mm_per_px)? Without it, ratios only")
    else:
        mm, length_unit = _known(stated.path, "length", stated.length_unit, LENGTH), "mm"
    trails = tuple(replace(t, x=t.x * mm, y=t.y * mm) for t in trails)
    doubt = ""
    if time_unit == "s" and length_unit == "mm":
        whole = all((t.time == np.round(t.time)).all() for t in trails)
        doubt = unit_doubt(falls, mm, whole)
    found = Found(stated.tool, trails, time_unit, length_unit, keys=keys, doubt=doubt, bare=bare)
    return replace(found, guesses=tuple(guesses), questions=tuple(questions))


def _known(path: Path, what: str, unit: str, units: dict[str, float]) -> float:
    if unit not in units:
        raise MeasurementError(f"{path}: its unit of {what} is {unit[:30]!r}; known are {', '.join(list(units)[:12])} …")
    return units[unit]


def _clock(stated: Stated, guesses: list[str], questions: list[str]) -> tuple[float, str]:
    """Seconds of the file's unit of time, and "s"; or 1 and "frame"."""
    asked = "times are frame numbers: how many frames a second did the camera take ([camera] fps)? Without it, ratios only"
    if stated.time_unit in FRAMES:
        questions.append(asked)
        return 1.0, "frame"
    if stated.time_unit:
        return _known(stated.path, "time", stated.time_unit, TIME), "s"
    step = float(np.median(np.concatenate([np.diff(t.time) for t in stated.trails])))
    if step == round(step) and all((t.time == np.round(t.time)).all() for t in stated.trails) and step < 10:
        guesses.append("times are frame numbers: they are whole, one after the other")
        questions.append(asked)
        return 1.0, "frame"
    if step > _SLOWEST_STEP_S:
        guesses.append(f"times in milliseconds, which the file does not say: the rows are {step:.4g} apart")
        return 1e-3, "s"
    guesses.append(f"times in seconds, which the file does not say: the rows are {step:.4g} apart")
    return 1.0, "s"


def _upright(
    trails: tuple[Trail, ...], fall: Fall | None, guesses: list[str], questions: list[str]
) -> tuple[tuple[Trail, ...], Fall | None]:
    if fall is None:
        questions.append("is y up in it? Nothing falls freely by which to tell; taken as up")
        return trails, fall
    if fall.acceleration < 0:
        return trails, fall
    guesses.append("y is down in the file, as in a picture: the fall goes towards greater y; turned to y up")
    return tuple(replace(t, y=-t.y) for t in trails), replace(fall, acceleration=-fall.acceleration)


def _length(
    trails: tuple[Trail, ...], fall: Fall | None, time_unit: str, guesses: list[str], questions: list[str]
) -> tuple[float, str, bool]:
    """Millimetres of a unit that the file does not state, and "mm"; or 1 and "px", and whether even that is not known."""
    if all((np.append(t.x, t.y) == np.round(np.append(t.x, t.y))).all() for t in trails):
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
