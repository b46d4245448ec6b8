"""Fits n overlapping balls to a closed shape by least squares to its surface.

Sources. Where it begins: balls that touch the surface from inside, found by shrinking
(Ma, Bae, Choi, Vis. Comput. 28 (2012) 7-19), chosen as Ferellec & McDowell, Granular
Matter 12 (2010) 459-467 choose theirs, to cover the surface. The fit: surface
correspondence of balls and mesh as Price, Murariu, Morrison, Proc. Discrete Element
Methods (2007) have it, by alternating which ball each point belongs to and each ball's
own Gauss-Newton step, as in Lloyd's algorithm, with balls moved from where they are
least missed."""

import numpy as np
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from benchtwin.sim.seed.clump_error import CHECKED_POINTS, ClumpError, clump_error
from benchtwin.sim.seed.shape import Shape

Array = np.ndarray
Balls = tuple[Array, Array]

MOST_BALLS = 100
POINTS_A_BALL, LEAST_POINTS = 60, 900  # of the surface, to which balls are fitted
LEAST_RADIUS = 0.05  # of the mean radius: smaller balls are dents of the mesh
# a point this near, seen from a ball's centre, is a facet beside the one it touches:
# not another side
SAME_SIDE_DEG = 40.0
STEPS, MOVES = 60, 3  # of a fit; how often each ball may be moved elsewhere
# fits from balls drawn at random, and how many of the best are improved
STARTS = 24
BEST_STARTS = 3


def fit_clump(shape: Shape, spheres: int) -> tuple[Array, Array, ClumpError]:
    """Centres (n, 3) [m] and radii (n,) [m] in the shape's own frame, 1 to 100 of them,
    and their error; always the same ones.

    Fewer than `spheres` come back where there is no place for more. Raises ValueError
    for a number of balls that do not make one piece."""
    if not 1 <= spheres <= MOST_BALLS:
        raise ValueError(f"spheres = {spheres}: must be 1 to {MOST_BALLS}")
    own, axes, origin = shape.principal()
    unit = own.scaled(1.0 / own.mean_radius_m)
    centres, radii = _least_squares(unit, spheres)
    if not connected(centres, radii):
        raise ValueError(
            f"{spheres} balls for this shape do not touch each other: take more"
        )
    error = clump_error(unit, centres, radii)
    return (
        origin + own.mean_radius_m * centres @ axes.T,
        own.mean_radius_m * radii,
        error,
    )


def spheres_for(
    shape: Shape, tolerance: float, most: int
) -> tuple[int, list[ClumpError | None]]:
    """The fewest balls whose rms surface error is within `tolerance` (of the mean
    radius), and the errors of 1, 2, … so many.

    None stands for balls that do not make one piece. Raises ValueError where `most` do
    not suffice; it says what they reach."""
    errors: list[ClumpError | None] = []
    best = np.inf
    for n in range(1, most + 1):
        try:
            error = fit_clump(shape, n)[2]
        except ValueError:
            errors.append(None)
            continue
        errors.append(error)
        best = min(best, error.surface_rms)
        if best <= tolerance:
            return n, errors
    raise ValueError(
        f"tolerance = {100 * tolerance:g} %: {most} balls reach {100 * best:.2g} % of"
        " the mean radius, not less"
    )


def pieces(centres: Array, radii: Array) -> Array:
    """Which piece each ball belongs to, that of the first being 0."""
    apart = np.linalg.norm(centres[:, None] - centres, axis=2)
    return connected_components(apart <= radii[:, None] + radii)[1]


def connected(centres: Array, radii: Array) -> bool:
    """Whether the balls make one piece."""
    return not pieces(centres, radii).any()


