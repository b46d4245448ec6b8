"""Where a surface meets a target inside its box (the paper's Eq. 11), and the whole set
of points that do.

With k factors and one target the solutions are a sheet of k − 1 dimensions: an optimum
is one point on it, chosen by whoever asks."""

from dataclasses import dataclass
from itertools import product

import numpy as np
import pandas as pd
from scipy import stats
from scipy.optimize import minimize

from benchtwin.calibrate.statistics.surface import Surface

EDGE = 1e-3  # coded distance from ±1 within which a factor stands at its limit
SAMPLED, STARTS = 64, 6  # points of the sheet, and how many a search begins from
HIT = 1e-6  # of the target: what SLSQP comes to
BAND = 20_000  # points of the box: its share within the band is then good to 0.4 %


@dataclass(frozen=True, kw_only=True, eq=False)
class Optimum:
    """A point of the box and how it stands to the target.

    outcome: "reached", "target below all" or "target above all" (then the point comes
    nearest); point: {factor: natural}; coded: (k,); predicted, se: response and its
    standard error there; boundary: {factor: "low" | "high"} at a limit; reachable:
    smallest and largest response in the box; statement: this in words."""

    outcome: str
    point: dict[str, float]
    coded: np.ndarray
    predicted: float
    se: float
    target: float
    boundary: dict[str, str]
    reachable: tuple[float, float]
    statement: str

    @property
    def gap(self) -> float:
        """How far the response misses the target."""
        return self.predicted - self.target


def optimum(
    surface: Surface, target: float, *, near: dict[str, float] | None = None
) -> Optimum:
    """The point of the box with the smallest |ŷ − target|; of many, the one nearest to
    `near` (coded distance).

    near: natural values; default the box's centre, where the surface is known best. A
    target that nothing reaches is an outcome, not an error. Raises ValueError for a
    target that is not finite or a `near` without one of the factors."""
    if not np.isfinite(target):
        raise ValueError(f"target: {target} is not finite")
    start = np.zeros(len(surface.names)) if near is None else _coded(surface, near)
    low, high = (_extreme(surface, sign) for sign in (1, -1))
    ends = surface.mean([low, high])
    if target <= ends[0] or target >= ends[1]:
        at = low if target <= ends[0] else high
    else:
        at = _nearest(surface, target, start, (low, high))
    return _stand(surface, at, target, ends)


def stand(surface: Surface, point: dict[str, float], target: float) -> Optimum:
    """How a stated point (a published optimum, say) stands to the target; raises
    ValueError where it lies outside the box."""
    coded = _coded(surface, point)
    if (abs(coded) > 1 + EDGE).any():
        worst = surface.names[int(np.argmax(abs(coded)))]
        raise ValueError(f"{worst}: {point[worst]:g} lies outside the box")
    ends = surface.mean([_extreme(surface, sign) for sign in (1, -1)])
    return _stand(surface, coded, target, ends)


def _coded(surface: Surface, point: dict[str, float]) -> np.ndarray:
    missing = [n for n in surface.names if n not in point]
    if missing:
        raise ValueError(f"no value for {', '.join(missing)}")
    return surface.box.coded([point[n] for n in surface.names])


def _stand(
    surface: Surface, coded: np.ndarray, target: float, ends: np.ndarray
) -> Optimum:
    least, most = (float(v) for v in ends)
    predicted = float(surface.mean(coded)[0])
    se = float(np.sqrt(surface.variance(coded)[0]))
    outcome = "reached"
    if not least <= target <= most:
        outcome = f"target {'below' if target < least else 'above'} all"
    edge = {
        n: "high" if z > 0 else "low"
        for n, z in zip(surface.names, coded)
        if abs(z) > 1 - EDGE
    }
    words = [
        f"the reported point gives {surface.response_name} {predicted:.4g} ± {se:.2g},"
        f" the bench {target:.4g}"
    ]
    free = len(surface.names) - 1
    if outcome != "reached":
        words.append(
            f"no parameters of the box give it (it reaches {least:.4g} to {most:.4g}):"
            " a finding about the model, or the box is too small"
        )
    elif free:
        words.append(f"a whole set of points, of {free} dimensions, gives the same")
    if edge:
        limits = ", ".join(f"{n} at its {side} limit" for n, side in edge.items())
        words.append(f"it lies at the edge of what was simulated: {limits}")
    natural = zip(surface.names, surface.box.natural(coded))
    return Optimum(
        outcome=outcome,
        point={n: float(f"{v:.9g}") for n, v in natural},
        coded=coded,
        predicted=predicted,
        se=se,
        target=target,
        boundary=edge,
        reachable=(least, most),
        statement="; ".join(words),
    )


def _extreme(surface: Surface, sign: int) -> np.ndarray:
    """Coded point of the smallest (sign 1) or largest (−1) response in the box, from
    every corner and the centre."""
    k = len(surface.names)
    starts = np.array([*product((-1.0, 1.0), repeat=k), np.zeros(k)])
    best = starts[np.argmin(sign * surface.mean(starts))]
    for start in starts[np.argsort(sign * surface.mean(starts))[:16]]:
        found = minimize(
            lambda z: sign * surface.mean(z)[0],
            start * 0.9,
            jac=lambda z: sign * surface.gradient(z)[0],
            bounds=[(-1, 1)] * k,
            method="L-BFGS-B",
        )
        best = min(best, found.x, key=lambda z: sign * surface.mean(z)[0])
    return best


