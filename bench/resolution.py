"""The step to which an instrument was read."""

import numpy as np

# of people, protractors and displays, in the unit of the reading
STEPS = (5.0, 2.0, 1.0, 0.5, 0.25, 0.2, 0.1, 0.05, 0.02)
STEPS_OF_EQUAL = (1.0, 0.5, 0.1, 0.05)  # equal readings tell no coarser or odder one
EXACT = 1e-6  # of readings that are written as read


def reading_step(values: np.ndarray, rounding: float = EXACT) -> float:
    """The largest of STEPS of which all `values` (n,) are multiples but for how they
    were rounded when written; 0: none.

    >>> reading_step(np.array([21.5, 22.0, 22.5])), reading_step(np.array([22.0, 22.0]))
    (0.5, 1.0)
    """
    values = np.asarray(values, dtype=float)
    steps = STEPS_OF_EQUAL if len(values) and np.ptp(values) == 0 else STEPS
    return max((step for step in steps if on_grid(values, step, rounding)), default=0.0)


def on_grid(values: np.ndarray, step: float, rounding: float = EXACT) -> bool:
    """Whether all of some values (n,) are within `rounding` of a multiple of a step."""
    off = values - step * np.round(values / step)
    return bool(len(values)) and bool((np.abs(off) < rounding).all())