def _medial_balls(shape: Shape) -> Balls:
    """Balls inside that touch the surface at two points and more, one for each of some
    points on it, by shrinking."""
    points, normals = shape.points(CHECKED_POINTS // 4)
    around, _ = shape.points(CHECKED_POINTS)
    tree, same = cKDTree(around), np.cos(np.radians(SAME_SIDE_DEG))
    radii = np.full(len(points), float(np.linalg.norm(np.ptp(around, axis=0))))
    for _ in range(30):
        centres = points - radii[:, None] * normals
        far, nearest = tree.query(centres)
        chord = points - around[nearest]
        depth = np.einsum("ki,ki->k", chord, normals)
        smaller = np.sum(chord**2, axis=1) / np.maximum(2.0 * depth, 1e-12)
        # cosine of the angle in which the smaller ball sees the two
        beside = 1.0 - depth / np.maximum(smaller, 1e-12) > same
        least = radii * (1 - 1e-3)
        shrinks = (far < least) & (smaller < least) & (depth > 0) & ~beside
        if not shrinks.any():
            break
        radii = np.where(shrinks, smaller, radii)
    keep = radii > LEAST_RADIUS
    return (points - radii[:, None] * normals)[keep], radii[keep]


def _choose_greedily(
    points: Array, centres: Array, radii: Array, spheres: int
) -> Balls:
    # (candidates, points)
    gap = np.linalg.norm(points - centres[:, None], axis=2) - radii[:, None]
    least = np.full(len(points), np.inf)
    chosen: list[int] = []
    for _ in range(min(spheres, len(radii))):
        cost = np.sum(np.minimum(gap, least) ** 2, axis=1)
        chosen.append(int(np.argmin(cost)))
        least = np.minimum(least, gap[chosen[-1]])
    kept = list(dict.fromkeys(chosen))
    return centres[kept], radii[kept]


def _point_count(spheres: int) -> int:
    return max(LEAST_POINTS, POINTS_A_BALL * spheres)


def _least_squares(shape: Shape, spheres: int) -> Balls:
    """The best of fits that start from the medial axis' balls, and from others of its
    balls; from the best, balls are moved."""
    points, _ = shape.points(_point_count(spheres))
    candidates = _medial_balls(shape)
    gaps = (
        np.linalg.norm(points - candidates[0][:, None], axis=2) - candidates[1][:, None]
    )
    rng = np.random.default_rng(0)  # the same starts each time
    drawn = [rng.permutation(len(candidates[1]))[:spheres] for _ in range(STARTS)]
    starts = [
        _choose_greedily(points, *candidates, spheres),
        *((candidates[0][k], candidates[1][k]) for k in drawn),
    ]
    fits = [
        _fit_balls(points, *_add_balls(points, start, candidates, gaps, spheres))
        for start in starts
    ]
    fits = [
        _improve(points, fit, candidates, gaps)
        for fit in sorted(fits, key=_cost)[:BEST_STARTS]
    ]
    best = min(fits, key=_cost)
    return _drop_hidden(best[0], best[1])


Fit = tuple[Array, Array, float]  # centres, radii, sum of squares


def _cost(fit: Fit) -> float:
    """The sum of squares, with a penalty for a clump in several pieces."""
    return fit[2] if connected(fit[0], fit[1]) else 1e6 + fit[2]


def _improve(points: Array, fit: Fit, candidates: Balls, gaps: Array) -> Fit:
    """Move one ball at a time as long as the cost falls; at most MOVES times the number
    of balls."""
    for _ in range(MOVES * len(fit[1])):
        moved = _move_one_ball(points, fit, candidates, gaps)
        if _cost(moved) >= _cost(fit) * (1 - 1e-4):
            break
        fit = moved
    return fit


def _add_balls(
    points: Array, balls: Balls, candidates: Balls, gaps: Array, spheres: int
) -> Balls:
    """Add candidate balls, each time the one that lowers the cost most, until there are
    `spheres`."""
    centres, radii = balls
    while len(radii) < spheres:
        least = (np.linalg.norm(points[:, None] - centres, axis=2) - radii).min(axis=1)
        new = int(np.argmin(np.sum(np.minimum(gaps, least) ** 2, axis=1)))
        centres = np.vstack([centres, candidates[0][new]])
        radii = np.append(radii, candidates[1][new])
    return centres, radii


def _move_one_ball(points: Array, fit: Fit, candidates: Balls, gaps: Array) -> Fit:
    """Remove one of the three least needed balls and add the best candidate; the best
    of the three tries."""
    centres, radii, _ = fit
    n = len(radii)
    if n < 2:
        return fit
    gap = np.linalg.norm(points[:, None] - centres, axis=2) - radii
    two = np.partition(gap, 1, axis=1)[:, :2]
    deepest = np.argmin(gap, axis=1)
    missed = np.bincount(deepest, two[:, 1] ** 2 - two[:, 0] ** 2, n)
    tries = []
    for ball in np.argsort(missed, kind="stable")[:3]:
        left = np.arange(n) != ball
        start = _add_balls(points, (centres[left], radii[left]), candidates, gaps, n)
        tries.append(_fit_balls(points, *start))
    return min(tries, key=_cost)


def _fit_balls(points: Array, centres: Array, radii: Array) -> Fit:
    """Least-squares balls (damped Gauss–Newton); each point belongs to the ball that it
    is deepest in."""
    n, damping = len(radii), 1e-3
    gap, toward, ball = _assign_points(points, centres, radii)
    cost = float(gap @ gap)
    for _ in range(STEPS):
        # minus the gap's derivative
        row = np.concatenate([toward, np.ones((len(points), 1))], axis=1)
        mine = (ball[:, None] == np.arange(n)).astype(float)  # (points, n)
        normal = (mine.T @ (row[:, :, None] * row[:, None, :]).reshape(-1, 16)).reshape(
            n, 4, 4
        )
        right = mine.T @ (row * gap[:, None])
        weight = np.trace(normal, axis1=1, axis2=2)[:, None, None] + 1e-9
        step = np.linalg.solve(
            normal + damping * weight * np.eye(4), right[:, :, None]
        )[:, :, 0]
        new = centres + step[:, :3], np.maximum(radii + step[:, 3], LEAST_RADIUS)
        found = _assign_points(points, *new)
        lower = float(found[0] @ found[0])
        if lower < cost:
            (centres, radii), (gap, toward, ball), damping = (
                new,
                found,
                max(damping / 3, 1e-9),
            )
            if lower > cost * (1 - 1e-5):
                break
            cost = lower
        else:
            damping *= 10
            if damping > 1e3:
                break
    return centres, radii, cost


def _assign_points(
    points: Array, centres: Array, radii: Array
) -> tuple[Array, Array, Array]:
    """Of each point: gap to its ball, direction from the ball's centre, and number of
    the ball."""
    offset = points[:, None] - centres
    far = np.sqrt(np.einsum("kij,kij->ki", offset, offset))
    ball = np.argmin(far - radii, axis=1)
    k = np.arange(len(points))
    return (
        far[k, ball] - radii[ball],
        offset[k, ball] / np.maximum(far[k, ball], 1e-12)[:, None],
        ball,
    )


def _drop_hidden(centres: Array, radii: Array) -> Balls:
    """The balls, largest first, without those wholly inside another."""
    order = np.argsort(-radii, kind="stable")
    centres, radii = centres[order], radii[order]
    inside = np.linalg.norm(centres[:, None] - centres, axis=2) + radii[
        :, None
    ] <= radii * (1 + 1e-9)
    keep = ~(inside & np.tri(len(radii), k=-1, dtype=bool)).any(axis=1)
    return centres[keep], radii[keep]
