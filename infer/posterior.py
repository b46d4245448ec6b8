"""Posterior over explanations: sets of components about alternative baselines.

Sets of up to three components are weighed in the linearised problems at hand
(evidence.py), each with one component at most beyond what has been fitted. Sets with
weight are fitted in full and add their own linearisation, until every set with weight
is fitted. Alternatives of what a bench leaves open (does the plate turn with the
block?) have prior odds and are summed over."""

from collections.abc import Callable
from dataclasses import replace
from itertools import combinations

import numpy as np

from benchtwin.infer.evidence import (
    Component,
    Kind,
    refined_noise_power,
    student_ln_likelihood,
    table_of,
)
from benchtwin.infer.explanation import (
    Alternative,
    Explanation,
    Posterior,
)
from benchtwin.infer.linear import Reduced, stacked
from benchtwin.infer.problem import Fit, Problem, fit
from benchtwin.infer.unlisted import (
    Windows,
    unlisted_components,
    window_columns,
)

# Prior probability of (listed, unlisted) components, learnt by the log score of 66
# benches of an independent generator (both halves of them and each rig agree).
# Something unlisted takes any shape and fits what a listed law leaves of itself: hence
# its small prior.
PRIOR = {
    (0, 0): 0.5,
    (1, 0): 0.45,
    (2, 0): 0.027,
    (3, 0): 0.001,
    (0, 1): 0.02,
    (1, 1): 0.003,
    (2, 1): 0.0002,
}
LISTED_ODDS = 0.03  # of an effect that is an alternative baseline, over nothing missing
FIT_WEIGHT = 0.02  # of a set that is fitted in full
MOST_FITS = 30
BASELINE_WEIGHT = 1e-4  # beside the likeliest baseline, below which one is dropped
SINGLE_WEIGHT = 1e-3  # of a single component that is fitted in full
NOTHING_CERTAIN = 0.995  # probability of nothing missing at which no more is fitted
# below which nonlinear effects are fitted whatever their slope at 0
NOTHING_DOUBTFUL = 0.5
# factor on priors for estimates: a prior is for presence, not for size
WIDE_PRIOR = 5.0
# ln weight of every set (alternative, names), and the fitted set that it is told by
Weights = dict[tuple[int, tuple[str, ...]], tuple[float, tuple[str, ...]]]


def explain(
    alternatives: tuple[Alternative, ...],
    windows_of: Callable[[Fit], Windows],
    bases: tuple[Fit, ...],
) -> Posterior:
    """The posterior; windows_of(fit) → windows, which together model unlisted physics;
    bases: each alternative fitted with nothing missing."""
    search = _Search(alternatives, windows_of, bases)
    for k in range(len(bases)):
        search.add(k, ())
    while (next_fit := search.next_fit()) is not None:
        search.add(*next_fit)
    return search.posterior()


