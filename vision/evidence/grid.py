"""How finely an instrument was read: the grid on which all of its readings lie."""

import numpy as np

GRIDS = (5.0, 2.0, 1.0, 0.5, 0.25, 0.2, 0.1, 0.05)  # on which people and displays read, in the unit that is read
ON_GRID = 1e-6


def grid_of(values: np.ndarray) -> float:
    """The coarsest of GRIDS on which all `values` (n,) lie, in their own unit; 0 where they lie on none.

    Readings that are all equal lie on the finest grid that their digits show, no coarser.
    """
    values = np.asarray(values, dtype=float)
    if len(values) and np.ptp(values) == 0:
        return max((g for g in (1.0, 0.5, 0.1, 0.05) if _on(values, g)), default=0.0)
    return max((g for g in GRIDS if _on(values, g)), default=0.0)


def _on(values: np.ndarray, grid: float) -> bool:
    return bool(len(values)) and bool((np.abs(values / grid - np.round(values / grid)) < ON_GRID).all())
