"""Which conditions a contact parameter follows, and by what curve: tested in the table
of each recording's own value.

Recording r's value is y_r = m + f(x_r) + scatter, with the covariance φ (C + λ 1) of y:
C from the rows of all recordings, everything common and every listed effect left free;
λ by moments (Paule & Mandel 1982) beside the curve that fits best; φ from the table and
a prior, by which the usual scatter is worth USUAL_FREEDOM recordings (Smyth 2004, Stat.
Appl. Genet. Mol. Biol. 3, 3). Whatever the recordings hold besides is common to them or
in their scatter, so it neither makes a condition nor hides one.

f is tried as a line, a curve that levels off or steepens, a parabola, and levels, each
by its F test. The least of these p is compared with its own distribution, drawn with
normal scatter: p is exact for few recordings. False discoveries among all conditions
are controlled at FOUND_P (Benjamini & Hochberg 1995); after each finding the others are
tested beside it. No curve is tried that rests on one recording."""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from scipy import stats
from scipy.linalg import solve_triangular

from benchtwin.bench.robust import robust_sd
from benchtwin.infer.condition_curves import (
    ConditionCurve,
    UsedCondition,
    curves_of,
    shape_of,
    used_of,
)
from benchtwin.infer.conditions import Condition, Contact, effect_name
from benchtwin.infer.follow import ConditionTable, Follow, Point
from benchtwin.infer.linear import projector, stacked
from benchtwin.infer.problem import Fit
from benchtwin.infer.verdict import ENDS, Interval, against_noise

USUAL_FREEDOM = 2.0  # recordings that the usual scatter is worth
FOUND_P = 0.0025  # of all conditions of a bench together
AS_LIKELY_P = 0.005  # at which a stated condition is followed as likely as not
LEAST_FREEDOM = 2  # of what is left beside a curve
# prior odds of a drift over those of a condition, which is stated because it may matter
DRIFT = 0.5
DRAWS = 10_000
GRID = 500  # shares between which p is interpolated
# leverage of one recording beyond which a curve, or one of several columns, rests on it
MOST_SHARE, MOST_SHARE_OF_SEVERAL = 0.6, 0.75
BETTER_CHI2 = 4.0  # by which a curve must fit better for each parameter more
AS_WELL_P = 0.05  # of a condition beside another, above which either explains both
FAR_SDS = 8.0  # robust ones, beyond which one recording is left out
LEAST_BESIDE = 6  # others for that
POINTS = 25  # of a curve that is drawn
MOST_SCATTER = 1e12  # times the rows'
UNTOLD = 1e-10  # relative information of a contrast that the rows do not tell
HIDDEN = 1e-6  # relative power of a column that what stands beside it takes up


@dataclass(frozen=True, eq=False)
class Numbers:
    """Each recording's own value of a contact parameter, less the common one."""

    recordings: tuple[str, ...]
    values: np.ndarray  # (R,), in the global's unit
    covariance: np.ndarray  # (R, R), usual scatter included


def numbers_of(of: Fit, column: str) -> Numbers | None:
    """Each recording's own value of a global, all others and the listed effects free,
    with whatever it follows in the fit.

    Of b = A θ + Σ β_r c_r, c_r the global's column in recording r's rows: β = J⁻¹ h,
    J = Cᵀ P C, h = Cᵀ P b. None where fewer than three recordings tell it."""
    if column not in of.names:
        return None
    a, b = stacked(of.reduced)
    if not (np.isfinite(a).all() and np.isfinite(b).all()):
        return None
    own = of.names.index(column)
    prior = of.baseline_sd.copy()
    for k, n in enumerate(of.names):
        if n in of.problem.effects:
            prior[k] = of.problem.effects[n].prior_sd
        if n in of.problem.followed:
            prior[k] = 0.0
    prior[own] = 0.0
    columns, first = np.zeros((len(b), len(of.reduced))), 0
    for r, one in enumerate(of.reduced):
        rows = slice(first, first := first + len(one.b))
        columns[rows, r] = one.a[:, own]
    power = (columns**2).sum(0)
    told = power > HIDDEN * power.max(initial=1e-300)
    if told.sum() < 3:
        return None
    columns, project = columns[:, told], projector(a, prior)
    values, vectors = np.linalg.eigh(columns.T @ project(columns))
    values = np.maximum(values, UNTOLD * values[-1])
    covariance = (vectors / values) @ vectors.T
    values = covariance @ (columns.T @ project(b))
    names = np.array(of.problem.recordings, dtype=object)[told]
    # contrasts are all that is asked for: what is common has no sd of its own
    count = len(values)
    about = np.eye(count) - 1 / count
    covariance = about @ covariance @ about
    covariance += np.trace(covariance) / (count - 1) / count
    return Numbers(tuple(names), values - values.mean(), covariance)


