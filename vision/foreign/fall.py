"""Gravity as the judge of units: how a tracked thing falls freely says whether its lengths and times can be what they are taken for."""

from dataclasses import dataclass

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

G_M_S2 = 9.81
LOOSE = 0.25  # relative: perspective, a scale off by some percent, air
LEAST, GREATEST = 0.05, 3.0  # of g: a light ball near its final speed; a scale or frame rate that is told to be wrong elsewhere
MOST = 0.8  # of all flights: in another unit all are off alike, near a final speed each by as much as its speed
LARGEST_MISFIT = 0.03  # rms beside a parabola, of its sagitta: a bounce in the window leaves 0.05
LEAST_SAGITTA = 0.03  # of the motion's extent: less is noise beside a roll
LARGEST_SIDEWAYS = 0.15  # acceleration across, beside that along y: a roll down an incline has both
MOST_POINTS = 1000
_TIMES = {"seconds": 1.0, "milliseconds": 1e-3, "minutes": 60.0}
_LENGTHS = {"metres": 1000.0, "centimetres": 10.0, "millimetres": 1.0, "inches": 25.4, "micrometres": 1e-3}


@dataclass(frozen=True)
class Fall:
    """A free flight in a track: its acceleration along y (positive towards greater y), the time that it lasts, and how well it is
    told (its sagitta, less what its misfit takes from it), in the track's own units."""

    acceleration: float
    duration: float
    worth: float


def free_falls(time: np.ndarray, x: np.ndarray, y: np.ndarray) -> list[Fall]:
    """Windows of rows that are a flight: a parabola fits y to LARGEST_MISFIT of its sagitta, and x keeps its speed.

    The times increase.
    """
    step = max(1, len(time) // MOST_POINTS)
    time, x, y = time[::step], x[::step], y[::step]
    extent, found = max(float(np.ptp(x)), float(np.ptp(y))) if len(x) else 0.0, []
    for n in sorted({int(n) for n in np.geomspace(5, max(len(time), 5), 20)}):
        if n > len(time):
            break
        t, across, up = (sliding_window_view(column, n)[:: max(1, n // 6)] for column in (time, x, y))
        span = np.ptp(t, axis=1)
        s = (t - t.mean(axis=1, keepdims=True)) / span[:, None]
        powers = np.stack([np.ones_like(s), s, s**2], axis=2)  # windows × rows × 3
        both = np.stack([up, across], axis=2)
        squares = np.einsum("wri,wrj->wij", powers, powers)
        fitted = np.linalg.pinv(squares, hermitian=True) @ np.einsum("wri,wrk->wik", powers, both)
        misfit = np.std(up - np.einsum("wri,wi->wr", powers, fitted[:, :, 0]), axis=1)
        sagitta, aside = np.abs(fitted[:, 2, 0]) / 4, np.abs(fitted[:, 2, 1]) / 4
        worth = sagitta - misfit / LARGEST_MISFIT
        for k in np.flatnonzero((worth > 0) & (sagitta > LEAST_SAGITTA * extent) & (aside < LARGEST_SIDEWAYS * sagitta)):
            found.append(Fall(float(2 * fitted[k, 2, 0] / span[k] ** 2), float(span[k]), float(worth[k])))
    return found


def free_fall(time: np.ndarray, x: np.ndarray, y: np.ndarray) -> Fall | None:
    """The flight that is told best; None where nothing falls. The rest before a release stays out: it would fit worse."""
    return max(free_falls(time, x, y), key=lambda fall: fall.worth, default=None)


def fits_gravity(acceleration_mm_s2: float) -> bool:
    """Whether an acceleration [mm/s²] is that of gravity, up to LOOSE."""
    return abs(abs(acceleration_mm_s2) / (1000 * G_M_S2) - 1) < LOOSE


def unit_doubt(falls: list[Fall], mm: float, seconds: float, whole: bool) -> str:
    """A question where no flight of a track can be gravity's in its units; "" where one can, or nothing flies.

    falls: in units of `mm` millimetres, and in seconds; the file counts in units of `seconds`. whole: its times are whole numbers,
    as of frames.
    """
    given = np.array([abs(fall.acceleration) * mm / 1000 for fall in falls])
    others = {f"times {word}": (seconds / unit) ** 2 for word, unit in _TIMES.items()}
    others |= {f"lengths {word}": unit / mm for word, unit in _LENGTHS.items()}
    near = [words for words, k in others.items() if given.size and k != 1 and np.mean(np.abs(k * given / G_M_S2 - 1) < LOOSE) > MOST]
    possible = (given > (1 / 3 if near else LEAST) * G_M_S2) & (given < GREATEST * G_M_S2)
    if not falls or possible.any():
        return ""
    best = float(given[max(range(len(falls)), key=lambda k: falls[k].worth)])
    if whole:
        near.insert(0, f"times frame numbers, at {np.sqrt(G_M_S2 / best):.4g} frames per second")
    meant = f": are the {' or the '.join(near)}?" if near else ": in which units are its times and lengths?"
    return f"the fall accelerates by {_number(best)} m/s²{meant}"


def _number(value: float) -> str:
    return f"{value:,.0f}" if 100 <= value < 1e9 else f"{value:.3g}"
