"""Explanations of a bench, their baselines, and the posterior over them."""

from dataclasses import dataclass, field

import numpy as np
from benchtwin.infer.evidence import EvidenceTable, Kind
from benchtwin.infer.linear import Reduced
from benchtwin.infer.problem import Fit, Problem
from benchtwin.infer.unlisted import Windows


@dataclass(frozen=True, eq=False)
class Alternative:
    """One baseline."""

    problem: Problem
    odds: float = 1.0  # prior
    note: str = ""  # for the reader where it holds
    effects: tuple[str, ...] = ()  # listed effects that it stands for
    sector: str = ""  # of those effects
    sizes: dict[str, tuple[str, float, float]] = field(
        default_factory=dict
    )  # unit, value, sd
    ln_likelihood: float = 0.0  # of what its rows do not hold
    p: float | None = (
        None  # that noise alone makes as much of it, where its rows do not tell
    )


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
    probability: float = 0.0

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
    missing."""

    explanations: tuple[Explanation, ...]
    alternatives: tuple[Alternative, ...]
    bases: tuple[Explanation, ...]

    @property
    def base(self) -> Explanation:
        """The most probable baseline with nothing missing."""
        return max(self.bases, key=lambda e: e.probability)

    def probability(self, names: tuple[str, ...]) -> float:
        """Of exactly this set, over all alternatives."""
        return sum(
            e.probability for e in self.explanations if set(e.names) == set(names)
        )

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
