"""Outlines of a turning ellipsoid in the picture."""

import numpy as np
from numba import njit

from prove.cases.ellipsoid import rotation


@njit(cache=True)
def outlines(rows, axes):
    """(n, 2, 2) of states (n, 13): points p from the centre with pᵀ S⁻¹ p = 1 are the outline [m²]."""
    out = np.zeros((len(rows), 2, 2))
    for i in range(len(rows)):
        r = rotation(rows[i, 6:10])
        for k in range(3):
            out[i, 0, 0] += (r[0, k] * axes[k]) ** 2
            out[i, 0, 1] += r[0, k] * r[2, k] * axes[k] ** 2
            out[i, 1, 1] += (r[2, k] * axes[k]) ** 2
        out[i, 1, 0] = out[i, 0, 1]
    return out


def angle(shapes: np.ndarray) -> np.ndarray:
    """The long axis's angle in the picture (n,), unwrapped [rad], anticlockwise."""
    twice = np.arctan2(2 * shapes[:, 0, 1], shapes[:, 0, 0] - shapes[:, 1, 1])
    return np.unwrap(twice) / 2
