"""Which parameter gives the bench's mean: a curve inverted, with an interval that
carries every error.

The interval holds all x of the branch at which the curve agrees with the bench
(Fieller's construction, which needs no straight curve):
    |f(x) − ȳ| ≤ t(ν) √(s_bench² + s_measuring² + var f(x)),   ν by Welch–Satterthwaite.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from scipy import stats

from benchtwin.calibrate.statistics.bench import BenchMean
from benchtwin.calibrate.statistics.curves import Curve, Monotone

GRID = 2001  # steps of 1/2000 of the range, roots interpolated between them


class OutsideRange(ValueError):
    """The bench's mean lies beyond what was simulated. side: "low" or "high", where to
    extend; about: a guess at the parameter."""

    def __init__(self, message: str, side: str, about: float):
        super().__init__(message)
        self.side, self.about = side, about


@dataclass(frozen=True, kw_only=True)
class Inverse:
    """A parameter with its uncertainty.

    value; sd (at the root, error over slope); low, high: interval at `level`; df:
    effective degrees of freedom there; budget: part of sd² by source (bench scatter,
    measuring, simulation scatter, fit), sums to 1; roots: every x of the range with
    that mean; open_ends: ends ("low", "high") where the simulations stop before the
    curve leaves the bench's mean, so that the interval bounds one side only; notes:
    what a reader must know (ambiguity …)."""

    name: str
    value: float
    sd: float
    low: float
    high: float
    level: float
    df: float
    budget: dict[str, float]
    roots: tuple[float, ...]
    open_ends: frozenset[str]
    notes: tuple[str, ...]


def invert(
    curve: Curve, bench: BenchMean, *, level: float = 0.95, beyond: float = 0.0
) -> Inverse:
    """The x at which the curve meets the bench's mean.

    beyond: how far outside the simulated range a polynomial may be followed, as a
    fraction of it (default: not at all); a root found there is noted. Of several roots
    the one on the branch that follows the curve's overall trend is taken and the others
    are named. Raises OutsideRange, saying which way to extend the simulations."""
    if beyond and isinstance(curve, Monotone):
        raise ValueError(
            "beyond: a monotone curve is not known outside its rows; extend the"
            " simulations"
        )
    reach = beyond * (curve.high - curve.low)
    x = np.linspace(curve.low - reach, curve.high + reach, GRID)
    y = curve.mean(x)
    roots = _roots(x, y - bench.value)
    if not roots:
        raise _outside(curve, bench, x, y)
    branches = _branches(y)
    root, branch = _choose(roots, branches, x)
    notes = _ambiguity(curve, roots, root, branches, x)
    low, high, ends = _interval(curve, bench, level, root, x[branch], y[branch])
    sd, budget, df = _budget(curve, bench, root)
    if not curve.low <= root <= curve.high:
        notes.append(
            f"{curve.x_name} {root:.4g} lies outside the simulated range {curve.low:g}"
            f" to {curve.high:g}: extend it"
        )
    for end in sorted(ends, reverse=True):
        place = f"{x[branch][0 if end == 'low' else -1]:.4g}"
        notes.append(
            f"the interval is cut off at {place}: it reaches the end of the simulated"
            " branch"
        )
    return Inverse(
        name=curve.x_name,
        value=root,
        sd=sd,
        low=low,
        high=high,
        level=level,
        df=df,
        budget=budget,
        roots=tuple(roots),
        open_ends=frozenset(ends),
        notes=tuple(notes),
    )


def _roots(x: np.ndarray, g: np.ndarray) -> list[float]:
    """Where g changes sign, interpolated."""
    at = np.flatnonzero((g[:-1] * g[1:] < 0) | (g[:-1] == 0))
    step = np.where(g[at + 1] != g[at], g[at + 1] - g[at], 1.0)
    found = x[at] - g[at] * (x[at + 1] - x[at]) / step
    return [*map(float, found), *([float(x[-1])] if g[-1] == 0 else [])]


def _branches(y: np.ndarray) -> list[slice]:
    """Stretches of the grid on which the curve follows its overall trend, longest
    first; if none does, the whole grid."""
    trend = np.sign(y[-1] - y[0]) or 1.0
    along = np.concatenate([[False], np.diff(y) * trend > 0, [False]])
    starts = np.flatnonzero(along[1:] & ~along[:-1])
    ends = np.flatnonzero(~along[1:] & along[:-1])
    found = [slice(int(s), int(e) + 1) for s, e in zip(starts, ends)]
    return sorted(found, key=lambda b: b.start - b.stop) or [slice(0, y.size)]


def _choose(
    roots: list[float], branches: list[slice], x: np.ndarray
) -> tuple[float, slice]:
    for branch in branches:
        for root in roots:
            if x[branch][0] <= root <= x[branch][-1]:
                return root, branch
    return roots[0], slice(0, x.size)


def _ambiguity(
    curve: Curve, roots: list[float], root: float, branches: list[slice], x: np.ndarray
) -> list[str]:
    notes = []
    others = [f"{r:.4g}" for r in roots if r != root]
    if others:
        notes.append(
            f"ambiguous: {curve.x_name} {', '.join(others)} gives the same mean; "
            f"{root:.4g} lies on the branch of the overall trend"
        )
    main = branches[0]
    if main.start > 0 or main.stop < x.size:
        ends = f"{x[main][0]:.4g} to {x[main][-1]:.4g}"
        notes.append(
            "the curve turns within the range: it follows its trend from"
            f" {curve.x_name} {ends} only"
        )
    return notes


def _outside(
    curve: Curve, bench: BenchMean, x: np.ndarray, y: np.ndarray
) -> OutsideRange:
    """Say which way to extend: towards the end of the range that lies nearer to the
    bench's mean, by the overall slope."""
    rising = y[-1] >= y[0]
    side = "high" if (bench.value > y.max()) == rising else "low"
    end, at = (curve.high, y[-1]) if side == "high" else (curve.low, y[0])
    slope = (y[-1] - y[0]) / (x[-1] - x[0])
    about = end + (bench.value - at) / slope if slope else np.nan
    return OutsideRange(
        f"{curve.y_name} {bench.value:.4g} at the bench is outside what was simulated"
        f" ({y.min():.4g} to {y.max():.4g}): extend {curve.x_name}"
        f" {'above' if side == 'high' else 'below'} {end:g}, to about {about:.3g}",
        side,
        float(about),
    )


