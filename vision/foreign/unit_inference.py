"""Converts tracks of a file to millimetres and seconds, y up, and infers units that the
file does not state.

A stated unit is used, even where a fall contradicts it: then there is a question. An
unstated unit is the one in which a fall has the acceleration of gravity; where none or
several fit, lengths stay pixels, with a question."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from itertools import chain
from pathlib import Path

import numpy as np
import pandas as pd
from numpy.lib.stride_tricks import sliding_window_view

from benchtwin.bench.constants import G_M_S2
from benchtwin.vision.foreign.contents import (
    Asked,
    Contents,
    PointTrack,
    Tracked,
    tracks_of,
)
from benchtwin.vision.foreign.source import FRAMES, LENGTH, PIXELS, TIME
from benchtwin.vision.measurement import require

_WITHOUT_UNIT = ("m", "cm", "mm", "in", "ft")
_SLOWEST_STEP_S = 0.2  # from frame to frame; a larger step is of milliseconds
TOLERANCE = 0.25  # relative, of g: perspective, an error of the scale, air
# of g: a light ball near terminal velocity; a wrong scale or frame rate, which is
# noticed elsewhere
LEAST, GREATEST = (0.05, 3.0)
MOST = 0.8  # share of the flights that a change of units must explain
# rms about a parabola, of its sagitta: a bounce in the window gives 0.05
LARGEST_MISFIT = 0.03
LEAST_SAGITTA = 0.03  # of the motion's extent: less is noise
# acceleration along x over that along y: a roll down an incline has both
LARGEST_SIDEWAYS = 0.15
MOST_POINTS = 1000
RATE = Asked(
    "times are frame numbers: how many frames a second did the camera take? Without it,"
    " ratios only",
    "[camera] fps",
)
SCALE = Asked(
    "lengths are pixels: how many millimetres is one? Without it, ratios only",
    "[camera] mm_per_px",
)
UNITLESS = replace(
    SCALE,
    words="in which unit are its lengths? Taken as pixels: how many millimetres is one"
    " (1000 where they are metres)?",
)
PARABOLA = ("rows", "ax", "ay", "sx", "sy", "mx", "my")
_TIMES = {"seconds": 1.0, "milliseconds": 1e-3, "minutes": 60.0}
_LENGTHS = {
    "metres": 1000.0,
    "centimetres": 10.0,
    "millimetres": 1.0,
    "inches": 25.4,
    "micrometres": 1e-3,
}


@dataclass(frozen=True)
class Fall:
    """A free flight in a track: acceleration along y, and worth (sagitta less a
    multiple of the misfit), in the track's units."""

    acceleration: float
    worth: float


