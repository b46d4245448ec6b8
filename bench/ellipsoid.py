"""The ellipsoid that a seed's three axes span."""

import math


def ellipsoid_volume(length: float, width: float, thickness: float) -> float:
    """V = π L W T / 6, in the cube of the axes' unit.

    >>> round(ellipsoid_volume(2.0, 2.0, 2.0), 6)
    4.18879
    """
    return math.pi / 6 * length * width * thickness


def sphere_volume(diameter: float) -> float:
    """V = π d³ / 6, in the cube of the diameter's unit."""
    return ellipsoid_volume(diameter, diameter, diameter)
