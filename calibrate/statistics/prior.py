"""Prior of the parameters: uniform over the box, or normal about a stated value and cut
off at the box."""

from dataclasses import dataclass

import numpy as np
from scipy import special, stats

from benchtwin.bench.language import tr
from benchtwin.calibrate.statistics.box import Box


@dataclass(frozen=True, eq=False)
class Prior:
    """Independent factors, each uniform over the box or normal cut off at its limits.

    given: {factor: (mean, sd)} of the normal ones, natural units. Raises ValueError
    naming a factor that is not in the box or an sd ≤ 0."""

    box: Box
    given: dict[str, tuple[float, float]]

    def __post_init__(self):
        for name, (mean, sd) in self.given.items():
            if name not in self.box.names:
                raise ValueError(
                    tr("prior for {}: the box has {}", name, ", ".join(self.box.names))
                )
            if not (np.isfinite(mean) and np.isfinite(sd) and sd > 0):
                raise ValueError(
                    tr(
                        "prior for {}: mean must be finite and sd above 0; here are"
                        " {:g} and {:g}",
                        name,
                        mean,
                        sd,
                    )
                )

    @classmethod
    def uniform(cls, box: Box) -> "Prior":
        return cls(box, {})

    def of(self, names: set[str]) -> "Prior":
        """The prior of some of the factors, which are independent."""
        kept = {n: self.box.range(n) for n in self.box.names if n in names}
        return Prior(Box.of(kept), {n: v for n, v in self.given.items() if n in names})

    def log_density(self, natural: np.ndarray) -> np.ndarray:
        """Log density (n,), not normalised, of natural points (n, k); −∞ outside the
        box."""
        inside = ((natural >= self.box.low) & (natural <= self.box.high)).all(axis=1)
        out = np.where(inside, 0.0, -np.inf)
        for j, name in enumerate(self.box.names):
            if name in self.given:
                mean, sd = self.given[name]
                out = out - 0.5 * ((natural[:, j] - mean) / sd) ** 2
        return out

    def draw(self, n: int, rng: np.random.Generator) -> np.ndarray:
        """n points (n, k) in natural units."""
        u = rng.uniform(size=(n, len(self.box.names)))
        out = self.box.low + u * (self.box.high - self.box.low)
        for j, name in enumerate(self.box.names):
            if name in self.given:
                mean, sd = self.given[name]
                a, b = special.ndtr(
                    (np.array([self.box.low[j], self.box.high[j]]) - mean) / sd
                )
                drawn = mean + sd * special.ndtri(a + u[:, j] * (b - a))
                out[:, j] = np.clip(drawn, self.box.low[j], self.box.high[j])
        return out

    @property
    def sd(self) -> np.ndarray:
        """(k,) standard deviations, natural units."""
        out = (self.box.high - self.box.low) / np.sqrt(12)
        for j, name in enumerate(self.box.names):
            if name in self.given:
                mean, sd = self.given[name]
                a, b = (self.box.low[j] - mean) / sd, (self.box.high[j] - mean) / sd
                out[j] = stats.truncnorm(a, b, loc=mean, scale=sd).std()
        return out
