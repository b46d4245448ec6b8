"""The ellipsoid that a seed's three axes span."""

import math

UNKNOWN_LONG = 0.3  # elongation of a seed of which no sizes are stated
ONE_SIZE_LONG = 0.05  # of one that is described by a single size


def ellipsoid_volume(length: float, width: float, thickness: float) -> float:
    """V = π L W T / 6, in the cube of the axes' unit.

    >>> round(ellipsoid_volume(2.0, 2.0, 2.0), 6)
    4.18879
    """
    return math.pi / 6 * length * width * thickness


def sphere_volume(diameter: float) -> float:
    """V = π d³ / 6, in the cube of the diameter's unit."""
    return ellipsoid_volume(diameter, diameter, diameter)


def elongation(sizes: list[float]) -> float:
    """(longest − shortest)/(longest + shortest) of the stated axes."""
    if not sizes:
        return UNKNOWN_LONG
    longest, shortest = max(sizes), min(sizes)
    one = ONE_SIZE_LONG if len(sizes) == 1 else 0.0
    return one or (longest - shortest) / (longest + shortest)
