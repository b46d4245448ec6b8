"""How seed sizes scatter: length, width and thickness drawn together from what
callipers gave."""

from dataclasses import dataclass

import numpy as np
from scipy.stats import beta, norm

from benchtwin.sim.seed import ARRANGEMENTS, SOYBEAN_DENSITY, Seed
from benchtwin.sim.seed.arrange import PLANAR_MARGIN, ROUNDEST_AXIAL

Array = np.ndarray

# Expected range of 100 normal values, in standard deviations (control-chart constant d2
# for n = 100; ASTM STP 15D).
RANGE_OVER_SD_OF_100 = 5.015


@dataclass(frozen=True)
class Size:
    """One dimension's scatter [m]: scaled beta on [least, most] with the stated mean
    and standard deviation.

    A beta never leaves the measured range and takes any mean inside it, which a cut-off
    normal does not. Raises ValueError unless least < mean < most and 0 < sd < √((mean -
    least)(most - mean)), the limit for a beta."""

    least_m: float
    mean_m: float
    most_m: float
    sd_m: float

    def __post_init__(self) -> None:
        if not self.least_m < self.mean_m < self.most_m:
            raise ValueError(
                f"least_m < mean_m < most_m is needed, not {self.least_m:g},"
                f" {self.mean_m:g}, {self.most_m:g}"
            )
        limit = np.sqrt((self.mean_m - self.least_m) * (self.most_m - self.mean_m))
        if not 0.0 < self.sd_m < limit:
            raise ValueError(
                f"sd_m = {self.sd_m:g} m: must be above 0 and below {limit:g} m"
            )

    @classmethod
    def from_range_of_100(cls, least_m: float, mean_m: float, most_m: float) -> "Size":
        """Size when only the range and mean of about 100 seeds are known: sd = (most -
        least)/5.015, as for a normal scatter."""
        return cls(least_m, mean_m, most_m, (most_m - least_m) / RANGE_OVER_SD_OF_100)

    def at(self, probability: Array) -> Array:
        """Quantiles [m] at probabilities in [0, 1], any shape."""
        span = self.most_m - self.least_m
        mean, sd = (self.mean_m - self.least_m) / span, self.sd_m / span
        total = mean * (1.0 - mean) / sd**2 - 1.0
        return self.least_m + span * beta.ppf(
            probability, mean * total, (1.0 - mean) * total
        )


@dataclass(frozen=True)
class Sizes:
    """Length, width and thickness of a lot of seeds, with the correlation (0 ≤ ρ < 1)
    of their normal scores between any two."""

    length: Size
    width: Size
    thickness: Size
    correlation: float

    def __post_init__(self) -> None:
        if not 0.0 <= self.correlation < 1.0:
            raise ValueError(
                f"correlation = {self.correlation:g}: must be 0 or more and below 1"
            )

    def sample(self, rng: np.random.Generator, n: int, *, margin: float = 1.0) -> Array:
        """Draw n seeds' (length, width, thickness) [m], (n, 3), through a Gaussian
        copula.

        A draw is repeated unless length ≥ margin·width, width ≥ margin·thickness
        (length is by definition the longest) and length ≥ 1.02 √(width·thickness); for
        the soybeans below that is 1 in 40, and moves no mean by more than 0.02 mm.
        Raises ValueError for n < 0, and when less than 1 draw in 20 is in order."""
        if n < 0:
            raise ValueError(f"n = {n}: must be 0 or more")
        kept, drawn = [np.empty((0, 3))], 0
        while sum(map(len, kept)) < n:
            common, own = rng.standard_normal((n, 1)), rng.standard_normal((n, 3))
            score = norm.cdf(
                np.sqrt(self.correlation) * common
                + np.sqrt(1.0 - self.correlation) * own
            )
            length, width, thickness = (
                s.at(p)
                for s, p in zip((self.length, self.width, self.thickness), score.T)
            )
            fits = (length >= margin * width) & (width >= margin * thickness)
            fits &= length >= ROUNDEST_AXIAL * np.sqrt(width * thickness)
            kept.append(np.c_[length, width, thickness][fits])
            drawn += n
            if drawn >= 1000 and sum(map(len, kept)) < drawn / 20:
                raise ValueError(
                    "sizes: fewer than 1 in 20 draws has length ≥ width ≥ thickness;"
                    " check the means"
                )
        return np.vstack(kept)[:n]

    def sample_batch(
        self,
        rng: np.random.Generator,
        n: int,
        spheres: int = 5,
        *,
        density_kg_m3: float = SOYBEAN_DENSITY,
        arrangement: str = "axial",
        mass_of: str = "union",
    ) -> list[Seed]:
        """Draw n seeds, each its own `Seed.from_dimensions` with these options (0.1 ms
        a seed axial, 10 to 20 ms planar).

        Planar clumps need width and thickness 2 % apart: 1 more draw in 46 is repeated
        for them."""
        if arrangement not in ARRANGEMENTS:
            raise ValueError(
                f"arrangement = {arrangement!r}: must be one of"
                f" {', '.join(ARRANGEMENTS)}"
            )
        margin = PLANAR_MARGIN if arrangement == "planar" else 1.0
        return [
            Seed.from_dimensions(
                length,
                width,
                thickness,
                spheres,
                density_kg_m3=density_kg_m3,
                arrangement=arrangement,
                mass_of=mass_of,
            )
            for length, width, thickness in self.sample(rng, n, margin=margin)
        ]


# Callipers on 100 seeds (soybean calibration paper, "Test materials"). It gives ranges
# and means only: the scatter is assumed normal-like (`from_range_of_100`), the
# correlation 0.6 is assumed too (a large seed is large all round).
SOYBEAN = Sizes(
    length=Size.from_range_of_100(7.60e-3, 8.72e-3, 10.00e-3),
    width=Size.from_range_of_100(5.30e-3, 6.84e-3, 7.70e-3),
    thickness=Size.from_range_of_100(4.60e-3, 5.98e-3, 7.00e-3),
    correlation=0.6,
)