class _Search:
    """Fits by alternative and set of listed components, and their evidence for every
    set."""

    def __init__(
        self,
        alternatives: tuple[Alternative, ...],
        windows_of: Callable[[Fit], Windows],
        bases: tuple[Fit, ...],
    ):
        self.alternatives, self.windows_of = alternatives, windows_of
        self.bases = bases
        self.tables: list[dict[tuple[str, ...], Explanation]] = [
            {} for _ in alternatives
        ]
        self.priors: list[dict[tuple[str, ...], float]] = [{} for _ in alternatives]
        self.noise = [(1.0, 0.0) for _ in alternatives]
        self.values: dict[
            tuple[int, tuple[str, ...], tuple[str, ...]], tuple[float, float]
        ] = {}

    def add(self, k: int, listed: tuple[str, ...]) -> None:
        """Fit a set of listed components, from the best fitted subset."""
        problem, here = self.alternatives[k].problem, self.tables[k]
        parts = [e.fit for names, e in here.items() if set(names) < set(listed)]
        start = min(parts, key=lambda f: f.chi2, default=None)
        if start is None:
            found = self.bases[k]
        else:
            free = tuple(n for n in listed if n in problem.effects)
            found = fit(problem, free=free, start=start)
        own = self.alternatives[k]
        noise = self.noise[k] if listed else None
        e = explanation_of(found, listed, k, own, self.windows_of(found), noise)
        here[listed] = e
        if not listed:
            self.noise[k] = e.power, e.table.level_sd
            self.priors[k] = _priors(
                list(e.table.components.values()),
                own.odds / sum(a.odds for a in self.alternatives),
            )

    def weights(self) -> Weights:
        """ln weight of every set, and the fitted set from which it is computed.

        That is the set itself, else its fitted subset with the most components, the
        likeliest of these. Misfit counts as in Student's t: see evidence.py."""
        weighed = {}
        for k, here in enumerate(self.tables):
            own_value = {
                own: self.value(k, own, own)[0] + self.priors[k][own] for own in here
            }
            parents: dict[tuple[str, ...], tuple[str, ...]] = {}
            for names in self.priors[k]:
                listed = self.listed(k, names)
                if listed not in parents:
                    if listed in here:
                        able = [listed]
                    else:
                        able = [own for own in here if set(own) <= set(listed)]
                    parents[listed] = max(
                        able, key=lambda own: (len(own), own_value[own])
                    )
                # larger sets wait for a fitted subset
                if len(listed) <= len(parents[listed]) + 1:
                    weighed[k, names] = (
                        *self.value(k, parents[listed], names),
                        parents[listed],
                    )
        # alternatives may differ in what scatter they leave
        volume = [sum(r.half_ln_det for r in here[()].reduced) for here in self.tables]
        best = max(fit - volume[k] for (k, _), (_, fit, _) in weighed.items())
        out = {}
        for (k, names), (value, fit_misfit, own) in weighed.items():
            misfit, level_sd = fit_misfit - volume[k], self.noise[k][1]
            softer = student_ln_likelihood(misfit - best, level_sd) - (misfit - best)
            out[k, names] = (
                value
                + softer
                + self.priors[k][names]
                + self.alternatives[k].ln_likelihood,
                own,
            )
        return out

    def value(
        self, k: int, own: tuple[str, ...], names: tuple[str, ...]
    ) -> tuple[float, float]:
        """ln evidence of a set in one fit's linearisation, and −½ χ² at its best."""
        key = (k, own, names)
        if key not in self.values:
            table = self.tables[k][own].table
            # windows are laid where a fit's motion passes
            known = all(n in table.components for n in names)
            found = table.ln_evidence(names) if known else (np.nan, np.nan)
            self.values[key] = found if np.isfinite(found[0]) else (-1e9, -1e9)
        return self.values[key]

    def kind(self, k: int, name: str) -> Kind:
        return self.tables[k][()].table.components[name].kind

    def listed(self, k: int, names: tuple[str, ...]) -> tuple[str, ...]:
        """Those that are listed, which can be fitted in full."""
        return tuple(n for n in names if self.kind(k, n) is not Kind.UNLISTED)

    def next_fit(self) -> tuple[int, tuple[str, ...]] | None:
        """The alternative and set to fit next; None where every set with weight is
        fitted."""
        if sum(map(len, self.tables)) - len(self.tables) >= MOST_FITS:
            return None
        weights = self.weights()
        total = np.logaddexp.reduce([w for w, _ in weights.values()])
        plain = [k for k, a in enumerate(self.alternatives) if not a.effects]
        nothing = sum(np.exp(weights[k, ()][0] - total) for k in plain)
        if nothing > NOTHING_CERTAIN:
            return None
        listed = {key: self.listed(*key) for key in weights}
        of_listed = np.logaddexp.reduce(
            [w for key, (w, _) in weights.items() if listed[key] == key[1]]
        )
        singles = (
            self._single_effects_to_fit(weights) if nothing < NOTHING_DOUBTFUL else {}
        )
        if singles:
            return max(singles, key=lambda key: singles[key])
        wanted: dict[tuple[int, tuple[str, ...]], float] = {}
        for (k, names), (weight, _) in weights.items():
            fitted = listed[k, names]
            share = float(np.exp(weight - (of_listed if fitted == names else total)))
            if share >= FIT_WEIGHT and fitted not in self.tables[k]:
                wanted[k, fitted] = share
            elif share >= FIT_WEIGHT and fitted:
                # it is compared with its subsets, fitted as well
                wanted |= {
                    (k, part): 1.0
                    for part in combinations(fitted, len(fitted) - 1)
                    if part not in self.tables[k]
                }
        return max(wanted, key=lambda key: wanted[key], default=None)

    def _single_effects_to_fit(
        self, weights: Weights
    ) -> dict[tuple[int, tuple[str, ...]], float]:
        """Unfitted single components that may be missing; nonlinear ones whatever their
        slope."""
        every = range(len(self.alternatives))
        # of baselines that are likely as they are, or with anything beside them
        alone = np.array([weights[k, ()][0] for k in every])
        at_best = np.full(len(alone), -np.inf)
        for (k, _), (weight, _) in weights.items():
            at_best[k] = max(at_best[k], weight)
        least = np.log(BASELINE_WEIGHT)
        alive = (alone > alone.max() + least) | (at_best > at_best.max() + least)
        singles = {
            (k, names): self.value(k, (), names)[0]
            + prior
            + self.alternatives[k].ln_likelihood
            for k in np.flatnonzero(alive)
            for names, prior in self.priors[k].items()
            if len(names) == 1 and self.kind(k, names[0]) is not Kind.UNLISTED
        }
        total = np.logaddexp.reduce(list(singles.values())) if singles else 0.0
        heavy = total + np.log(SINGLE_WEIGHT)
        unfitted: dict[tuple[int, tuple[str, ...]], float] = {}
        for (k, names), value in singles.items():
            nonlinear = self.alternatives[k].problem.effects[names[0]].nonlinear
            if names not in self.tables[k] and (nonlinear or value >= heavy):
                unfitted[k, names] = value
        return unfitted

    def posterior(self) -> Posterior:
        weights = self.weights()
        total = np.logaddexp.reduce([w for w, _ in weights.values()])
        found, bases = [], []
        for (k, names), (weight, own) in weights.items():
            probability = float(np.exp(weight - total))
            whole = tuple(sorted({*names, *self.alternatives[k].effects}))
            explanation = replace(
                self.tables[k][own], names=whole, probability=probability
            )
            if not whole:
                bases.append(explanation)
            if probability > 1e-6 or not whole:
                found.append(explanation)
        ranked = sorted(found, key=lambda e: -e.probability)
        return Posterior(tuple(ranked), self.alternatives, tuple(bases))