def _nearest(
    surface: Surface, target: float, start: np.ndarray, ends: tuple[np.ndarray, ...]
) -> np.ndarray:
    """Solution nearest to `start`: SLSQP from solutions on the straight lines start–low
    and start–high and on a coarse sample."""
    # starting points only: the answer does not depend on the draw
    sheet = _sheet(surface, target, SAMPLED, np.random.default_rng(0))
    # the line from the lowest to the highest point must cross the target, whatever the
    # sample missed
    low, high = ends
    at = np.linspace(0, 1, 2001)[:, None] * (high - low) + low
    crossing = at[np.argmin(abs(surface.mean(at) - target))]
    near = np.argsort(np.sum((sheet - start) ** 2, axis=1))[:STARTS]
    best, distance = crossing, np.inf
    for z in np.vstack([crossing, sheet[near]]):
        found = minimize(
            lambda z: np.sum((z - start) ** 2),
            z,
            jac=lambda z: 2 * (z - start),
            bounds=[(-1, 1)] * len(start),
            method="SLSQP",
            options={"ftol": 1e-12},
            constraints={
                "type": "eq",
                "fun": lambda z: surface.mean(z) - target,
                "jac": surface.gradient,
            },
        )
        off = abs(surface.mean(found.x)[0] - target)
        hits = found.success and off < HIT * max(1, abs(target))
        if hits and found.fun < distance:
            best, distance = np.clip(found.x, -1, 1), found.fun
    return best


def _sheet(
    surface: Surface, target: float, n: int, rng: np.random.Generator
) -> np.ndarray:
    """Up to n solutions, uniform over the sheet's area in coded units, (m, k).

    Along every axis, lines at random places are cut with the surface (a quadratic in
    one factor); a place of the sheet is met in proportion to Σ|n_j| of its unit normal,
    so it is kept with 1/Σ|n_j|."""
    k = len(surface.names)
    if max(max(t) for t in surface.terms) > 2:
        raise ValueError(
            "solutions are sampled for surfaces of at most second degree in each factor"
        )
    found = []
    for axis in range(k):
        lines = rng.uniform(-1, 1, (4 * n if k > 1 else 1, k))
        low, mid, high = (surface.mean(_with(lines, axis, t)) for t in (-1.0, 0.0, 1.0))
        a, b, c = (low + high) / 2 - mid, (high - low) / 2, mid - target
        root = np.sqrt(np.where(b**2 - 4 * a * c >= 0, b**2 - 4 * a * c, np.nan))
        # the stable form: also right where a vanishes
        q = -(b + np.where(b >= 0, 1, -1) * root) / 2
        with np.errstate(divide="ignore", invalid="ignore"):
            for t in (q / a, c / q):
                inside = np.abs(t) <= 1
                found.append(_with(lines[inside], axis, t[inside]))
    points = np.vstack(found)
    normal = abs(surface.gradient(points))
    length = np.linalg.norm(normal, axis=1)
    keep = rng.uniform(size=len(points)) * normal.sum(axis=1) <= length
    points = points[keep] if k > 1 else points
    return rng.permutation(points)[:n]


def _with(lines: np.ndarray, axis: int, value) -> np.ndarray:
    out = lines.copy()
    out[:, axis] = value
    return out


@dataclass(frozen=True, eq=False)
class SolutionSet:
    """All points of the box that give the target.

    table: sampled uniformly over the sheet, the factors in natural units, predicted,
    se; dimensions: k − 1, 0 where none; ranges: factor, low, high over the set,
    box_fraction; volume_fraction: part of the box within the band asked for; statement:
    in words."""

    table: pd.DataFrame
    dimensions: int
    ranges: pd.DataFrame
    volume_fraction: float
    statement: str


def solution_set(
    surface: Surface,
    target: float,
    *,
    rng: np.random.Generator,
    points: int = 500,
    band_sd: float = 0.0,
) -> SolutionSet:
    """Sample the set ŷ = target inside the box.

    band_sd: standard deviation of the bench's value; `volume_fraction` is the part of
    the box where |ŷ − target| is within 1.96 times it and the surface's own standard
    error together. An empty set is an outcome: table without rows, dimensions 0."""
    z = _sheet(surface, target, points, rng)
    table = pd.DataFrame(surface.box.natural(z), columns=list(surface.names))
    table = table.assign(predicted=surface.mean(z), se=np.sqrt(surface.variance(z)))
    box = rng.uniform(-1, 1, (BAND, len(surface.names)))
    reach = stats.norm.ppf(0.975) * np.sqrt(band_sd**2 + surface.variance(box))
    volume = float(np.mean(abs(surface.mean(box) - target) <= reach))
    if not len(table):
        ranges = pd.DataFrame(columns=["factor", "low", "high", "box_fraction"])
        said = f"no point of the box gives {target:.4g}"
        return SolutionSet(table, 0, ranges, volume, said)
    ends = np.array([z.min(axis=0), z.max(axis=0)])
    low, high = surface.box.natural(ends)
    rows = {"factor": list(surface.names), "low": low, "high": high}
    ranges = pd.DataFrame(rows | {"box_fraction": np.ptp(ends, axis=0) / 2})
    free = [
        f"{r.factor} {r.low:.3g} to {r.high:.3g} ({100 * r.box_fraction:.0f} % of its"
        " range)"
        for r in ranges.itertuples()
    ]
    agree = f"within the errors {100 * volume:.0f} % of all that was simulated agrees"
    words = f"{target:.4g} is reached with {', '.join(free)}; {agree}"
    return SolutionSet(table, len(surface.names) - 1, ranges, volume, words)