def _parts(
    curve: Curve, bench: BenchMean, x: ArrayLike
) -> tuple[np.ndarray, np.ndarray]:
    """Total variance at x and its Welch–Satterthwaite degrees of freedom."""
    fit = curve.variance(x)
    total = bench.scatter_sd**2 + bench.shared_sd**2 + fit
    spread = bench.scatter_sd**4 / bench.df + fit**2 / curve.df
    df = np.full_like(total, np.inf)
    return total, np.divide(total**2, spread, out=df, where=spread > 0)


def _budget(
    curve: Curve, bench: BenchMean, root: float
) -> tuple[float, dict[str, float], float]:
    """sd at the root, parts of sd² by source, degrees of freedom."""
    step = (curve.high - curve.low) / (GRID - 1)
    inside = np.clip(root, curve.low + step, curve.high - step)
    rise = curve.mean(inside + step) - curve.mean(inside - step)
    slope = float(rise[0] / (2 * step))
    totals, df = _parts(curve, bench, root)
    fit = float(curve.variance(root)[0])
    simulation = curve.simulation_variance(root, fit)
    parts = {
        "bench scatter": bench.scatter_sd**2,
        "measuring": bench.shared_sd**2,
        "simulation scatter": simulation,
        "fit": fit - simulation,
    }
    total = float(totals[0])
    sd = float(np.sqrt(total) / abs(slope)) if slope else np.inf
    return sd, {k: v / total if total else 0.0 for k, v in parts.items()}, float(df[0])


def _interval(
    curve: Curve,
    bench: BenchMean,
    level: float,
    root: float,
    x: np.ndarray,
    y: np.ndarray,
) -> tuple[float, float, set[str]]:
    """Ends of the stretch around the root that agrees with the bench, and those at
    which the branch ended first."""
    total, df = _parts(curve, bench, x)
    excess = abs(y - bench.value) - stats.t.ppf((1 + level) / 2, df) * np.sqrt(total)
    here = int(np.clip(np.searchsorted(x, root), 1, x.size - 1))
    open_ends = set()

    def end(step: int, at: int) -> float:
        while 0 <= at < x.size and excess[at] <= 0:
            at += step
        if not 0 <= at < x.size:
            open_ends.add("low" if step < 0 else "high")
            return float(x[0 if step < 0 else -1])
        inner = at - step
        if excess[inner] > 0:  # an error smaller than a grid step
            return root
        fall = excess[at] - excess[inner]
        return float(x[at] + (x[inner] - x[at]) * excess[at] / fall)

    low, high = end(-1, here - 1), end(1, here)
    return min(low, root), max(high, root), open_ends
