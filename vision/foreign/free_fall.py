"""Free falls in a track, and what their acceleration says about its units."""

from dataclasses import dataclass

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

G_M_S2 = 9.81
TOLERANCE = 0.25  # relative, of g: perspective, an error of the scale, air
LEAST, GREATEST = 0.05, 3.0  # of g: a light ball near terminal velocity; a wrong scale or frame rate, which is noticed elsewhere
MOST = 0.8  # share of the flights that a change of units must explain
LARGEST_MISFIT = 0.03  # rms about a parabola, of its sagitta: a bounce in the window gives 0.05
LEAST_SAGITTA = 0.03  # of the motion's extent: less is noise
LARGEST_SIDEWAYS = 0.15  # acceleration along x over that along y: a roll down an incline has both
MOST_POINTS = 1000
_TIMES = {"seconds": 1.0, "milliseconds": 1e-3, "minutes": 60.0}
_LENGTHS = {"metres": 1000.0, "centimetres": 10.0, "millimetres": 1.0, "inches": 25.4, "micrometres": 1e-3}


@dataclass(frozen=True)
class Fall:
    """A free flight in a track: acceleration along y, duration, and worth (sagitta less a multiple of the misfit), in the track's units."""

    acceleration: float
    duration: float
    worth: float


def free_falls(time: np.ndarray, x: np.ndarray, y: np.ndarray) -> list[Fall]:
    """Windows of rows in which y is a parabola, to LARGEST_MISFIT of its sagitta, and x has no acceleration; times must increase."""
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
    """The free flight of greatest worth; None where nothing falls."""
    return max(free_falls(time, x, y), key=lambda fall: fall.worth, default=None)


def fits_gravity(acceleration_mm_s2: float) -> bool:
    """Whether an acceleration is that of gravity, to TOLERANCE."""
    return abs(abs(acceleration_mm_s2) / (1000 * G_M_S2) - 1) < TOLERANCE


def unit_doubt(falls: list[Fall], mm: float, seconds: float, whole: bool) -> str:
    """A question where no flight of a track has the acceleration of gravity in its units; "" where one has, or there is none.

    falls: in units of `mm` millimetres, and in seconds; the file's unit of time is `seconds`. whole: its times are whole numbers.
    """
    given = np.array([abs(fall.acceleration) * mm / 1000 for fall in falls])
    others = {f"times {word}": (seconds / unit) ** 2 for word, unit in _TIMES.items()}
    others |= {f"lengths {word}": unit / mm for word, unit in _LENGTHS.items()}
    near = [words for words, k in others.items() if given.size and k != 1 and np.mean(np.abs(k * given / G_M_S2 - 1) < TOLERANCE) > MOST]
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
