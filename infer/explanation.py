"""Explanations of a bench, their baselines, and the posterior over them."""

from dataclasses import dataclass, field

import numpy as np

from benchtwin.infer.evidence import EvidenceTable, Kind
from benchtwin.infer.linear import Reduced
from benchtwin.infer.problem import Fit, Problem
from benchtwin.infer.unlisted import Windows

UNSHAPED = "(unlisted)"  # something of no shape that was tried


@dataclass(frozen=True, eq=False)
class Alternative:
    """One baseline."""

    problem: Problem
    odds: float = 1.0  # prior
    note: str = ""  # for the reader where it holds
    effects: tuple[str, ...] = ()  # that it stands for
    kind: Kind = Kind.EFFECT  # of these: listed, or what is unlisted
    sector: str = ""  # of those effects
    # unit, value, sd
    sizes: dict[str, tuple[str, float, float]] = field(default_factory=dict)
    ln_likelihood: float = 0.0  # of what its rows do not hold
    # that noise alone makes as much of it, where its rows do not tell
    p: float | None = None


def ln_bayes_bound(p: float) -> float:
    """ln of −1/(e p ln p), the greatest Bayes factor (Sellke et al. 2001, Am. Stat. 55,
    62)."""
    p = min(max(p, 1e-300), 1 / np.e)
    return float(-1 - np.log(p) - np.log(-np.log(p)))


@dataclass(frozen=True, eq=False)
class Explanation:
    """A set of components about one baseline."""

    names: tuple[str, ...]  # sorted
    alternative: int  # number of the baseline
    fit: Fit  # of the listed effects
    reduced: tuple[Reduced, ...]  # linearised there
    windows: Windows  # of unlisted physics
    columns: np.ndarray  # of the windows
    table: EvidenceTable
    power: float = 1.0  # of the noise at low frequency over the fit's assumption
    probability: float = 0.0  # of exactly this set
    and_more: float = 0.0  # of this set and something of no shape tried

    @property
    def held(self) -> float:
        """Probability of this set, alone or with something of no shape tried."""
        return self.probability + self.and_more

    @property
    def listed(self) -> tuple[str, ...]:
        return tuple(
            n for n in self.names if self.table.components[n].kind is not Kind.UNLISTED
        )

    @property
    def unlisted(self) -> tuple[str, ...]:
        return tuple(
            n for n in self.names if self.table.components[n].kind is Kind.UNLISTED
        )


@dataclass(frozen=True, eq=False)
class Posterior:
    """Explanations, the most probable first; bases: each alternative with nothing
    missing; p_noise: how often noise alone makes as great a mismatch."""

    explanations: tuple[Explanation, ...]
    alternatives: tuple[Alternative, ...]
    bases: tuple[Explanation, ...]
    p_noise: float = 1.0

    @property
    def base(self) -> Explanation:
        """The most probable baseline with nothing missing."""
        return max(self.bases, key=lambda e: e.probability)

    def probability(self, names: tuple[str, ...]) -> float:
        """Of exactly this set, over all alternatives."""
        return sum(p for found, p in self.by_set() if set(found) == set(names))

    def unlisted(self) -> set[str]:
        """The components that are no listed effect."""
        return {n for e in self.explanations for n in e.unlisted} | {UNSHAPED}

    def presence(self) -> dict[str, float]:
        """Probability of each component."""
        out: dict[str, float] = {}
        for names, p in self.by_set():
            for n in names:
                out[n] = out.get(n, 0.0) + p
        return out

    def by_set(self) -> list[tuple[tuple[str, ...], float]]:
        """Sets with their probabilities, the greatest first; they add up to 1."""
        out: dict[tuple[str, ...], float] = {}
        for e in self.explanations:
            out[e.names] = out.get(e.names, 0.0) + e.probability
            if e.and_more:
                more = (*e.names, UNSHAPED)
                out[more] = out.get(more, 0.0) + e.and_more
        return sorted(out.items(), key=lambda entry: -entry[1])