def condition_table(
    numbers: Numbers | None,
    contact: Contact,
    conditions: tuple[Condition, ...],
    rng: np.random.Generator,
) -> ConditionTable:
    """All conditions tested, the strongest first."""
    if numbers is None or not conditions:
        return ConditionTable()
    numbers, far = _without_one_far_off(numbers)
    if far is not None:
        table = condition_table(numbers, contact, conditions, rng)
        return replace(table, far=(far[0], contact.scale * far[1]))
    scatter = _Scatter.of(numbers, conditions, rng)
    chosen: list[tuple[_Test, float, tuple[str, ...]]] = []
    first: float | None = None
    while True:
        beside = [t for t, *_ in chosen]
        taken = {n for t, _, more in chosen for n in (t.condition.name, *more)}
        tests = [
            test
            for c in conditions
            if c.name not in taken and (test := _tested(scatter, c, beside))
        ]
        if not tests:
            return _table(numbers, scatter, contact, chosen, first, None)
        least = _least_of_all(tests)
        best = min(tests, key=lambda t: t.p)
        p = min(least, *stats.false_discovery_control([t.p for t in tests]).tolist())
        first = p if first is None else first
        if p >= FOUND_P:
            return _table(numbers, scatter, contact, chosen, first, (best, p))
        others = [
            t
            for t in tests
            if t is not best
            and t.p < AS_WELL_P
            and _p_beside(scatter, best, [*beside, t]) > AS_WELL_P
        ]
        stated = [t for t in others if not t.condition.unlisted]
        if best.condition.unlisted and stated:  # a cause that is stated, if there is
            best, *stated = sorted(stated, key=lambda t: t.p)
        chosen.append((best, p, tuple(t.condition.name for t in stated)))


def _without_one_far_off(
    numbers: Numbers,
) -> tuple[Numbers, tuple[str, float] | None]:
    """Without a recording that alone lies FAR_SDS robust sds off the median: nothing
    may rest on it, and its scatter would hide the others'."""
    off = numbers.values - np.median(numbers.values)
    far = np.flatnonzero(np.abs(off) > FAR_SDS * robust_sd(off))
    if len(off) < LEAST_BESIDE + 1 or len(far) != 1:
        return numbers, None
    kept = np.delete(np.arange(len(off)), far)
    names = tuple(numbers.recordings[k] for k in kept)
    less = Numbers(names, numbers.values[kept], numbers.covariance[np.ix_(kept, kept)])
    return less, (numbers.recordings[far[0]], float(off[far[0]]))


