"""Which conditions a contact parameter follows, and by what curve: weighed by evidence
in the table of each recording's own value.

Recording r's value is y_r = m + Σ f(x_r) + scatter, of covariance φ (C + λ c 1): C from
the rows of all recordings, everything common and every listed effect left free, c its
mean variance; λ one of LAMBDAS; φ with a prior by which the usual scatter is worth
USUAL_FREEDOM recordings (Smyth 2004, Stat. Appl. Genet. Mol. Biol. 3, 3). f is a curve
of a condition, normal with the covariance φ g² K, K of unit signal-to-noise ratio in
the rows and g one of UNLISTED_SNRS (Zellner & Siow 1980). With m and φ integrated out,
of n recordings,

    ln p(y | λ, g, K) = −½ ln det V − ½ ln 1ᵀV⁻¹1 − ½ (ν + n − 1) ln(ν + yᵀPy)

Whatever the recordings hold besides is common to them or in their scatter, so it
neither makes a condition nor hides one. A recording that lies off by itself is weighed
alike. What is likeliest is taken, one after another, as long as it is likely; p is how
often scatter alone, drawn, makes as much of all conditions together."""

import math
from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np
from scipy import stats
from scipy.special import logsumexp

from benchtwin.infer.condition_curves import Use, shape_of, use_of
from benchtwin.infer.conditions import Condition, Contact, effect_name
from benchtwin.infer.evidence import UNLISTED_SNRS
from benchtwin.infer.follow import ConditionTable, Follow, Point
from benchtwin.infer.linear import projector, stacked
from benchtwin.infer.problem import Fit
from benchtwin.infer.verdict import ENDS, Interval

USUAL_FREEDOM = 2.0  # recordings that the usual scatter is worth
# more scatter than the rows', in their mean variance, and its prior
LAMBDAS, LAMBDA_ODDS = (0.0, 3.0, 15.0, 63.0), (0.8, 0.15, 0.04, 0.01)
FOLLOWED_ODDS = 0.3  # that any stated condition is followed, over none
ODD = 0.03  # that a recording lies off by itself
# prior odds of a drift over those of a condition, which is stated because it may matter
DRIFT = 0.5
FOUND_PROBABILITY = 0.6
AS_WELL = 0.05  # odds of a condition over the likeliest, from which it explains as well
# of a curve's power in one recording, beyond which it rests on that
MOST_SHARE = 0.6
DRAWS = 2_000
POINTS = 25  # of a curve that is drawn
UNTOLD = 1e-10  # relative information of a contrast that the rows do not tell
HIDDEN = 1e-6  # relative power of a column that what stands beside it takes up
SQUARES = tuple(g**2 for g in UNLISTED_SNRS)


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


@dataclass(frozen=True, eq=False)
class _Rows:
    """Some recordings at one λ, whitened, what stands beside taken out."""

    whiten: np.ndarray  # (m, n)
    ln_prior: float  # of λ, and what is the same for all curves
    sd: np.ndarray  # (n,)

    @property
    def freedom(self) -> float:
        return USUAL_FREEDOM + len(self.whiten)

    def square(self, y: np.ndarray) -> np.ndarray:
        """(D,): of whitened values y (n, D)."""
        return ((self.whiten @ y) ** 2).sum(0)

    def seen(self, k: np.ndarray) -> np.ndarray:
        """(m, m): a covariance (n, n), of unit signal-to-noise ratio."""
        white = self.whiten @ k @ self.whiten.T
        return white / np.trace(white)

    def ln_marginal(self, ln_det: float, square: np.ndarray) -> np.ndarray:
        """ln p of values of this square (D,), whose covariance has that ln det."""
        spread = 0.5 * self.freedom * np.log(USUAL_FREEDOM + square)
        return self.ln_prior - 0.5 * ln_det - spread


