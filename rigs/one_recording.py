"""What one recording's fit says of its quantities: value, sd, and what else could be
true.

A quantity is a function of the parameters by name; its sd is theirs to first order. The
part of it that all recordings of a session share is what errors of the shared
parameters' priors make of it: √Σ (cov(q, θ)/sd(θ))², sd(θ) of the prior."""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from benchtwin.infer.problem import Fit, joint_covariance
from benchtwin.infer.rivals import Measured, Rival, other_explanations
from benchtwin.vision.measurement import Quantity
from benchtwin.vision.motion.least_squares import believed_sds, slopes

Values = Mapping[str, float]


@dataclass(frozen=True, eq=False)
class OneRecording:
    """A rig's fit of one recording. own: names of its own parameters; of: quantities by
    name from parameters by name; looser: factor on the sds of its rows; beside:
    parameters known otherwise, with their sds."""

    fit: Fit
    own: tuple[str, ...]
    of: Callable[[Values], dict[str, float]]
    looser: float = 1.0
    beside: Mapping[str, tuple[float, float]] | None = None

    @cached_property
    def names(self) -> tuple[str, ...]:
        """All parameters: the recording's own, those that all share, those beside."""
        own = (*self.own, *(f"own {k}" for k in range(len(self.own), self._count)))
        names = (*own, *self.fit.names, *(self.beside or ()))
        assert len(set(names)) == len(names), names
        return names

    @property
    def _count(self) -> int:
        return self.fit.starts.size

    def values_of(self, of: Fit) -> np.ndarray:
        """All parameters of a fit."""
        beside = [value for value, _ in (self.beside or {}).values()]
        return np.concatenate([of.starts.ravel(), of.values, beside])

    def by_name(self, values: np.ndarray) -> dict[str, float]:
        """Parameters by name."""
        return dict(zip(self.names, values.tolist(), strict=True))

    @cached_property
    def at(self) -> dict[str, float]:
        """The quantities."""
        return self.of(self.by_name(self.values_of(self.fit)))

    def quantities(
        self, units: Mapping[str, str], shared: Iterable[str]
    ) -> dict[str, Quantity]:
        """Those of some names, with their sds; shared: parameters whose errors all
        recordings of a session have in common."""

        def asked(values: np.ndarray) -> np.ndarray:
            found = self.of(self.by_name(values))
            return np.array([found[n] for n in units])

        values, fitted = self.values_of(self.fit), self._count + len(self.fit.names)
        sds = np.array([sd for _, sd in (self.beside or {}).values()])
        covariance = np.diag(np.append(np.zeros(fitted), np.square(sds)))
        covariance[:fitted, :fitted] = joint_covariance(self.fit, self.looser)
        moved = slopes(asked, values, np.sqrt(np.diag(covariance)))
        prior = np.append(self.fit.problem.own_sd, self.fit.prior_sd)
        believed = believed_sds(moved, np.append(prior, np.full(len(sds), np.inf)))
        held = np.append(prior, sds)
        across = moved @ covariance
        variance = np.clip((across * moved).sum(1), 0.0, None)
        places = [i for n in shared if held[i := self.names.index(n)] > 0]
        common = ((across[:, places] / held[places]) ** 2).sum(1)
        common = np.sqrt(np.minimum(common, variance))
        told = zip(asked(values), np.sqrt(variance), common, believed, strict=True)
        return {
            name: Quantity(name, value, sd, unit, sd_common=part, believed_sd=prior)
            for (name, unit), (value, sd, part, prior) in zip(
                units.items(), (map(float, row) for row in told), strict=True
            )
        }

    def rivals(self, free: tuple[str, ...] = ()) -> list[Rival]:
        """Each effect that this recording may show; free: those that are free
        already."""
        out = []
        for other in other_explanations(self.fit, free):
            there = replace(self, fit=other.fit).at

            def value(q: Measured, there: dict[str, float] = there) -> float:
                return q.value + there[q.name] - self.at[q.name]

            out.append(Rival(other.odds, other.words, value))
        return out
