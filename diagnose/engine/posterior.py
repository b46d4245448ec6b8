"""Explanations of a bench and their probabilities: which components, about which baseline, with which alternative of what is open.

An explanation is a baseline with a set of components. Sets of up to three are weighed in the reduced space of the fits at hand
(evidence.py), each one component beyond what has been fitted; those that hold weight are fitted in full, and so add their own
reduced space, until nothing that holds weight is left unfitted. Alternatives of what a bench leaves open (does the plate turn
with the block?) are further problems with prior odds; they are summed over.
"""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from itertools import combinations

import numpy as np
from scipy.special import logsumexp

from diagnose.engine.evidence import Component, Kind, Table, settled_noise, student, table_of
from diagnose.engine.linear import Reduced, stacked
from diagnose.engine.locate import Windows, opened, unlisted_of
from diagnose.engine.problem import Fit, Problem, fit

# Prior odds of (listed, unlisted) components: nothing missing ½; a further one beside one that is there in one bench of nine.
PRIOR = {(0, 0): 0.5, (1, 0): 0.28, (2, 0): 0.017, (3, 0): 0.0007, (0, 1): 0.12, (1, 1): 0.02, (2, 1): 0.001}
LISTED_ODDS = 0.03  # of an effect that is an alternative baseline, over that of nothing missing
PENDING = 0.02  # weight of a set that is fitted in full
MOST_FITS = 30
ALIVE = 1e-4  # weight of a baseline, beside the likeliest, below which it is left
LOWER = 10.0  # of χ²: by so much a larger set may have come down lower without having found another minimum
LIKELY = 1e-3  # weight of a single component that is fitted in full where something is missing
CERTAIN = 0.995  # of the weight: then nothing is fitted for it
BENT = 0.5  # probability of nothing below which laws that are not linear about nil are fitted whatever their slope there
WEAK = 5.0  # times its width: a prior tells what is likely to be there, not how much of it was seen


@dataclass(frozen=True, eq=False)
class Alternative:
    """One baseline: problem; odds before the recordings; note: what a reader must know where it holds ("" nothing); named: listed
    effects that it stands for (a plate that climbs in stairs), sector: theirs, sizes: (unit, value, sd) of theirs; ln_likelihood: of
    what its rows do not hold; p: that noise alone makes as much of it, where its rows do not tell."""

    problem: Problem
    odds: float = 1.0
    note: str = ""
    named: tuple[str, ...] = ()
    sector: str = ""
    sizes: dict[str, tuple[str, float, float]] = field(default_factory=dict)
    ln_likelihood: float = 0.0
    p: float | None = None


def of_p_value(p: float) -> float:
    """ln of the greatest Bayes factor that a p value allows, −ln(−e p ln p) for p < 1/e: Sellke, Bayarri, Berger (2001), Am. Stat.
    55, 62."""
    p = min(max(p, 1e-300), 1 / np.e)
    return float(-1 - np.log(p) - np.log(-np.log(p)))


@dataclass(frozen=True, eq=False)
class Explanation:
    """names: its components, sorted; alternative: number of its baseline; fit: of its listed effects, with the reduced space there,
    the windows and their columns in it, and the table of all components; power: of the noise at low frequency over what the fit
    took it for, 1 in the reduced space; probability."""

    names: tuple[str, ...]
    alternative: int
    fit: Fit
    reduced: tuple[Reduced, ...]
    windows: Windows
    columns: np.ndarray
    table: Table
    power: float = 1.0
    probability: float = 0.0

    @property
    def listed(self) -> tuple[str, ...]:
        return tuple(n for n in self.names if self.table.components[n].kind is not Kind.UNLISTED)

    @property
    def unlisted(self) -> tuple[str, ...]:
        return tuple(n for n in self.names if self.table.components[n].kind is Kind.UNLISTED)


