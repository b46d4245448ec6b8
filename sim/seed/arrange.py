"""Arrangements of balls whose union approximates an ellipsoid: in a row, or in a
plane."""

import numpy as np
from scipy.optimize import least_squares

from benchtwin.sim.seed.surface import directions, ellipsoid_radius, union_radius

Array = np.ndarray

# below this length over √(width·thickness) the balls of a row all but coincide
ROUNDEST_AXIAL = 1.02


def axial(
    length_m: float, width_m: float, thickness_m: float, spheres: int
) -> tuple[Array, Array]:
    """Balls along the long axis, each touching a spheroid from inside: centres (n, 3)
    [m], radii (n,) [m].

    Spheroid of half axes a = length/2, b = √(width·thickness)/2: a row of balls is a
    body of revolution, so width and thickness both become their geometric mean, which
    keeps the cross-section's area. The end balls have the radius of curvature of the
    tips, b²/a, so the length is exact. Balls stand at x = f sin θ with f² = a² - b² and
    θ in equal steps (closer where they are smaller), r = b √(1 - x²/f²). One ball: the
    sphere of the ellipsoid's volume. For 8.72 × 6.84 × 5.98 mm and 5 balls the surface
    is 0.13 mm (rms) from the ellipsoid, 0.12 mm at best for any row of 5.

    Raises ValueError for more than one ball when length < 1.02 √(width·thickness), and
    where so few balls would not touch. Arrangement: Fig. 1 of the soybean calibration
    paper (five balls of different radii along the long axis)."""
    if spheres == 1:
        return np.zeros((1, 3)), np.array(
            [(length_m * width_m * thickness_m) ** (1 / 3) / 2.0]
        )
    a, b = length_m / 2.0, np.sqrt(width_m * thickness_m) / 2.0
    if a < ROUNDEST_AXIAL * b:
        raise ValueError(
            f"length_m = {length_m:g} is {a / b:.3f} × √(width·thickness); a row of"
            f" {spheres} balls needs at least {ROUNDEST_AXIAL}: take spheres=1 for a"
            " seed this round"
        )
    focus = np.sqrt(a**2 - b**2)
    x = focus * np.sin(np.linspace(-1.0, 1.0, spheres) * np.arcsin(focus / a))
    centres = np.zeros((spheres, 3))
    centres[:, 0] = x
    radii = b * np.sqrt(1.0 - (x / focus) ** 2)
    if np.any(np.diff(x) > radii[1:] + radii[:-1]):
        raise ValueError(
            f"spheres = {spheres}: too few to touch in a seed {a / b:.1f} times as long"
            " as thick"
        )
    return centres, radii


# so much must length exceed width, and width thickness: else balls all but coincide
PLANAR_MARGIN = 1.02

# Orbits of the planar arrangements: balls that mirror symmetry makes equal. Ends (±x,
# 0), flanks (0, ±y), fours (±x, ±y).
PLANAR = {6: "EF", 7: "EFC", 8: "EFW"}
_SIGNS = {
    "C": np.array([[0, 0]]),
    "E": np.array([[1, 0], [-1, 0]]),
    "W": np.array([[0, 1], [0, -1]]),
    "F": np.array([[1, 1], [1, -1], [-1, 1], [-1, -1]]),
}
_START = {
    "C": (0.0, 0.0, 1.0),
    "E": (0.7, 0.0, 0.88),
    "W": (0.0, 0.75, 0.97),
    "F": (0.25, 0.8, 0.96),
}


def planar(
    length_m: float, width_m: float, thickness_m: float, spheres: int
) -> tuple[Array, Array]:
    """Balls in the plane of length and width, fitted to the ellipsoid: centres (n, 3)
    [m], radii (n,) [m]; 6, 7 or 8 balls.

    Keeps width and thickness apart, which a row of balls cannot. Positions and radii
    minimise the mean square radial distance to the ellipsoid (least squares over 400
    directions, mirror symmetry kept), so no dimension is met exactly: 8.72 × 6.84 ×
    5.98 mm with 6 balls: 0.06 mm rms. Takes 10 to 20 ms a seed.

    Raises ValueError for another number of balls, or unless length > width > thickness
    by 2 % each."""
    if spheres not in PLANAR:
        raise ValueError(
            f"spheres = {spheres}: the planar arrangement has"
            f" {', '.join(map(str, PLANAR))} balls"
        )
    if length_m < PLANAR_MARGIN * width_m or width_m < PLANAR_MARGIN * thickness_m:
        raise ValueError(
            f"length_m, width_m, thickness_m = {length_m:g}, {width_m:g},"
            f" {thickness_m:g}: the planar arrangement needs each at least 2 % above"
            " the next; take arrangement='axial'"
        )
    halves = np.array([length_m, width_m, thickness_m]) / 2.0
    a, b, c = halves
    # where the centres of balls touching on both faces may lie
    medial = np.array([a - c**2 / a, b - c**2 / b])
    orbits = PLANAR[spheres]
    u, _ = directions(400)
    target = ellipsoid_radius(u, halves)

    start = np.array([_START[o] for o in orbits])
    free = start != 0.0  # balls on a mirror stay there

    def balls(q: Array) -> tuple[Array, Array]:
        rows = np.zeros_like(start)
        rows[free] = np.abs(q)  # positions and radii enter even: the sign says nothing
        centres = [
            np.c_[_SIGNS[o] * row[:2] * medial, np.zeros(len(_SIGNS[o]))]
            for o, row in zip(orbits, rows)
        ]
        return np.vstack(centres), np.concatenate(
            [np.full(len(_SIGNS[o]), row[2] * c) for o, row in zip(orbits, rows)]
        )

    fit = least_squares(
        lambda q: (union_radius(u, *balls(q)) - target) / c, start[free], method="lm"
    )
    return balls(fit.x)
