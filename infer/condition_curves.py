"""Curves by which a parameter may follow a condition, as covariances of their values.

Of a number, u = 0 … 1 over its range: a line, k(u, v) = u v, and a smooth curve, k(u,
v) = exp(−(u − v)²/(2 SMOOTH²)) (Rasmussen & Williams 2006, eq. 2.31). Of words, and of
few numbers: levels, each with a value of its own."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from benchtwin.bench.language import tr
from benchtwin.infer.conditions import Condition
from benchtwin.infer.follow import Point

INNER = (1 / 3, 2 / 3)  # u at which a highest or lowest value is one
MOST_LEVELS = 6  # of a number that is tried as levels
SMOOTH = 0.4  # of the range: over which a smooth curve keeps its value

# (n,), (m,) → (n, m): covariance of a curve's values
Kernel = Callable[[np.ndarray, np.ndarray], np.ndarray]


@dataclass(frozen=True, eq=False)
class Use:
    """A condition, or a recording (its number) by itself, as it is used: of the
    recordings (indices) `kept`, u = (value − low) / reach, or the place of a level;
    kernels by shape."""

    source: Condition | int
    values: np.ndarray  # (R,), NaN where not stated
    kept: np.ndarray
    kernels: dict[str, Kernel]
    low: float = 0.0
    reach: float = 1.0

    @property
    def u(self) -> np.ndarray:
        """(n,)."""
        return (self.values[self.kept] - self.low) / self.reach

    @property
    def name(self) -> str:
        """Of the condition; "" of a recording."""
        return self.source.name if isinstance(self.source, Condition) else ""

    @property
    def levels(self) -> tuple[str, ...]:
        return self.source.levels if isinstance(self.source, Condition) else ()

    @property
    def unlisted(self) -> bool:
        """Whether it says when, not why."""
        return isinstance(self.source, Condition) and self.source.unlisted


def use_of(names: tuple[str, ...], source: Condition | int, most: float) -> Use | None:
    """None where nothing differs; most: share of a curve's power in one recording, on
    which it rests beyond."""
    if not isinstance(source, Condition):
        alone = (np.arange(len(names)) == source) * 1.0
        return Use(source, alone, np.arange(len(names)), {"line": _line})
    values = source.of(names)
    kept = np.flatnonzero(np.isfinite(values))
    if source.levels:  # a level of one recording tells nothing
        each, count = np.unique(values[kept], return_counts=True)
        kept = kept[np.isin(values[kept], each[count > 1])]
    if len(kept) < 3 or not np.ptp(values[kept]):
        return None
    if source.levels:
        return Use(source, values, kept, {"levels": _levels})
    low, reach = float(values[kept].min()), float(np.ptp(values[kept]))
    distinct = len(np.unique(values[kept]))
    kernels: dict[str, Kernel] = {"line": _line}
    if distinct > 2:
        kernels["curve"] = _curve
    if 3 < distinct <= min(MOST_LEVELS, len(kept) / 2):
        kernels["levels"] = _levels
    found = Use(source, values, kept, kernels, low, reach)
    power = (found.u - found.u.mean()) ** 2
    return found if power.max() <= most * power.sum() else None


def _line(u: np.ndarray, v: np.ndarray) -> np.ndarray:
    return np.outer(u, v)


def _curve(u: np.ndarray, v: np.ndarray) -> np.ndarray:
    return np.exp(-0.5 * ((u[:, None] - v) / SMOOTH) ** 2)


def _levels(u: np.ndarray, v: np.ndarray) -> np.ndarray:
    return (np.abs(u[:, None] - v) < 1e-9) * 1.0


def shape_of(shape: str, points: tuple[Point, ...]) -> str:
    """Of a curve in words: where it is highest or lowest, or where it is steep."""
    if shape != "curve":
        return shape
    sizes = np.array([p.size.value for p in points])
    sure = np.array([p.size.high95 - p.size.value for p in points])
    u, ends = np.linspace(0, 1, len(points)), [0, -1]
    for at, name in ((sizes.argmax(), "highest"), (sizes.argmin(), "lowest")):
        off = np.abs(sizes[at] - sizes[ends]) > sure[ends]
        if INNER[0] < u[at] < INNER[1] and off.all():
            return name
    early = abs(sizes[len(sizes) // 2] - sizes[0]) > 0.5 * abs(sizes[-1] - sizes[0])
    return tr("levelling off") if early else "steepening"
