"""Closed meshes of parametrised seed forms, each scaled to enclose its closed-form
volume: what clumps are tried on."""

import math

import numpy as np
from scipy.special import beta, erf

from benchtwin.sim.seed.forms import AROUND, RINGS, enlarge_to_volume, join_rings, rings
from benchtwin.sim.seed.shape import Shape
from benchtwin.sim.seed.surface import ellipsoid_mesh

Array = np.ndarray
LEAST_EXPONENT, MOST_EXPONENT = 0.1, 2.0
SINES = (2.0, 4.0 / 3.0, 16.0 / 15.0, 32.0 / 35.0)


def ellipsoid(length_m: float, width_m: float, thickness_m: float) -> Shape:
    """An ellipsoid with its axes along x, y, z; sizes [m]. V = π L W T/6."""
    mesh = ellipsoid_mesh(_halves(length_m, width_m, thickness_m), level=4)
    return Shape(mesh.vertices_m, mesh.faces)


def flattened_ellipsoid(
    length_m: float, width_m: float, thickness_m: float, flat_at: float
) -> Shape:
    """An ellipsoid cut off below z = -flat_at · thickness/2, 0 < flat_at < 1: a bean
    with a flat side; a ring of vertices runs along the edge, further ones across the
    flat.

    thickness_m [m] is that of the whole ellipsoid. V = a b c π (2/3 + f - f³/3), f =
    flat_at, a, b, c the half axes."""
    halves = _halves(length_m, width_m, thickness_m)
    if not 0.0 < flat_at < 1.0:
        raise ValueError(f"flat_at = {flat_at:g}: must be above 0 and below 1")
    rim = math.sqrt(1.0 - flat_at**2)
    # from the edge up to the pole, z = -sin
    cap = np.linspace(math.asin(flat_at), -math.pi / 2, RINGS)[:-1]
    z = np.concatenate([np.full(8, -flat_at), -np.sin(cap[1:])])
    radius = np.concatenate([np.linspace(1 / 8, 1.0, 8) * rim, np.cos(cap[1:])])
    vertices, faces = rings(radius, z, -flat_at, 1.0)
    volume = math.pi * (2.0 / 3.0 + flat_at - flat_at**3 / 3.0)
    volume *= float(np.prod(halves))
    return Shape(*enlarge_to_volume(vertices * halves, faces, volume))


def superquadric(
    length_m: float,
    width_m: float,
    thickness_m: float,
    *,
    across: float,
    along: float,
    taper: float = 0.0,
) -> Shape:
    """(|x/a|^(2/along) + |y/b|^(2/along))^(along/across) + |z/c|^(2/across) = 1, the
    width times 1 + taper·x/a.

    Exponents 0.1 to 2: along shapes the outline in x and y, across the section; 1, 1 is
    the ellipsoid, towards 0 a box. taper, -0.9 to 0.9, makes a wedge (Barr 1984). V =
    2 a b c e1 e2 B(e1/2 + 1, e1) B(e2/2, e2/2) with e1 = across, e2 = along (Jaklič et
    al. 2000), whatever the taper."""
    halves = _halves(length_m, width_m, thickness_m)
    for name, value in (("across", across), ("along", along)):
        if not LEAST_EXPONENT <= value <= MOST_EXPONENT:
            raise ValueError(
                f"{name} = {value:g}: must be {LEAST_EXPONENT:g} to {MOST_EXPONENT:g}"
            )
    if not abs(taper) <= 0.9:
        raise ValueError(f"taper = {taper:g}: must be -0.9 to 0.9")
    radius, z = _superellipse(
        np.linspace(-np.pi / 2, np.pi / 2, RINGS + 1)[1:-1], across
    )
    turn = np.linspace(0.0, 2 * np.pi, AROUND, endpoint=False)
    unit = np.stack(_superellipse(turn, along), axis=1)
    vertices, faces = rings(radius, z, -1.0, 1.0, unit)
    vertices = vertices * halves
    volume = (
        2.0
        * across
        * along
        * beta(across / 2 + 1, across)
        * beta(along / 2, along / 2)
        * float(np.prod(halves))
    )
    vertices, faces = enlarge_to_volume(vertices, faces, volume)
    vertices[:, 1] *= 1.0 + taper * vertices[:, 0] / halves[0]
    return Shape(vertices, faces)