@dataclass(frozen=True, eq=False)
class _Scatter:
    """The table with its scatter, and draws of it."""

    numbers: Numbers
    covariance: np.ndarray  # C + λ 1
    usual: float  # of C over it
    draws: np.ndarray  # (D, R): of the scatter
    doubt: np.ndarray  # (D,): of what the usual scatter is worth

    @classmethod
    def of(
        cls,
        numbers: Numbers,
        conditions: tuple[Condition, ...],
        rng: np.random.Generator,
    ) -> "_Scatter":
        """λ is what is left beside the curve that fits best: what is followed is no
        scatter."""
        c, y = numbers.covariance, numbers.values[:, None]
        bare = cls(numbers, c, 1.0, np.zeros((0, len(c))), np.zeros(0))
        tries = [one for n in conditions for one in _tried(bare, n, [])]
        best = min(tries, key=lambda one: one.p, default=None)
        law = np.ones((len(c), 1))
        if best is not None:
            law = np.hstack([law, best.use.shift(best.use.values, best.curve)])
        freedom = len(c) - law.shape[1]
        unit = float(np.trace(c)) / len(c)

        def left(more: float) -> float:
            white = _whitener(c + more * np.eye(len(c)))
            return float((_beside(white(y), white(law)) ** 2).sum()) - freedom

        low, high = 0.0, 0.0
        if left(0.0) > 0:
            high = unit
            while left(high) > 0 and high < MOST_SCATTER * unit:
                low, high = high, 4 * high
            for _ in range(30):
                middle = 0.5 * (low + high)
                low, high = (middle, high) if left(middle) > 0 else (low, middle)
        whole = c + high * np.eye(len(c))
        normal = rng.standard_normal((DRAWS, len(c)))
        return cls(
            numbers,
            whole,
            float(np.trace(np.linalg.solve(whole, c))) / len(c),
            normal @ np.linalg.cholesky(whole).T,
            rng.chisquare(USUAL_FREEDOM, DRAWS),
        )


@dataclass(frozen=True, eq=False)
class _Try:
    """One curve of a condition: its orthonormal columns and the p of its F test."""

    use: UsedCondition
    made: "_Whitened"
    curve: ConditionCurve
    basis: np.ndarray
    p: float


@dataclass(frozen=True, eq=False)
class _Test:
    """One condition: its best curve, the p of the least, the same of draws (D,)."""

    use: UsedCondition
    best: ConditionCurve
    p: float
    drawn: np.ndarray

    @property
    def condition(self) -> Condition:
        return self.use.condition

    @property
    def columns(self) -> np.ndarray:
        """(R, k)."""
        return self.use.shift(self.use.values, self.best)


def _tried(scatter: _Scatter, condition: Condition, beside: list[_Test]) -> list[_Try]:
    """All curves of a condition that can be told beside those found."""
    use = used_of(scatter.numbers.recordings, condition)
    if use is None:
        return []
    u, made, out = use.u(use.values[use.kept]), _whitened(scatter, use, beside), []
    for curve in curves_of(condition, u):
        basis = made.basis(curve.columns(u))
        if basis is not None:
            share = made.share(basis, made.y[None], USUAL_FREEDOM)[0]
            p = float(made.p(share, basis.shape[1]))
            out.append(_Try(use, made, curve, basis, p))
    return out


def _tested(
    scatter: _Scatter, condition: Condition, beside: list[_Test]
) -> _Test | None:
    """A condition beside those found; None where no curve can be told."""
    tries = _tried(scatter, condition, beside)
    if not tries:
        return None
    made, each = tries[0].made, np.ones(DRAWS)
    for rank in {one.basis.shape[1] for one in tries}:  # greatest share: least p
        same = [one.basis for one in tries if one.basis.shape[1] == rank]
        most = np.max(
            [made.share(basis, made.drawn, scatter.doubt) for basis in same], axis=0
        )
        grid = np.linspace(0.0, most.max(), GRID)
        each = np.minimum(each, np.interp(most, grid, made.p(grid, rank)))
    least, ordered = min(one.p for one in tries), np.sort(each)
    share = (1 + np.searchsorted(ordered, least, side="right")) / (1 + DRAWS)
    p = min(float(share), len(tries) * least, 1.0)
    calibrated = np.searchsorted(ordered, each, side="right") / DRAWS
    best = min(tries, key=_cost).curve
    return _Test(tries[0].use, best, p, calibrated)