def parabolas_in(time: np.ndarray, x: np.ndarray, y: np.ndarray) -> pd.DataFrame:
    """Parabolas through windows of many lengths, all over a track, that bend by more
    than noise; times increase. rows: in the window; ax, ay: acceleration; sx, sy:
    sagitta, signed; mx, my: rms about them."""
    step = max(1, len(time) // MOST_POINTS)
    extent = max(np.ptp(x), np.ptp(y)) if len(x) else 0.0
    time, places = time[::step], np.column_stack([x, y])[::step]
    found = [np.empty((0, len(PARABOLA)))]
    for n in sorted({int(n) for n in np.geomspace(5, max(len(time), 5), 20)}):
        if n > len(time) or not extent:
            break
        some = slice(None, None, max(1, n // 6))
        t = sliding_window_view(time, n)[some]
        both = sliding_window_view(places, n, axis=0)[some].swapaxes(1, 2)
        span = np.ptp(t, axis=1)[:, None]
        s = (t - t.mean(axis=1, keepdims=True)) / span
        powers = np.stack([np.ones_like(s), s, s**2], axis=2)  # windows × rows × 3
        squares = np.einsum("wri,wrj->wij", powers, powers)
        fitted = np.linalg.pinv(squares, hermitian=True) @ np.einsum(
            "wri,wrk->wik", powers, both
        )
        misfit = np.std(both - np.einsum("wri,wik->wrk", powers, fitted), axis=1)
        bend, rows = fitted[:, 2], np.full((len(t), 1), n)
        found.append(np.hstack([rows, 2 * bend / span**2, bend / 4, misfit]))
    table = pd.DataFrame(np.concatenate(found), columns=list(PARABOLA))
    return table[np.hypot(table.sx, table.sy) > LEAST_SAGITTA * extent]


def free_falls(time: np.ndarray, x: np.ndarray, y: np.ndarray) -> list[Fall]:
    """Windows of rows in which y is a parabola, to LARGEST_MISFIT of its sagitta, and x
    has no acceleration; times must increase."""
    w = parabolas_in(time, x, y)
    worth = w.sy.abs() - w.my / LARGEST_MISFIT
    falls = (worth > 0) & (w.sx.abs() < LARGEST_SIDEWAYS * w.sy.abs())
    return [Fall(*each) for each in zip(w.ay[falls], worth[falls], strict=True)]


def free_fall(time: np.ndarray, x: np.ndarray, y: np.ndarray) -> Fall | None:
    """The free flight of greatest worth; None where nothing falls."""
    return _best(free_falls(time, x, y))


def _best(falls: Iterable[Fall]) -> Fall | None:
    return max(falls, key=lambda fall: fall.worth, default=None)


def fits_gravity(acceleration_mm_s2: float) -> bool:
    """Whether an acceleration is that of gravity, to TOLERANCE."""
    return abs(abs(acceleration_mm_s2) / (1000 * G_M_S2) - 1) < TOLERANCE


def unit_doubt(falls: list[Fall], mm: float, seconds: float, whole: bool) -> str:
    """A question where no flight of a track has the acceleration of gravity in its
    units; "" where one has, or there is none. falls: in units of `mm` millimetres, and
    in seconds; the file's unit of time is `seconds`. whole: its times are whole
    numbers."""
    given = np.array([abs(fall.acceleration) * mm / 1000 for fall in falls])
    others = {f"times {word}": (seconds / unit) ** 2 for word, unit in _TIMES.items()}
    others |= {f"lengths {word}": unit / mm for word, unit in _LENGTHS.items()}
    near = [
        words
        for words, k in others.items()
        if given.size
        and k != 1
        and np.mean(np.abs(k * given / G_M_S2 - 1) < TOLERANCE) > MOST
    ]
    possible = (given > (1 / 3 if near else LEAST) * G_M_S2) & (
        given < GREATEST * G_M_S2
    )
    if not falls or possible.any():
        return ""
    best = float(given[max(range(len(falls)), key=lambda k: falls[k].worth)])
    if whole:
        near.insert(
            0, f"times frame numbers, at {np.sqrt(G_M_S2 / best):.4g} frames per second"
        )
    asked = f": are the {' or the '.join(near)}?"
    meant = asked if near else ": in which units are its times and lengths?"
    shown = f"{best:,.0f}" if 100 <= best < 1e9 else f"{best:.3g}"
    return f"the fall accelerates by {shown} m/s²{meant}"


def infer_units(path: Path, tool: str, told: Tracked) -> Contents:
    """The tracks in mm and s, y up, as contents of the file; MeasurementError where
    there is no track."""
    guesses, questions = [*told.guesses], [*told.questions]
    read = tracks_of(path, told.listed)
    seconds, time_unit = _clock(path, read, told.time_unit.lower(), guesses, questions)
    found = tuple(replace(t, time=t.time * seconds) for t in read)
    each = [free_falls(t.time, t.x, t.y) for t in found]
    falls = [*chain.from_iterable(each)]
    fall, best = _best(falls), map(_best, each)
    stated = LENGTH.get(told.length_unit.lower()) if time_unit == "s" else None
    aside = fall is None and stated is not None and _falls_aside(found, stated)
    if aside:
        guesses.append("it falls along x: its picture lies on its side")
    down = told.up == "down"
    if not told.up and not aside:
        down = _goes_down(fall, guesses, questions)
    length_unit = told.length_unit.lower() or _likely_unit(
        found, fall, time_unit, guesses
    )
    pixels, doubt, mm = length_unit in ("", *PIXELS), "", 1.0
    if not pixels:
        mm = _factor(path, "length", length_unit, LENGTH)
    elif SCALE.beside(told.keys) and SCALE.answer not in {q.answer for q in questions}:
        questions.append(SCALE if length_unit else UNITLESS)
    if time_unit == "s" and not pixels:
        doubt = unit_doubt(falls, mm, seconds, _whole(*(t.time for t in read)))
    up = -mm if down else mm
    return Contents(
        tool,
        tuple(
            PointTrack(t.name, t.time, mm * t.x, up * t.y, up * f.acceleration)
            if f
            else replace(t, x=mm * t.x, y=up * t.y)
            for t, f in zip(found, best, strict=True)
        ),
        time_unit,
        "px" if pixels else "mm",
        keys=told.keys,
        guesses=tuple(guesses),
        questions=tuple(questions),
        doubt=doubt,
        unitless=not length_unit,
        repeats=told.repeats and len(found) > 1,
        aside=aside,
    )


def _whole(*numbers: np.ndarray) -> bool:
    return all((n == np.round(n)).all() for n in numbers)


def _factor(path: Path, what: str, unit: str, units: dict[str, float]) -> float:
    require(
        unit in units,
        f"{path}: its unit of {what} is {unit[:30]!r}; known are"
        f" {', '.join(list(units)[:12])} …",
    )
    return units[unit]


def _clock(
    path: Path,
    tracks: Sequence[PointTrack],
    unit: str,
    guesses: list[str],
    questions: list[Asked],
) -> tuple[float, str]:
    """The file's unit of time in seconds, and "s"; or 1 and "frame"."""
    if not unit:
        step = float(np.median(np.concatenate([np.diff(t.time) for t in tracks])))
        counted = step == round(step) < 10 and _whole(*(t.time for t in tracks))
        unit = "frame" if counted else "ms" if step > _SLOWEST_STEP_S else "s"
        guesses.append(
            "times are frame numbers: they are whole, one after the other"
            if counted
            else f"times in {'milliseconds' if unit == 'ms' else 'seconds'}, which the"
            f" file does not say: the rows are {step:.4g} apart"
        )
    if unit in FRAMES:
        questions.append(RATE)
        return 1.0, "frame"
    return _factor(path, "time", unit, TIME), "s"


def _falls_aside(tracks: tuple[PointTrack, ...], mm: float) -> bool:
    """Whether something falls along x, with the acceleration of gravity in the units
    that the file states."""
    falls = (free_fall(t.time, t.y, t.x) for t in tracks)
    return any(fall and fits_gravity(fall.acceleration * mm) for fall in falls)


def _goes_down(fall: Fall | None, guesses: list[str], questions: list[Asked]) -> bool:
    """Whether y is down in a file that does not state it."""
    if fall is None:
        asked = "is y up in it? Nothing falls freely by which to tell; taken as up"
        questions.append(Asked(asked))
    elif fall.acceleration > 0:
        guesses.append(
            "y is down in the file, as in a picture: the fall goes towards greater y;"
            " turned to y up"
        )
        return True
    return False


def _likely_unit(
    tracks: tuple[PointTrack, ...],
    fall: Fall | None,
    time_unit: str,
    guesses: list[str],
) -> str:
    """The unit of lengths in a file that does not state it, of LENGTH or PIXELS; ""
    where nothing tells it."""
    if _whole(*(place for t in tracks for place in (t.x, t.y))):
        guesses.append("lengths are pixels: they are whole numbers")
        return "px"
    fitting = [
        (u, abs(fall.acceleration) * LENGTH[u])
        for u in _WITHOUT_UNIT
        if fall is not None
        and time_unit == "s"
        and fits_gravity(fall.acceleration * LENGTH[u])
    ]
    if len(fitting) != 1:
        return ""
    ((unit, found),) = fitting
    guesses.append(
        f"lengths in {unit}, which the file does not say: so the fall accelerates by"
        f" {found / 1000:.3g} m/s²"
    )
    return unit
