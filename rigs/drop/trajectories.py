"""Flights under gravity and any force that depends on velocity and spin, all at once.

x(t) = x₀ + v₀ τ + ∬ a(v),  τ = t − middle of the flight: Picard iteration on a(v) at
Chebyshev–Lobatto points, exact for parabolas and to 1e-9 of the fall for drag. Source:
Clenshaw & Norton (1963), Comput. J. 6, 88."""

import numpy as np
from numpy.polynomial import chebyshev

POINTS = 16
MAX_ITERATIONS = 60
NODES = -np.cos(np.pi * np.arange(POINTS) / (POINTS - 1))
_TO_COEFFICIENTS = np.linalg.inv(chebyshev.chebvander(NODES, POINTS - 1))
_ONCE = np.array(
    [chebyshev.chebint(c, lbnd=0) for c in _TO_COEFFICIENTS.T]
)  # (points, degree): ∫₀ of each cardinal function
_TWICE = np.array([chebyshev.chebint(c, m=2, lbnd=0) for c in _TO_COEFFICIENTS.T])
_AT_ENDS = np.eye(POINTS)[[0, -1]]  # of each cardinal function, and its slope there
_SLOPES_AT_ENDS = np.array(
    [chebyshev.chebval([-1, 1], chebyshev.chebder(c)) for c in _TO_COEFFICIENTS.T]
).T
_SPEEDS_AT_NODES = chebyshev.chebvander(NODES, POINTS) @ _ONCE.T


def accelerations(
    speeds: np.ndarray, half: np.ndarray, force, near: np.ndarray | None = None
) -> np.ndarray:
    """a (F, POINTS, 2) of a force(velocity) on flights that have `speeds` in their
    middle; near: others, from which to begin."""
    begun = np.zeros((len(half), POINTS, 2)) if near is None else near
    velocity = speeds_at_nodes(speeds, half, begun)
    for _ in range(MAX_ITERATIONS):
        now = force(velocity)
        after = speeds_at_nodes(speeds, half, now)
        moved = np.abs(after - velocity).max()
        velocity = after
        if moved < 1e-10:
            break
    return force(velocity)


def speeds_at_nodes(
    speeds: np.ndarray, half: np.ndarray, push: np.ndarray
) -> np.ndarray:
    """Velocities (…, F, POINTS, 2) of flights that pass their middle with `speeds` (…,
    F, 2)."""
    return speeds[..., None, :] + half[:, None, None] * (_SPEEDS_AT_NODES @ push)


def shift_basis(tau: np.ndarray, half: np.ndarray) -> np.ndarray:
    """(n, POINTS): displacement at τ by unit acceleration at each node, in half²; half
    (n,). Beyond the nodes the acceleration goes on as a straight line."""
    edge, beyond, side = _beyond(tau / half)
    shift = chebyshev.chebvander(edge, POINTS + 1) @ _TWICE.T
    if beyond.any():
        shift += beyond * (chebyshev.chebvander(edge, POINTS) @ _ONCE.T)
        shift += beyond**2 / 2 * _AT_ENDS[side] + beyond**3 / 6 * _SLOPES_AT_ENDS[side]
    return shift


def speed_basis(tau: np.ndarray, half: np.ndarray) -> np.ndarray:
    """(n, POINTS): the same for the velocity, in units of half."""
    edge, beyond, side = _beyond(tau / half)
    speed = chebyshev.chebvander(edge, POINTS) @ _ONCE.T
    if beyond.any():
        speed += beyond * _AT_ENDS[side] + beyond**2 / 2 * _SLOPES_AT_ENDS[side]
    return speed


def _beyond(place: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Places clipped to the nodes' range, how far they lie beyond it (n, 1), and at
    which end."""
    edge = np.clip(place, -1.0, 1.0)
    return edge, (place - edge)[:, None], (place > 0).astype(int)


def positions_at_nodes(
    starts: np.ndarray, half: np.ndarray, push: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Places and velocities (F, POINTS, 2) for starts and accelerations."""
    tau = half[:, None, None] * NODES[None, :, None]
    shift = (
        np.einsum(
            "ij,fjc->fic", chebyshev.chebvander(NODES, POINTS + 1) @ _TWICE.T, push
        )
        * half[:, None, None] ** 2
    )
    return starts[:, None, :2] + starts[:, None, 2:4] * tau + shift, speeds_at_nodes(
        starts[:, 2:4], half, push
    )
