"""Gravity as the judge of units: how a tracked thing falls freely says whether its lengths and times can be what they are taken for."""

from dataclasses import dataclass

import numpy as np

G_M_S2 = 9.81
LOOSE = 0.25  # relative: perspective, a scale off by some percent, air
LARGEST_MISFIT = 0.03  # rms beside a parabola, of its sagitta: a bounce in the window leaves 0.05
LEAST_SAGITTA = 0.02  # of all of the motion along y
LARGEST_SIDEWAYS = 0.15  # acceleration across, beside that along y: a roll down an incline has both
MOST_POINTS = 3000
_TIMES = {"milliseconds": 1e-3, "minutes": 60.0}
_LENGTHS = {"metres": 1000.0, "centimetres": 10.0, "inches": 25.4, "micrometres": 1e-3}


@dataclass(frozen=True)
class Fall:
    """The longest free flight in a track: its acceleration along y (positive upwards of y), and the time that it lasts."""

    acceleration: float
    duration: float


def free_fall(time: np.ndarray, x: np.ndarray, y: np.ndarray) -> Fall | None:
    """The flight of the greatest sagitta, in the track's own units; None where nothing falls.

    A window of rows is a flight where a parabola fits y to LARGEST_MISFIT of its sagitta, and x keeps its speed; a worse fit counts
    against a longer window, so that the rest before a release stays out.
    """
    step = max(1, len(time) // MOST_POINTS)
    time, x, y = time[::step], x[::step], y[::step]
    if len(time) < 5 or np.ptp(time) <= 0:
        return None
    best, greatest, height = None, 0.0, float(np.ptp(y))
    lengths = sorted({int(n) for n in np.geomspace(5, len(time), 24)})
    for n in lengths:
        for start in range(0, len(time) - n + 1, max(1, n // 8)):
            rows = slice(start, start + n)
            t = time[rows] - time[rows].mean()
            span = float(np.ptp(t))
            if span <= 0:
                continue
            powers = np.column_stack([np.ones(n), t / span, (t / span) ** 2])
            both = np.column_stack([y[rows], x[rows]])
            fitted, *_ = np.linalg.lstsq(powers, both, rcond=None)
            sagitta, aside = abs(fitted[2, 0]) / 4, abs(fitted[2, 1]) / 4
            misfit = float(np.std(both[:, 0] - powers @ fitted[:, 0]))
            worth = sagitta - misfit / LARGEST_MISFIT
            if worth > greatest and sagitta > LEAST_SAGITTA * height and aside < LARGEST_SIDEWAYS * sagitta:
                greatest, best = worth, Fall(2 * float(fitted[2, 0]) / span**2, span)
    return best


def fits_gravity(acceleration_mm_s2: float) -> bool:
    return abs(abs(acceleration_mm_s2) / (1000 * G_M_S2) - 1) < LOOSE


def unit_doubt(acceleration_mm_s2: float, whole: bool) -> str:
    """A question where a fall's acceleration cannot be gravity's in millimetres and seconds; "" where it can.

    whole: the times are whole numbers, as of frames. Accelerations up to three times off may have a wrong scale or frame rate,
    which is told elsewhere.
    """
    given = abs(acceleration_mm_s2) / 1000
    if not np.isfinite(given) or given == 0 or G_M_S2 / 3 < given < 3 * G_M_S2:
        return ""
    near = [f"times {word}" for word, k in _TIMES.items() if fits_gravity(1000 * given / k**2)]
    near += [f"lengths {word}" for word, k in _LENGTHS.items() if fits_gravity(1000 * given * k)]
    if whole and not near:
        near = [f"times frame numbers, at {np.sqrt(G_M_S2 / given):.4g} frames per second"]
    meant = f": are the {' or the '.join(near)}?" if near else ": in which units are its times and lengths?"
    return f"the fall accelerates by {_number(given)} m/s²{meant}"


def _number(value: float) -> str:
    return f"{value:,.0f}" if 100 <= value < 1e9 else f"{value:.3g}"
