"""The step to which an instrument was read."""

import numpy as np

STEPS = (
    5.0,
    2.0,
    1.0,
    0.5,
    0.25,
    0.2,
    0.1,
    0.05,
)  # of people and displays, in the unit of the reading
TOLERANCE = 1e-6


def reading_step(values: np.ndarray) -> float:
    """The largest of STEPS of which all `values` (n,) are multiples (of equal ones: 1,
    0.5, 0.1 or 0.05); 0: none."""
    values = np.asarray(values, dtype=float)
    if len(values) and np.ptp(values) == 0:
        return max(
            (g for g in (1.0, 0.5, 0.1, 0.05) if _multiples(values, g)), default=0.0
        )
    return max((g for g in STEPS if _multiples(values, g)), default=0.0)


def _multiples(values: np.ndarray, step: float) -> bool:
    return bool(len(values)) and bool(
        (np.abs(values / step - np.round(values / step)) < TOLERANCE).all()
    )