def _superellipse(angle: Array, exponent: float) -> tuple[Array, Array]:
    """Points of |x|^(2/e) + |y|^(2/e) = 1 in the directions `angle`, which spread
    evenly where cos^e, sin^e would crowd."""
    c, s = np.cos(angle), np.sin(angle)
    far = (np.abs(c) ** (2 / exponent) + np.abs(s) ** (2 / exponent)) ** (-exponent / 2)
    return far * c, far * s


def creased_ellipsoid(
    length_m: float,
    width_m: float,
    thickness_m: float,
    *,
    depth: float,
    half_width_deg: float,
) -> Shape:
    """An ellipsoid with a furrow along its length on the side -z, as a grain of wheat
    has it.

    In the ellipsoid's own units the radius is 1 - depth sin²θ exp(-ψ²/2w²): θ from the
    long axis, ψ about it from -z, w = half_width_deg (a standard deviation, 3 to 40),
    depth 0 to 0.6 of the half thickness."""
    halves = _halves(length_m, width_m, thickness_m)
    if not 0.0 <= depth <= 0.6:
        raise ValueError(f"depth = {depth:g}: must be 0 to 0.6 of the half thickness")
    if not 3.0 <= half_width_deg <= 40.0:
        raise ValueError(f"half_width_deg = {half_width_deg:g}: must be 3 to 40")
    w = math.radians(half_width_deg)
    fine = np.linspace(-3.5 * w, 3.5 * w, AROUND // 2 + 1)
    rest = np.linspace(3.5 * w, 2 * np.pi - 3.5 * w, AROUND // 2 + 1)
    psi = np.concatenate([fine[:-1], rest[:-1]])  # from -z, about x
    furrow = depth * np.exp(
        -(np.where(psi > np.pi, psi - 2 * np.pi, psi) ** 2) / (2 * w * w)
    )
    polar = np.linspace(np.pi, 0.0, RINGS + 1)[1:-1]
    far = 1.0 - np.sin(polar)[:, None] ** 2 * furrow
    x, across = far * np.cos(polar)[:, None], far * np.sin(polar)[:, None]
    rows = np.stack([x, across * np.sin(psi), -across * np.cos(psi)], axis=2)
    vertices, faces = join_rings(rows, np.array([-1.0, 0, 0]), np.array([1.0, 0, 0]))
    volume = float(np.prod(halves)) * creased_volume(depth, w)
    return Shape(*enlarge_to_volume(vertices * halves, faces, volume))


def creased_volume(depth: float, w: float) -> float:
    """∫ (1 - d sin²θ exp(-ψ²/2w²))³/3 dΩ, term by term: ∫ sin^(2k+1) = 2, 4/3, 16/15,
    32/35; the Gaussians by erf."""
    gauss = [2 * np.pi] + [
        w * math.sqrt(2 * np.pi / k) * erf(np.pi * math.sqrt(k / 2) / w)
        for k in (1, 2, 3)
    ]
    return sum(
        weight * (-depth) ** k * sine * g / 3
        for k, (weight, sine, g) in enumerate(zip((1, 3, 3, 1), SINES, gauss))
    )


def _halves(length_m: float, width_m: float, thickness_m: float) -> Array:
    sizes = np.array([length_m, width_m, thickness_m], float)
    if not ((sizes > 0) & np.isfinite(sizes)).all():
        raise ValueError(
            f"length_m, width_m, thickness_m = {length_m:g}, {width_m:g},"
            f" {thickness_m:g}: must be above 0"
        )
    return sizes / 2.0
