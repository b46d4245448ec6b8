"""Readings that lie on a grid: the plate was raised in steps, or the angle rounded to them."""

import math

import numpy as np

FINEST_DEG = 0.1  # what a goniometer is read to: grids of that and less are its resolution
COARSEST_DEG = 5.0
NEAR_DEG = 0.011  # how well a reading sits on its grid
ROUNDED_SD_DEG = 0.01 / math.sqrt(12)  # of a reading to a hundredth of a degree, the same each time that a stair is read
CHANCE = 1e-3
PARTS = 5  # of the least difference between two readings that may be the spacing
SPACING_SD = 0.005  # relative
RUN_SD_DEG = 0.15  # by which runs differ: ± 0.003 of friction
SPAN_SD = 4.4  # range of some dozens of them, over their sd


def grid_of(readings: list[np.ndarray]) -> tuple[float, float, float] | None:
    """Spacing [deg] of the coarsest grid on which all readings lie, with its 95 % range; None where chance would do it too.

    Readings to FINEST would all lie on a grid of spacing h, wherever it begins, with a chance of (FINEST/h)^(n − 2), once for
    every grid that is tried. Where all are one and the same, though friction differs from run to run, the stair is wider than
    they are.

    >>> grid_of([np.array([21.5, 22.0, 22.0, 22.5, 21.5, 22.0, 21.5, 22.0])])[0]
    0.5
    >>> grid_of([np.array([21.5, 22.1, 21.9, 22.6, 21.7, 22.0])])
    >>> grid_of([np.array([21.74, 23.30, 21.74, 21.74, 23.30, 23.30])])[0]
    1.56
    """
    values = np.concatenate(readings) if readings else np.zeros(0)
    n, seen = len(values), np.unique(np.round(values, 2))
    if len(seen) == 1:
        return _one_stair(n)
    for part in range(1, PARTS + 1) if len(seen) else ():
        spacing = float(np.diff(seen).min()) / part
        number = np.round((values - seen[0]) / spacing)
        stairs = np.unique(number)
        spacing = float(np.polyfit(stairs, [values[number == k].mean() for k in stairs], 1)[0])
        off = values - seen[0] - spacing * number
        if np.ptp(off) < 2 * NEAR_DEG and spacing > FINEST_DEG and PARTS * (FINEST_DEG / spacing) ** (n - 2) < CHANCE:
            rounded = ROUNDED_SD_DEG / math.sqrt(float(((stairs - stairs.mean()) ** 2).sum()))
            half = 1.96 * math.hypot(SPACING_SD * spacing, rounded)
            return round(spacing, 3), spacing - half, spacing + half
    return None


def _one_stair(n: int) -> tuple[float, float, float] | None:
    """Of n equal readings: two differ by less than FINEST with a chance of FINEST/(2 √π sd)."""
    if (FINEST_DEG / (2 * math.sqrt(math.pi) * RUN_SD_DEG)) ** (n - 1) > CHANCE:
        return None
    low = SPAN_SD * RUN_SD_DEG
    return math.sqrt(low * COARSEST_DEG), low, COARSEST_DEG