@dataclass(frozen=True, eq=False)
class Posterior:
    """explanations, the most probable first; alternatives; bases: the fit with nothing missing of each, and its table."""

    explanations: tuple[Explanation, ...]
    alternatives: tuple[Alternative, ...]
    bases: tuple[Explanation, ...]

    @property
    def base(self) -> Explanation:
        """The likeliest baseline with nothing missing."""
        return max(self.bases, key=lambda e: e.probability)

    @property
    def best(self) -> Explanation:
        return self.explanations[0]

    def probability(self, names: tuple[str, ...]) -> float:
        """Of exactly this set, over all alternatives."""
        return sum(e.probability for e in self.explanations if set(e.names) == set(names))

    def presence(self) -> dict[str, float]:
        """Probability of each component."""
        out: dict[str, float] = {}
        for e in self.explanations:
            for n in e.names:
                out[n] = out.get(n, 0.0) + e.probability
        return out

    def by_set(self) -> list[tuple[tuple[str, ...], float]]:
        """Sets with their probabilities, the greatest first."""
        out: dict[tuple[str, ...], float] = {}
        for e in self.explanations:
            out[e.names] = out.get(e.names, 0.0) + e.probability
        return sorted(out.items(), key=lambda entry: -entry[1])

    def likeliest(self, names: tuple[str, ...]) -> Explanation:
        """The alternative under which this set holds most."""
        return max((e for e in self.explanations if set(e.names) == set(names)), key=lambda e: e.probability)


def explain(alternatives: tuple[Alternative, ...], windows_of: Callable[[Fit], Windows]) -> Posterior:
    """windows_of(fit) → windows, which together are what nobody listed might look like there."""
    search = _Search(alternatives, windows_of)
    for k in range(len(alternatives)):
        search.add(k, ())
    while (pending := search.pending()) is not None:
        search.add(*pending)
    search.begin_again()
    return search.posterior()