@dataclass(frozen=True, eq=False)
class _Candidate:
    """What may act, beside what was found."""

    use: Use
    odds: float  # beforehand, over nothing
    rows: tuple[_Rows, ...]  # a λ each

    def ln_each(self, y: np.ndarray) -> np.ndarray:
        """(L, S, G, D): ln p of values y (R, D) by λ, shape and g, priors included."""
        u, kernels, y = self.use.u, self.use.kernels, y[self.use.kept]
        made = len(self.rows), len(kernels), len(SQUARES), y.shape[1]
        out = np.full(made, -math.log(len(kernels) * len(SQUARES)))
        for i, rows in enumerate(self.rows):
            for j, kernel in enumerate(kernels.values()):
                power, axes = np.linalg.eigh(rows.seen(kernel(u, u)))
                along = (axes.T @ rows.whiten @ y) ** 2
                for k, square in enumerate(SQUARES):
                    wide = 1 + square * np.maximum(power, 0.0)
                    left = (along / wide[:, None]).sum(0)
                    out[i, j, k] += rows.ln_marginal(np.log(wide).sum(), left)
        return out

    def ln_odds(self, y: np.ndarray) -> np.ndarray:
        """(D,): that it acts, over nothing."""
        some = y[self.use.kept]
        nothing = [rows.ln_marginal(0.0, rows.square(some)) for rows in self.rows]
        acts = logsumexp(self.ln_each(y), axis=(0, 1, 2))
        return math.log(self.odds) + acts - logsumexp(nothing, axis=0)

    def beside(self, table: "_Table") -> "_Candidate":
        """The same beside what stands there."""
        return replace(self, rows=table.rows(self.use.kept))

    @property
    def told(self) -> bool:
        """Whether anything of it is not hidden by what stands beside."""
        white, u = self.rows[0].whiten, self.use.u
        if len(white) < 2:
            return False
        loud = (white**2).sum(0)  # of each recording
        return all(
            np.trace(white @ (k := kernel(u, u)) @ white.T)
            > HIDDEN * float(loud @ np.diag(k))
            for kernel in self.use.kernels.values()
        )

    def likeliest_shape(self, y: np.ndarray) -> str:
        each = logsumexp(self.ln_each(y)[..., 0], axis=(0, 2))
        return list(self.use.kernels)[int(np.argmax(each))]

    def curve(
        self, y: np.ndarray, shape: str, at: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Values (p,) of a curve at u = `at`, beside its mean over the recordings,
        halves of their 95 % intervals, and the recordings' sds (n,); at the likeliest λ
        and the greatest g: a prior is for presence, not for size (Rasmussen & Williams
        2006, eq. 2.23)."""
        j = list(self.use.kernels).index(shape)
        i = int(np.argmax(logsumexp(self.ln_each(y)[:, j, :, 0], axis=1)))
        rows, kernel, u = self.rows[i], self.use.kernels[shape], self.use.u
        n, every = len(u), np.concatenate([u, at])
        k = kernel(every, every)
        k *= SQUARES[-1] / np.trace(rows.whiten @ k[:n, :n] @ rows.whiten.T)
        beside = np.hstack([np.full((len(at), n), -1 / n), np.eye(len(at))])
        along = beside @ k[:, :n] @ rows.whiten.T
        whole = np.eye(len(rows.whiten)) + rows.whiten @ k[:n, :n] @ rows.whiten.T
        z = rows.whiten @ y[self.use.kept, 0]
        gain = np.linalg.solve(whole, along.T).T
        phi = (USUAL_FREEDOM + z @ np.linalg.solve(whole, z)) / rows.freedom
        variance = np.maximum(np.diag(beside @ k @ beside.T - gain @ along.T), 0.0)
        half = stats.t.ppf(ENDS[1], rows.freedom) * np.sqrt(phi * variance)
        return gain @ z, half, math.sqrt(phi) * rows.sd


@dataclass(frozen=True, eq=False)
class _Table:
    """The table, and columns (R, k) that stand beside whatever is weighed."""

    numbers: Numbers
    beside: tuple[np.ndarray, ...] = ()

    @property
    def y(self) -> np.ndarray:
        """(R, 1)."""
        return self.numbers.values[:, None]

    def root(self, more: float, kept: np.ndarray) -> np.ndarray:
        """(n, n): of the covariance of some recordings, with so much more scatter."""
        c = self.numbers.covariance
        c = c + more * float(np.trace(c)) / len(c) * np.eye(len(c))
        return np.linalg.cholesky(c[np.ix_(kept, kept)])

    def rows(self, kept: np.ndarray) -> tuple[_Rows, ...]:
        """Some recordings at each λ."""
        columns = np.column_stack([np.ones(len(self.y)), *self.beside])[kept]
        out = []
        for more, odds in zip(LAMBDAS, LAMBDA_ODDS, strict=True):
            root = self.root(more, kept)
            white = np.linalg.inv(root)
            axes, size, _ = np.linalg.svd(white @ columns)
            told = int((size > math.sqrt(HIDDEN) * size[0]).sum())
            ln_det = float(np.log(np.diag(root)).sum() + np.log(size[:told]).sum())
            prior, sd = math.log(odds) - ln_det, np.linalg.norm(root, axis=1)
            out.append(_Rows(axes[:, told:].T @ white, prior, sd))
        return tuple(out)

    def candidates(
        self, sources: Iterable[Condition | int], odds: float
    ) -> list[_Candidate]:
        """Conditions, or recordings (their numbers) by themselves: those of which the
        rows can tell something; odds: of each, beforehand."""
        made = []
        for one in sources:
            if use := use_of(self.numbers.recordings, one, MOST_SHARE):
                own = odds * (DRIFT if use.unlisted else 1.0)
                made.append(_Candidate(use, own, self.rows(use.kept)))
        return [one for one in made if one.told]

    def having(self, found: _Candidate) -> "_Table":
        """The same beside what was found."""
        use, shape = found.use, found.likeliest_shape(self.y)
        columns = use.u[:, None]
        if shape == "levels":
            columns = (columns == np.unique(use.u)[1:]) * 1.0
        if shape == "curve":
            columns = np.column_stack([columns, found.curve(self.y, shape, use.u)[0]])
        whole = np.zeros((len(self.y), columns.shape[1]))
        whole[use.kept] = columns
        return _Table(self.numbers, (*self.beside, whole))

    def drawn(self, rng: np.random.Generator) -> np.ndarray:
        """(R, DRAWS): values of scatter alone, of which these show how great it is."""
        every = np.arange(len(self.y))
        rows = self.rows(every)
        squares = np.array([float(one.square(self.y)[0]) for one in rows])
        ln = np.array([r.ln_marginal(0.0, s) for r, s in zip(rows, squares)])
        weight = np.exp(ln - ln.max())
        which = rng.choice(len(rows), DRAWS, p=weight / weight.sum())
        roots = np.array([self.root(more, every) for more in LAMBDAS])
        normal = rng.standard_normal((DRAWS, len(self.y)))
        size = USUAL_FREEDOM + squares[which]
        size = np.sqrt(size / rng.chisquare(rows[0].freedom, DRAWS))
        return np.einsum("dij,dj->id", roots[which], normal) * size


@dataclass(frozen=True, eq=False)
class _Likeliest:
    """Of some candidates the likeliest, what explains nearly as well and is not needed
    beside it, and the probability that one of them acts, recordings by themselves
    not among them."""

    best: _Candidate
    as_well: tuple[_Candidate, ...]
    probability: float
    alone: float  # that it is the best

    @classmethod
    def of(cls, table: _Table, some: list[_Candidate]) -> "_Likeliest":
        ln = {c: float(c.ln_odds(table.y)[0]) for c in some}
        best = max(some, key=lambda c: ln[c])
        after = table.having(best)

        def needed(c: _Candidate) -> bool:
            again = c.beside(after)
            return again.told and again.ln_odds(table.y)[0] > 0

        near = [c for c in some if ln[c] > ln[best] + math.log(AS_WELL)]
        rivals = [c for c in near if c is not best and not needed(c)]
        whole = np.logaddexp(0.0, logsumexp([ln[c] for c in (best, *rivals)]))
        same = [c for c in rivals if c.use.name and best.use.name]
        share = np.exp(np.array([ln[c] for c in (best, *same)]) - whole)
        stated = [c for c in same if not c.use.unlisted]
        if best.use.unlisted and stated:  # a cause that is stated, if there is
            best, *stated = sorted(stated, key=lambda c: -ln[c])
        return cls(best, tuple(stated), float(share.sum()), float(share[0]))


def condition_table(
    numbers: Numbers | None,
    contact: Contact,
    conditions: tuple[Condition, ...],
    rng: np.random.Generator,
) -> ConditionTable:
    """All conditions weighed, the likeliest first."""
    if numbers is None or not conditions:
        return ConditionTable()
    table, left, far = _Table(numbers), list(conditions), None
    count, first, following = len(numbers.recordings), None, None
    acting: list[_Candidate] = []
    found: list[tuple[_Likeliest, float]] = []
    while some := table.candidates(left, FOLLOWED_ODDS / len(conditions)):
        p = _chance(table, some, rng)
        first = p if first is None else first
        odd = [] if far else table.candidates(range(count), ODD / count)
        likeliest = _Likeliest.of(table, [*some, *odd])
        if likeliest.best in odd and likeliest.probability < FOUND_PROBABILITY:
            likeliest = _Likeliest.of(table, some)
        best = likeliest.best
        if likeliest.probability < FOUND_PROBABILITY:
            following = effect_name(contact, best.use.name), likeliest.alone
            break
        acting.append(best)
        table = table.having(best)
        if best in odd:
            r = int(np.argmax(best.use.u))
            off = float(numbers.values[r] - np.median(numbers.values))
            far = numbers.recordings[r], contact.scale * off
            continue
        found.append((likeliest, p))
        taken = {c.use.name for c in (best, *likeliest.as_well)}
        left = [one for one in left if one.name not in taken]
    follows = []
    for one, p in found:
        others = _Table(numbers)
        for other in acting:
            others = others if other is one.best else others.having(other)
        follows.append(_follow(others, contact, one, p))
    return ConditionTable(tuple(follows), first, following, far)


def _chance(table: _Table, some: list[_Candidate], rng: np.random.Generator) -> float:
    """How often scatter alone makes as much of all conditions together: by draws, and
    at most the odds beforehand over those found (Markov's inequality)."""
    seen, drawn = (
        logsumexp([c.ln_odds(y) for c in some], axis=0)
        for y in (table.y, table.drawn(rng))
    )
    share = (1 + float((drawn >= seen).sum())) / (1 + DRAWS)
    bound = sum(c.odds for c in some) * math.exp(-min(float(seen[0]), 500.0))
    return min(share, bound, 1.0)


def _follow(others: _Table, contact: Contact, of: _Likeliest, p: float) -> Follow:
    """What was found, sized beside all else that was."""
    own, y, names = of.best.beside(others), others.y, others.numbers.recordings
    use, shape = own.use, own.likeliest_shape(y)

    def sized(shape: str, at: np.ndarray) -> list[Interval]:
        value, half, _ = own.curve(y, shape, at)
        ends = contact.scale * np.array([value, value - half, value + half])
        return [Interval(*map(float, one)) for one in ends.T]

    at = np.unique(use.u) if shape == "levels" else np.linspace(0.0, 1.0, POINTS)
    places = (use.low + use.reach * at).tolist()
    curve = tuple(map(Point, places, sized(shape, at)))
    slope = Interval(math.nan, math.nan, math.nan)
    if not use.levels:
        one = sized("line", np.array([use.u.mean() + 1]))[0]
        slope = Interval(*(v / use.reach for v in vars(one).values()))
    shift, out = np.zeros(len(names)), np.zeros(len(names))
    shift[use.kept], _, sd = own.curve(y, shape, use.u)
    for u, r in zip(use.u, use.kept, strict=True):
        alone = np.eye(len(names))[:, [r]]
        without = own.beside(_Table(others.numbers, (*others.beside, alone)))
        if without.told:
            out[r] = contact.scale * without.curve(y, shape, np.array([u]))[0][0]
    centred = contact.scale * (y[use.kept, 0] - y[use.kept].mean())
    seen = zip(centred.tolist(), (contact.scale * sd).tolist(), strict=True)
    kept = [names[k] for k in use.kept]
    return Follow(
        parameter=contact.name,
        condition=use.name,
        shape=shape_of(shape, curve),
        p=p,
        probability=of.probability,
        slope=slope,
        curve=curve,
        levels=use.levels,
        at=dict(zip(kept, use.values[use.kept].tolist(), strict=True)),
        seen=dict(zip(kept, seen, strict=True)),
        shift=dict(zip(names, shift.tolist(), strict=True)),
        left_out=dict(zip(names, out.tolist(), strict=True)),
        unlisted=use.unlisted,
        as_well=tuple(c.use.name for c in of.as_well),
    )
