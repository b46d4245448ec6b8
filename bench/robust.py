"""Robust standard deviations: from medians, which outliers do not move."""

import math

import numpy as np


def robust_sd(deviations: np.ndarray) -> float:
    """1.4826 times the median of |deviations|: the sd of normal values about 0."""
    return 1.4826 * float(np.median(np.abs(deviations)))


def difference_noise(values: np.ndarray, order: int) -> float:
    """Noise of single values from their differences of an order, which no slower change
    contains."""
    return robust_sd(np.diff(values, order)) / math.sqrt(math.comb(2 * order, order))
