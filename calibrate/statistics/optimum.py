"""Where a surface meets a target inside its box (the paper's Eq. 11).

With k factors and one target the solutions are a sheet of k − 1 dimensions: an optimum
is one point on it, chosen by whoever asks."""

from dataclasses import dataclass
from itertools import product

import numpy as np
from scipy.optimize import minimize

from benchtwin.bench.language import tr
from benchtwin.calibrate.statistics.surface import Surface

EDGE = 1e-3  # coded distance from ±1 within which a factor stands at its limit
MOST_STARTS = 16  # corners that a search begins from
HIT = 1e-6  # of the target: what SLSQP comes to


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


def optimum(
    surface: Surface, target: float, *, near: dict[str, float] | None = None
) -> Optimum:
    """The point of the box with the smallest |ŷ − target|; of many, the one nearest to
    `near` (coded distance).

    near: natural values; default the box's centre, where the surface is known best. A
    target that nothing reaches is an outcome, not an error. Raises ValueError for a
    target that is not finite or a `near` without one of the factors."""
    if not np.isfinite(target):
        raise ValueError(tr("target: {} is not finite", target))
    start = np.zeros(len(surface.names)) if near is None else _coded(surface, near)
    low, high = (_extreme(surface, sign) for sign in (1, -1))
    ends = surface.mean([low, high])
    if target <= ends[0] or target >= ends[1]:
        at = low if target <= ends[0] else high
    else:
        at = _nearest(surface, target, start, (low, high))
    return _stand(surface, at, target, ends)


def _coded(surface: Surface, point: dict[str, float]) -> np.ndarray:
    missing = [n for n in surface.names if n not in point]
    if missing:
        raise ValueError(tr("no value for {}", ", ".join(missing)))
    return surface.box.coded([point[n] for n in surface.names])


def _stand(
    surface: Surface, coded: np.ndarray, target: float, ends: np.ndarray
) -> Optimum:
    least, most = (float(v) for v in ends)
    predicted = float(surface.mean(coded)[0])
    se = float(np.sqrt(surface.variance(coded)[0]))
    outcome = "reached"
    if not least <= target <= most:
        outcome = tr("target {} all", tr("below") if target < least else tr("above"))
    edge = {
        n: "high" if z > 0 else "low"
        for n, z in zip(surface.names, coded)
        if abs(z) > 1 - EDGE
    }
    words = [
        tr(
            "the reported point gives {} {:.4g} ± {:.2g}, the bench {:.4g}",
            surface.response_name,
            predicted,
            se,
            target,
        )
    ]
    free = len(surface.names) - 1
    if outcome != "reached":
        words.append(
            tr(
                "no parameters of the box give it (it reaches {:.4g} to {:.4g}): a"
                " finding about the model, or the box is too small",
                least,
                most,
            )
        )
    elif free:
        words.append(
            tr("a whole set of points, of {} dimensions, gives the same", free)
        )
    if edge:
        limits = ", ".join(
            tr("{} at its {} limit", n, side) for n, side in edge.items()
        )
        words.append(tr("it lies at the edge of what was simulated: {}", limits))
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
    """Coded point of the smallest (sign 1) or largest (−1) response in the box, sought
    from every corner and the centre."""

    def height(z: np.ndarray) -> float:
        return sign * float(surface.mean(z)[0])

    k = len(surface.names)
    corners = [np.array(corner) for corner in product((-1.0, 1.0), repeat=k)]
    found = [
        minimize(height, 0.9 * start, bounds=[(-1, 1)] * k, method="L-BFGS-B").x
        for start in (*corners, np.zeros(k))
    ]
    return min([*corners, *found], key=height)


def _nearest(
    surface: Surface, target: float, start: np.ndarray, ends: tuple[np.ndarray, ...]
) -> np.ndarray:
    """Solution nearest to `start`: SLSQP from where the line from the lowest to the
    highest point, `ends`, crosses the target, from `start`, and from corners of the
    box."""

    def off(z: np.ndarray) -> np.ndarray:
        return surface.mean(z) - target

    low, high = ends
    line = np.linspace(0, 1, 2001)[:, None] * (high - low) + low
    best, distance = line[np.argmin(abs(off(line)))], np.inf
    corners = list(product((-0.9, 0.9), repeat=len(start)))
    for begin in (best, start, *map(np.array, corners[:MOST_STARTS])):
        found = minimize(
            lambda z: np.sum((z - start) ** 2),
            begin,
            bounds=[(-1, 1)] * len(start),
            method="SLSQP",
            options={"ftol": 1e-12},
            constraints={"type": "eq", "fun": off},
        )
        hits = found.success and abs(off(found.x)[0]) < HIT * max(1, abs(target))
        if hits and found.fun < distance:
            best, distance = np.clip(found.x, -1, 1), found.fun
    return best