def _cost(one: _Try) -> float:
    """−2 ln of the likelihood, and BETTER_CHI2 for each parameter."""
    made = one.made
    whole = float((made.y**2).sum()) + made.usual * USUAL_FREEDOM
    left = whole - float(((made.y @ one.basis) ** 2).sum())
    freedom = made.freedom + USUAL_FREEDOM
    return freedom * math.log(left) + BETTER_CHI2 * one.curve.parameters


@dataclass(frozen=True, eq=False)
class _Whitened:
    """Some recordings of a table, whitened, what stands beside taken out."""

    white: Callable[[np.ndarray], np.ndarray]
    nuisance: np.ndarray
    y: np.ndarray
    drawn: np.ndarray  # (D, n)
    freedom: int  # of y beside the nuisance
    usual: float

    def basis(self, columns: np.ndarray) -> np.ndarray | None:
        """Orthonormal (n, k) of columns beside the nuisance; None where they are
        hidden, rest on one recording or leave too little."""
        white = self.white(columns)
        left = _beside(white, self.nuisance)
        u, size, _ = np.linalg.svd(left, full_matrices=False)
        whole = np.linalg.norm(_beside(white, self.nuisance[:, :1]))
        u = u[:, size > math.sqrt(HIDDEN) * max(float(whole), 1e-300)]
        if not u.shape[1] or self.freedom - u.shape[1] < LEAST_FREEDOM:
            return None
        most = MOST_SHARE if u.shape[1] == 1 else MOST_SHARE_OF_SEVERAL
        if float((u**2).sum(1).max()) > most:
            return None
        return u

    def share(
        self, basis: np.ndarray, y: np.ndarray, usual: np.ndarray | float
    ) -> np.ndarray:
        """(D,): of the square of y (D, n) and the usual scatter's that the basis
        takes."""
        whole = (y**2).sum(1) + self.usual * usual
        return ((y @ basis) ** 2).sum(1) / whole

    def p(self, share: np.ndarray, rank: int) -> np.ndarray:
        """Of the F test."""
        left = 0.5 * (self.freedom + USUAL_FREEDOM - rank)
        return stats.beta.sf(share, 0.5 * rank, left)


def _whitened(scatter: _Scatter, use: UsedCondition, beside: list[_Test]) -> _Whitened:
    kept = use.kept
    white = _whitener(scatter.covariance[np.ix_(kept, kept)])
    columns = [one.columns[kept] for one in beside]
    nuisance = white(np.column_stack([np.ones(len(kept)), *columns]))
    rank = int(np.linalg.matrix_rank(nuisance, rtol=math.sqrt(HIDDEN)))
    y = _beside(white(scatter.numbers.values[kept][:, None]), nuisance)[:, 0]
    drawn = _beside(white(scatter.draws[:, kept].T), nuisance).T
    return _Whitened(white, nuisance, y, drawn, len(kept) - rank, scatter.usual)


def _whitener(covariance: np.ndarray):
    root = np.linalg.cholesky(covariance)
    return lambda columns: solve_triangular(root, columns, lower=True)


def _beside(columns: np.ndarray, nuisance: np.ndarray) -> np.ndarray:
    """Columns less their projection on the nuisance."""
    u, size, _ = np.linalg.svd(nuisance, full_matrices=False)
    u = u[:, size > math.sqrt(HIDDEN) * size[0]]
    return columns - u @ (u.T @ columns)


def _least_of_all(tests: list[_Test]) -> float:
    """How often the least p of all conditions would be as small by chance."""
    drawn = np.min([t.drawn for t in tests], axis=0)
    least = min(t.p for t in tests)
    share = float((1 + (drawn <= least).sum()) / (1 + DRAWS))
    return min(share, len(tests) * least, 1.0)


def _p_beside(scatter: _Scatter, test: _Test, beside: list[_Test]) -> float:
    again = _tested(scatter, test.condition, beside)
    return 1.0 if again is None else again.p