def explanation_of(
    found: Fit,
    names: tuple[str, ...],
    k: int,
    own: Alternative,
    windows: Windows,
    noise: tuple[float, float] | None,
) -> Explanation:
    """What a fit of the listed components `names` about alternative k says of all;
    noise: its power and the sd of its logarithm, None: estimated."""
    problem = found.problem
    reduced, columns = window_columns(found, windows)
    components = [
        *_of_effects(problem, reduced),
        *unlisted_components(windows, columns),
    ]
    nil = np.zeros((len(columns), 0)), np.zeros(0), np.zeros(0, dtype=bool)
    components += [Component(n, own.kind, own.sector, *nil) for n in own.effects]
    power, level_sd = noise or refined_noise_power(
        reduced, found.baseline_sd, components, problem.level_sd
    )
    root = np.sqrt(power)
    reduced = tuple(
        replace(r, a=r.a / root, smooth=r.smooth / root, b=r.b / root) for r in reduced
    )
    components = [replace(c, columns=c.columns / root) for c in components]
    spread = problem.unknown_scatter and problem.unknown_scatter(problem, reduced)
    table = table_of(reduced, found.baseline_sd, components, spread, level_sd)
    return Explanation(names, k, found, reduced, windows, columns / root, table, power)


def _of_effects(problem: Problem, reduced: tuple[Reduced, ...]) -> list[Component]:
    """The listed effects as components."""
    a = stacked(reduced)[0]
    out = []
    for name, effect in problem.effects.items():
        if effect.group or name not in problem.names:
            continue
        own = problem.columns_of(name)
        parts = [problem.effects[n] for n in own]
        at = [problem.names.index(n) for n in own]
        kind = Kind.UNLISTED if effect.unlisted else Kind.EFFECT
        sd = np.array([p.prior_sd for p in parts])
        scaled_prior = np.array([p.scaled_prior for p in parts])
        ends = (effect.low, effect.high)
        out.append(
            Component(name, kind, effect.sector, a[:, at], sd, scaled_prior, *ends)
        )
    return out


def _priors(components: list[Component], odds: float) -> dict[tuple[str, ...], float]:
    """ln prior of every set of up to three listed components with at most one
    unlisted."""
    listed = [c.name for c in components if c.kind is not Kind.UNLISTED and len(c.sd)]
    unlisted = [c.name for c in components if c.kind is Kind.UNLISTED and len(c.sd)]
    sets: dict[tuple[int, int], list[tuple[str, ...]]] = {}
    for (count, strange), _ in PRIOR.items():
        some = [tuple(sorted(s)) for s in combinations(listed, count)]
        sets[count, strange] = (
            [tuple(sorted((*s, u))) for s in some for u in unlisted]
            if strange
            else some
        )
    total = sum(PRIOR[key] for key, found in sets.items() if found)
    return {
        s: float(np.log(odds * PRIOR[key] / total / len(found)))
        for key, found in sets.items()
        for s in found
    }