class _Search:
    """Fits at hand by alternative and set of listed components, and what they say of every set."""

    def __init__(self, alternatives: tuple[Alternative, ...], windows_of: Callable[[Fit], Windows]):
        self.alternatives, self.windows_of = alternatives, windows_of
        self.tables: list[dict[tuple[str, ...], Explanation]] = [{} for _ in alternatives]
        self.priors: list[dict[tuple[str, ...], float]] = [{} for _ in alternatives]
        self.noise = [(1.0, 0.0) for _ in alternatives]
        self.values: dict[tuple[int, tuple[str, ...], tuple[str, ...]], tuple[float, float]] = {}

    def add(self, k: int, listed: tuple[str, ...], start: Fit | None = None) -> None:
        """Fit `listed` in full about alternative k; from `start`, else from the best of its parts."""
        problem, here = self.alternatives[k].problem, self.tables[k]
        parts = [e.fit for names, e in here.items() if set(names) < set(listed)]
        start = start or min(parts, key=lambda f: f.chi2, default=None)
        found = fit(problem, free=tuple(n for n in listed if n in problem.effects), start=start)
        own, windows = self.alternatives[k], self.windows_of(found)
        reduced, columns = opened(found, windows)
        components = [*_of_effects(problem, reduced), *unlisted_of(windows, columns)]
        components += [_without_columns(n, own.sector, len(columns)) for n in own.named]
        if not listed:
            self.noise[k] = settled_noise(reduced, found.baseline_sd, components, problem.level_sd)
        power, level_sd = self.noise[k]
        root = np.sqrt(power)
        reduced = tuple(replace(r, a=r.a / root, smooth=r.smooth / root, b=r.b / root) for r in reduced)
        components, columns = [replace(c, columns=c.columns / root) for c in components], columns / root
        spread = problem.spread(problem, reduced) if problem.spread else None
        table = table_of(reduced, found.baseline_sd, components, spread, level_sd)
        here[listed] = Explanation(listed, k, found, reduced, windows, columns, table, power)
        if not listed:
            self.priors[k] = _priors(components, self.alternatives[k].odds / sum(a.odds for a in self.alternatives))

    def begin_again(self) -> None:
        """Sets that hold weight are fitted once more from where a larger set came down lower: χ² may have several minima."""
        weights = self.weights()
        total = logsumexp([w for w, _ in weights.values()])
        for k, here in enumerate(self.tables):
            for listed in sorted(here, key=len, reverse=True):
                larger = [e.fit for names, e in here.items() if set(listed) < set(names)]
                best = min(larger, key=lambda f: f.chi2, default=None)
                heavy = weights[k, listed][0] > total + np.log(PENDING)
                if best is None or not heavy or best.chi2 > here[listed].fit.chi2 - LOWER:
                    continue
                before, values = here[listed], {key: v for key, v in self.values.items() if key[:2] == (k, listed)}
                self.add(k, listed, best)
                if here[listed].fit.chi2 > before.fit.chi2:
                    here[listed] = before
                else:
                    for key in values:
                        del self.values[key]

    def weights(self) -> dict[tuple[int, tuple[str, ...]], tuple[float, tuple[str, ...]]]:
        """ln weight of every set about every alternative, and which fit says so: its own, else that of the likeliest of its parts
        of the most components. A misfit counts as in Student's t: see evidence.py."""
        told = {}
        for k, here in enumerate(self.tables):
            own_value = {own: self.value(k, own, own)[0] + self.priors[k][own] for own in here}
            parents: dict[tuple[str, ...], tuple[str, ...]] = {}
            for names in self.priors[k]:
                listed = tuple(n for n in names if self.kind(k, n) is not Kind.UNLISTED)
                if listed not in parents:
                    able = [listed] if listed in here else [own for own in here if set(own) <= set(listed)]
                    parents[listed] = max(able, key=lambda own: (len(own), own_value[own]))
                if len(listed) <= len(parents[listed]) + 1:  # of larger sets a part is looked at first
                    told[k, names] = (*self.value(k, parents[listed], names), parents[listed])
        best = max(fit for _, fit, _ in told.values())
        out = {}
        for (k, names), (value, misfit, own) in told.items():
            level_sd = self.noise[k][1]
            softer = student(misfit - best, level_sd) - (misfit - best)
            out[k, names] = value + softer + self.priors[k][names] + self.alternatives[k].ln_likelihood, own
        return out

    def value(self, k: int, own: tuple[str, ...], names: tuple[str, ...]) -> tuple[float, float]:
        """ln evidence of a set in the reduced space of a fit, and −½ χ² at its best."""
        key = (k, own, names)
        if key not in self.values:
            table = self.tables[k][own].table
            known = all(n in table.components for n in names)  # windows are laid where a fit's motion passes
            found = table.ln_evidence(names) if known else (np.nan, np.nan)
            self.values[key] = found if np.isfinite(found[0]) else (-1e9, -1e9)
        return self.values[key]

    def kind(self, k: int, name: str) -> Kind:
        return self.tables[k][()].table.components[name].kind

    def pending(self) -> tuple[int, tuple[str, ...]] | None:
        """The alternative and listed set to fit next; None where all that holds weight is fitted."""
        if sum(map(len, self.tables)) - len(self.tables) >= MOST_FITS:
            return None
        weights = self.weights()
        total = logsumexp([w for w, _ in weights.values()])
        plain = [k for k, a in enumerate(self.alternatives) if not a.named]
        nothing = sum(np.exp(weights[k, ()][0] - total) for k in plain)
        if nothing > CERTAIN:
            return None
        listed = {key: w for key, (w, _) in weights.items() if all(self.kind(key[0], n) is not Kind.UNLISTED for n in key[1])}
        total = logsumexp(list(listed.values()))
        singles = self._singles() if nothing < BENT else {}
        if singles:
            return max(singles, key=lambda key: singles[key])
        wanted: dict[tuple[int, tuple[str, ...]], float] = {}
        for (k, names), weight in listed.items():
            share = float(np.exp(weight - total))
            if share >= PENDING and names not in self.tables[k]:
                wanted[k, names] = share
            elif share >= PENDING and names:  # it is weighed against its own parts, fitted as it is
                wanted |= {(k, part): 1.0 for part in combinations(names, len(names) - 1) if part not in self.tables[k]}
        return max(wanted, key=lambda key: wanted[key], default=None)

    def _singles(self) -> dict[tuple[int, tuple[str, ...]], float]:
        """Single components that may be missing, as the baselines that are alive tell; those that bend whatever their slope."""
        own = [self.value(k, (), ())[0] + np.log(a.odds) + a.ln_likelihood for k, a in enumerate(self.alternatives)]
        alive = [k for k, value in enumerate(own) if value > max(own) + np.log(ALIVE)]
        told = {
            (k, names): self.value(k, (), names)[0] + self.priors[k][names] + self.alternatives[k].ln_likelihood
            for k in alive for names in self.priors[k] if len(names) == 1 and self.kind(k, names[0]) is not Kind.UNLISTED
        }  # fmt: skip
        total = logsumexp(list(told.values())) if told else 0.0
        return {
            (k, names): value for (k, names), value in told.items() if names not in self.tables[k]
            and (self.alternatives[k].problem.effects[names[0]].bent or value >= total + np.log(LIKELY))
        }  # fmt: skip

    def posterior(self) -> Posterior:
        weights = self.weights()
        total = logsumexp([w for w, _ in weights.values()])
        found, bases = [], []
        for (k, names), (weight, own) in weights.items():
            probability = float(np.exp(weight - total))
            whole = tuple(sorted({*names, *self.alternatives[k].named}))
            explanation = replace(self.tables[k][own], names=whole, probability=probability)
            if not whole:
                bases.append(explanation)
            if probability > 1e-6 or not whole:
                found.append(explanation)
        return Posterior(tuple(sorted(found, key=lambda e: -e.probability)), self.alternatives, tuple(bases))