def probability_of(p: float, condition: Condition) -> float:
    """That a condition is followed, by its p: if it is stated, as likely as not at
    AS_LIKELY_P."""
    odds = against_noise(p) / against_noise(AS_LIKELY_P)
    odds *= DRIFT if condition.unlisted else 1.0
    return odds / (1 + odds)


def _table(numbers, scatter, contact, chosen, p, left) -> ConditionTable:
    every = [t for t, *_ in chosen]
    found = [
        _follow(numbers, scatter, contact, test, [t for t in every if t is not test])
        | {
            "p": p_own,
            "as_well": more,
            "probability": probability_of(p_own, test.condition),
        }
        for test, p_own, more in chosen
    ]
    following = None
    if left is not None:
        name = effect_name(contact, left[0].condition.name)
        following = (name, probability_of(left[1], left[0].condition))
    return ConditionTable(tuple(Follow(**f) for f in found), p, following)


def _follow(
    numbers: Numbers,
    scatter: _Scatter,
    contact: Contact,
    test: _Test,
    beside: list[_Test],
) -> dict:
    """The size of a curve beside the others."""
    names, c, use = numbers.recordings, test.condition, test.use
    values, kept = use.values, use.kept
    made = _whitened(scatter, use, beside)
    others = made.nuisance.shape[1]

    def fitted(curve: ConditionCurve) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Coefficients, covariance, and coefficients without each recording."""
        own = made.white(use.shift(values, curve)[kept])
        x, y = (
            np.hstack([made.nuisance, own]),
            made.white(numbers.values[kept][:, None])[:, 0],
        )
        inverse = np.linalg.pinv(x.T @ x, hermitian=True)
        size = inverse @ (x.T @ y)
        left = y - x @ size
        square = float((left**2).sum()) + made.usual * USUAL_FREEDOM
        freedom = made.freedom + USUAL_FREEDOM - own.shape[1]
        lever = np.einsum("ij,jk,ik->i", x, inverse, x)
        off = left / np.maximum(1 - lever, 1e-6)
        without = size - (x @ inverse) * off[:, None]
        wide = square / freedom * (stats.t.ppf(ENDS[1], freedom)) ** 2
        return size[others:], wide * inverse[others:, others:], without[:, others:]

    def sized(row: np.ndarray, size, covariance) -> Interval:
        value, half = row @ size, math.sqrt(max(row @ covariance @ row, 0.0))
        each = contact.scale * np.array([value, value - half, value + half])
        return Interval(*map(float, each))

    size, covariance, without = fitted(test.best)
    middle = test.best.columns(use.u(values[kept])).mean(0)
    at = np.unique(values[kept])
    if test.best.shape != "levels":
        at = np.linspace(at[0], at[-1], POINTS)
    rows = test.best.columns(use.u(at)) - middle
    curve = tuple(
        Point(float(x), sized(row, size, covariance))
        for x, row in zip(at, rows, strict=True)
    )
    slope = Interval(math.nan, math.nan, math.nan)
    if not c.levels:
        line = ConditionCurve("line", lambda u: u[:, None], 1)
        own, wide, _ = fitted(line)
        slope = sized(np.array([1 / use.reach]), own, wide)
    columns = test.columns
    shift = columns @ size
    out = contact.scale * shift
    out[kept] = contact.scale * (columns[kept] * without).sum(1)
    sd = np.sqrt(np.diag(scatter.covariance))
    centred = numbers.values - numbers.values[kept].mean()
    return {
        "parameter": contact.name,
        "condition": c.name,
        "shape": shape_of(test.best, curve),
        "slope": slope,
        "curve": curve,
        "levels": c.levels,
        "at": {names[k]: float(values[k]) for k in kept},
        "seen": {
            names[k]: (contact.scale * float(centred[k]), contact.scale * float(sd[k]))
            for k in kept
        },
        "shift": dict(zip(names, shift.tolist(), strict=True)),
        "left_out": dict(zip(names, out.tolist(), strict=True)),
        "unlisted": c.unlisted,
    }
