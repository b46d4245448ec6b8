"""Readings that lie on a grid: the plate was raised in steps, or the angle rounded to them."""

import numpy as np

FINEST_DEG = 0.1  # what a goniometer is read to: grids of that and less are its resolution
GRIDS_DEG = (5.0, 3.0, 2.5, 2.0, 1.5, 1.25, 1.0, 0.8, 0.75, 0.6, 0.5, 0.4, 0.3, 0.25, 0.2)
NEAR_DEG = 0.011  # how well a reading sits on its grid
CHANCE = 1e-3
LEAST_VALUES = 2  # different readings, without which the grid's spacing is not seen


def grid_of(readings: list[np.ndarray]) -> float | None:
    """Spacing [deg] of the coarsest grid on which all readings lie, None where chance would do it too.

    Readings to FINEST would all lie on a grid of spacing h with a chance of (FINEST/h)^n, once for every grid that is tried.

    >>> grid_of([np.array([21.5, 22.0, 22.0, 22.5, 21.5, 22.0])])
    0.5
    >>> grid_of([np.array([21.5, 22.1, 21.9, 22.6, 21.7, 22.0])])
    """
    values = np.concatenate(readings) if readings else np.zeros(0)
    if len(np.unique(np.round(values, 2))) < LEAST_VALUES:
        return None
    for spacing in GRIDS_DEG:
        off = np.abs(values - spacing * np.round(values / spacing))
        if (off < NEAR_DEG).all() and len(GRIDS_DEG) * (FINEST_DEG / spacing) ** len(values) < CHANCE:
            return float(spacing)
    return None
