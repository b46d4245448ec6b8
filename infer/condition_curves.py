"""Curves by which a parameter may follow a condition."""

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial

import numpy as np

from benchtwin.infer.conditions import Condition
from benchtwin.infer.follow import Point

BENDS = (3.0, 8.0)  # k of 1 − exp(−k u), u = 0 … 1 over the condition's range
INNER = (1 / 3, 2 / 3)  # u at which a parabola has an end; outside, it is a bent curve
MOST_LEVELS = 6  # of a number that is tried as levels


@dataclass(frozen=True, eq=False)
class ConditionCurve:
    """A shape; columns: u (or places of levels) (n,) → (n, k)."""

    shape: str
    columns: Callable[[np.ndarray], np.ndarray]
    parameters: int


@dataclass(frozen=True, eq=False)
class UsedCondition:
    """A condition as it is used: of the recordings (indices) `kept`, u = (value − low)
    / reach."""

    condition: Condition
    values: np.ndarray  # (R,), NaN where not stated
    kept: np.ndarray
    low: float
    reach: float

    def u(self, values: np.ndarray) -> np.ndarray:
        return (values - self.low) / self.reach

    def shift(self, values: np.ndarray, curve: ConditionCurve) -> np.ndarray:
        """(R, k): columns, of mean 0, and 0 where the condition was not used."""
        out = curve.columns(self.u(values[self.kept]))
        whole = np.zeros((len(values), out.shape[1]))
        whole[self.kept] = out - out.mean(0)
        return whole


def curves_of(condition: Condition, u: np.ndarray) -> Iterator[ConditionCurve]:
    """What is tried of a condition."""
    if condition.levels:
        yield _levels(np.unique(u))
        return
    yield ConditionCurve("line", lambda u: u[:, None], 1)
    values = np.unique(u)
    if len(values) < 3:
        return
    for k in BENDS:
        yield ConditionCurve("early", partial(_bent, k=k), 2)
        yield ConditionCurve("late", partial(_bent, k=-k), 2)
    yield ConditionCurve("parabola", lambda u: np.column_stack([u, u**2]), 2)
    if 3 < len(values) <= min(MOST_LEVELS, len(u) / 2):
        yield _levels(values)


def _bent(u: np.ndarray, k: float) -> np.ndarray:
    """(n, 1): 1 − exp(−k u), steepest at u = 0; with k below 0 at u = 1."""
    return (1 - np.exp(-k * u))[:, None] * math.exp(min(k, 0.0))


def _levels(values: np.ndarray) -> ConditionCurve:
    def columns(u: np.ndarray) -> np.ndarray:
        return (np.abs(u[:, None] - values[1:]) < 1e-9) * 1.0

    return ConditionCurve("levels", columns, len(values) - 1)


def used_of(names: tuple[str, ...], condition: Condition) -> UsedCondition | None:
    """None where nothing differs."""
    values = condition.of(names)
    kept = np.flatnonzero(np.isfinite(values))
    if condition.levels:  # a level of one recording tells nothing
        each, count = np.unique(values[kept], return_counts=True)
        kept = kept[np.isin(values[kept], each[count > 1])]
    if len(kept) < 3 or not np.ptp(values[kept]):
        return None
    if condition.levels:
        return UsedCondition(condition, values, kept, 0.0, 1.0)
    low, reach = float(values[kept].min()), float(np.ptp(values[kept]))
    return UsedCondition(condition, values, kept, low, reach)


def shape_of(curve: ConditionCurve, points: tuple[Point, ...]) -> str:
    """In words; a parabola whose end lies outside is a curve."""
    if curve.shape in ("line", "levels"):
        return curve.shape
    if curve.shape == "parabola":
        sizes = np.array([p.size.value for p in points])
        u = np.linspace(0, 1, len(points))
        for end, name in ((sizes.argmax(), "highest"), (sizes.argmin(), "lowest")):
            if INNER[0] < u[end] < INNER[1]:
                return name
        early = abs(sizes[len(sizes) // 2] - sizes[0]) > 0.5 * abs(sizes[-1] - sizes[0])
    else:
        early = curve.shape == "early"
    return "levelling off" if early else "steepening"
