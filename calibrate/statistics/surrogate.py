"""What stands for the simulation in the posterior: a polynomial with shrinkage through
the runs. Effects that the runs do not show are held near zero; cubic terms are added.

Coded coefficients but the intercept's are normal about 0 beforehand, with sd
σ√g·r^(order − 1): main effects √g, squares and interactions r times that, cubes r²
times. Given g and r all is closed form (n runs, A = XᵀX + Λ⁻¹, V = A⁻¹, β̂ = VXᵀy):
    s² = (yᵀy − β̂ᵀAβ̂)/(n − 1),
    log p(y | g, r) = ½ log|V| − ½ log|Λ| − (n − 1)/2 · log s² + const,
and g and r are averaged over a grid, each weighed by that and by its prior: uniform in
r and log g, but that main effects far above LARGE times the scatter are the less
likely, as the tail of a half-Cauchy has it. Without that tail runs fewer than terms
would be taken for free of scatter. Least squares (g → ∞) take
noise for effects where packings scatter as much as the parameters do, and a posterior
on it holds the truth too rarely (benchmarks/loop_coverage.py). Source: Gelman et al.,
Bayesian Data Analysis (3rd ed.), 14.8 and 5; O'Hagan (1978), J. R. Stat. Soc. B 40, 1.
"""

from dataclasses import dataclass
from itertools import combinations_with_replacement, product

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike

from benchtwin.bench.language import tr
from benchtwin.calibrate.statistics import terms as polynomial
from benchtwin.calibrate.statistics.box import Box

# g: main effects of 0.05 to 5e4 times the scatter of one run: a slide's onset scatters
# by hundredths of a degree, and its friction moves it by degrees
STRENGTHS, LARGE = np.geomspace(3e-3, 3e9, 25), 10.0
STEEPNESS = (0.05, 0.2, 0.5, 1.0)  # r


@dataclass(frozen=True, kw_only=True, eq=False)
class Surrogate:
    """A fitted polynomial.

    coefficients: (p,) of coded terms; covariance: (p, p). noise_sd: scatter of one run
    on noise_df degrees of freedom. df: of a prediction's variance. residuals: (n,).
    """

    box: Box
    terms: tuple[polynomial.Term, ...]
    coefficients: np.ndarray
    covariance: np.ndarray
    noise_sd: float
    noise_df: int
    df: int
    residuals: np.ndarray

    def evaluate(self, natural: ArrayLike) -> tuple[np.ndarray, np.ndarray]:
        """Mean (n,) and its variance (n,) at natural points (n, k)."""
        x = polynomial.matrix(self.box.coded(natural), self.terms)
        return x @ self.coefficients, np.sum(x @ self.covariance * x, axis=1)


def fit_surrogate(
    runs: pd.DataFrame, column: str, box: Box, *, curved: int | None = None
) -> Surrogate:
    """Surrogate through the runs of a table, a row a run: columns `box.names` in
    natural units, and `column`.

    curved: how many of the first factors have squares, interactions and cubes, the
    others being linear; default all. Raises ValueError where fewer than 4 runs are
    there, or all give the same."""
    y, k = runs[column].to_numpy(float), len(box.names)
    if len(y) < 4 or np.ptp(y) == 0:
        raise ValueError(
            f"{column}: {len(y)} runs"
            + (
                tr(", all {:g}: the parameters do nothing to it", y[0])
                if len(y)
                else ""
            )
        )
    base, terms = _terms(k, k if curved is None else curved)
    order = np.array([sum(t) for t in terms])
    x = polynomial.matrix(box.coded(box.points(runs)), terms)
    middle = y.mean()  # taken out: sums of squares keep their digits
    y, free = y - middle, len(y) - 1
    fits, logs = [], []
    for g, r in product(STRENGTHS, STEEPNESS):
        held = np.where(order > 0, 1 / (g * r ** (2.0 * (order - 1))), 0.0)
        v = np.linalg.inv(x.T @ x + np.diag(held))
        beta = v @ (x.T @ y)
        s2 = float(np.sum((y - x @ beta) ** 2) + held @ beta**2) / free
        held_log = np.log(held[order > 0]).sum()
        log = np.linalg.slogdet(v)[1] + held_log - free * np.log(s2)
        logs.append((log - np.log1p(g / LARGE**2)) / 2)
        fits.append((v, beta, s2))
    weight = np.exp(np.array(logs) - max(logs))
    weight /= weight.sum()
    mean = sum(w * beta for w, (_, beta, _) in zip(weight, fits))
    covariance = sum(
        w * (s2 * v + np.outer(beta - mean, beta - mean))
        for w, (v, beta, s2) in zip(weight, fits)
    )
    return Surrogate(
        box=box,
        terms=terms,
        coefficients=mean + middle * (order == 0),
        covariance=covariance,
        noise_sd=float(np.sqrt(sum(w * s2 for w, (*_, s2) in zip(weight, fits)))),
        noise_df=free,
        df=max(len(y) - base, 1),
        residuals=y - x @ mean,
    )


def _terms(factors: int, curved: int) -> tuple[int, tuple[polynomial.Term, ...]]:
    """All terms, and how many of them are of second order or below."""
    rest = (0,) * (factors - curved)
    low = [(*t, *rest) for t in polynomial.full(curved)]
    low += [tuple(int(i == j) for i in range(factors)) for j in range(curved, factors)]
    cubes = [
        tuple(int(f) for f in np.bincount(three, minlength=factors))
        for three in combinations_with_replacement(range(curved), 3)
    ]
    return len(low), (*low, *cubes)
