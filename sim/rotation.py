"""Unit quaternions (w, x, y, z), singly or as rows."""

import numpy as np
from numpy.typing import ArrayLike


def cross(u: np.ndarray, v: np.ndarray) -> np.ndarray:
    """u × v (..., 3): `numpy.cross`, which spends more on one vector than on its
    product."""
    a, b, c = u[..., 0], u[..., 1], u[..., 2]
    x, y, z = v[..., 0], v[..., 1], v[..., 2]
    return np.stack([b * z - c * y, c * x - a * z, a * y - b * x], axis=-1)


def turned(q: np.ndarray, v: np.ndarray) -> np.ndarray:
    """Vectors (..., 3) turned by quaternions (..., 4)."""
    w, u = q[..., :1], q[..., 1:]
    twice = 2.0 * cross(u, v)
    return v + w * twice + cross(u, twice)


def product(p: ArrayLike, q: ArrayLike) -> np.ndarray:
    """The turns q (..., 4) followed by the turns p."""
    a, b = np.asarray(p, float), np.asarray(q, float)
    w, u, z, v = a[..., :1], a[..., 1:], b[..., :1], b[..., 1:]
    scalar = w * z - (u * v).sum(axis=-1, keepdims=True)
    return np.concatenate([scalar, w * v + z * u + cross(u, v)], axis=-1)


def about(axis: ArrayLike, angle_rad: float) -> np.ndarray:
    """A right-handed turn about a unit axis."""
    half = angle_rad / 2
    return np.concatenate([[np.cos(half)], np.sin(half) * np.asarray(axis, float)])


def any_turn(rng: np.random.Generator) -> np.ndarray:
    """An orientation, every one as likely as any other."""
    q = rng.normal(size=4)
    return q / np.linalg.norm(q)