def _of_effects(problem: Problem, reduced: tuple[Reduced, ...]) -> list[Component]:
    """The listed components as columns of a reduced space."""
    a = stacked(reduced)[0]
    out = []
    for name, effect in problem.effects.items():
        if effect.group or name not in problem.names:
            continue
        own = problem.columns_of(name)
        parts = [problem.effects[n] for n in own]
        at = [problem.names.index(n) for n in own]
        kind = Kind.UNLISTED if effect.unlisted else Kind.CONDITION if effect.follows else Kind.EFFECT
        sd, sized = np.array([p.prior_sd for p in parts]), np.array([p.sized for p in parts])
        out.append(Component(name, kind, effect.sector, a[:, at], sd, sized, effect.low, effect.high))
    return out


def _without_columns(name: str, sector: str, rows: int) -> Component:
    """A listed effect that is an alternative baseline."""
    return Component(name, Kind.EFFECT, sector, np.zeros((rows, 0)), np.zeros(0), np.zeros(0, dtype=bool))


def _priors(components: list[Component], odds: float) -> dict[tuple[str, ...], float]:
    """ln prior of every set of up to three listed components, one unlisted among them at most."""
    listed = [c.name for c in components if c.kind is not Kind.UNLISTED and len(c.sd)]
    unlisted = [c.name for c in components if c.kind is Kind.UNLISTED]
    sets: dict[tuple[int, int], list[tuple[str, ...]]] = {}
    for (count, strange), _ in PRIOR.items():
        some = [tuple(sorted(s)) for s in combinations(listed, count)]
        sets[count, strange] = [tuple(sorted((*s, u))) for s in some for u in unlisted] if strange else some
    total = sum(PRIOR[key] for key, found in sets.items() if found)
    return {s: float(np.log(odds * PRIOR[key] / total / len(found))) for key, found in sets.items() for s in found}
