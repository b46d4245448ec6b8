"""Response surface with shrinkage, for the posterior: effects that the runs do not show
are held near zero; cubic terms are added.

Coded coefficients but the intercept's are normal about 0 beforehand, with sd
σ√g·r^(order − 1): main effects √g, squares and interactions r times that, cubes r²
times. Given g and r all is closed form (n runs, A = XᵀX + Λ⁻¹, V = A⁻¹, β̂ = VXᵀy):
    s² = (yᵀy − β̂ᵀAβ̂)/(n − 1),
    log p(y | g, r) = ½ log|V| − ½ log|Λ| − (n − 1)/2 · log s² + const,
and g and r are averaged over a grid, each weighed by that. Least squares (g → ∞) take
noise for effects where packings scatter as much as the parameters do, and a posterior
on it holds the truth too rarely (benchmarks/loop_coverage.py). Source: Gelman et al.,
Bayesian Data Analysis (3rd ed.), 14.8 and 5; O'Hagan (1978), J. R. Stat. Soc. B 40, 1.
"""

from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.typing import ArrayLike

from benchtwin.calibrate.statistics import terms as polynomial
from benchtwin.calibrate.statistics.box import Box
from benchtwin.calibrate.statistics.surface import Surface

STRENGTHS = np.geomspace(3e-3, 3e2, 11)  # g: main effects of 0.05 to 17 packing sds
STEEPNESS = (0.2, 0.5, 1.0)  # r


@dataclass(frozen=True, kw_only=True, eq=False)
class ShrinkageSurface:
    """A fitted surface.

    coefficients: (p,) of coded terms; covariance: (p, p). noise_sd: scatter of one run,
    on noise_df degrees of freedom. df: of a prediction's variance. residuals: (n,),
    decorrelated where packings are shared."""

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


def shrink(surface: Surface) -> ShrinkageSurface:
    """Fit the surface's runs anew, with cubic terms in the factors that have squares;
    packings as the surface has them."""
    terms = (*surface.terms, *cubes(surface.terms))
    order = np.array([sum(t) for t in terms])
    x = surface.independent(polynomial.matrix(surface.points, terms))
    y = surface.independent(surface.response)
    # of a pile's scatter, not only of what packings do not share
    whole, free = 1 + surface.shared, len(y) - 1
    fits, logs = [], []
    for g, r in product(STRENGTHS * whole, STEEPNESS):
        held = np.where(order > 0, 1 / (g * r ** (2.0 * (order - 1))), 0.0)
        precision = x.T @ x + np.diag(held)
        v = np.linalg.inv(precision)
        beta = v @ (x.T @ y)
        s2 = float(y @ y - beta @ precision @ beta) / free
        held_log = np.log(held[order > 0]).sum()
        logs.append((np.linalg.slogdet(v)[1] + held_log - free * np.log(s2)) / 2)
        fits.append((v, beta, s2))
    weight = np.exp(np.array(logs) - max(logs))
    weight /= weight.sum()
    mean = sum(w * beta for w, (_, beta, _) in zip(weight, fits))
    covariance = sum(
        w * (s2 * v + np.outer(beta - mean, beta - mean))
        for w, (v, beta, s2) in zip(weight, fits)
    )
    noise = float(sum(w * s2 for w, (*_, s2) in zip(weight, fits))) * whole
    return ShrinkageSurface(
        box=surface.box,
        terms=terms,
        coefficients=mean,
        covariance=covariance,
        noise_sd=np.sqrt(noise),
        noise_df=free,
        df=surface.df,
        residuals=y - x @ mean,
    )


def cubes(terms: tuple[polynomial.Term, ...]) -> list[polynomial.Term]:
    """Third-order terms in the factors whose squares are among the terms.

    >>> cubes(((0, 0), (1, 0), (0, 1), (2, 0)))
    [(3, 0)]
    """
    bent = [t.index(2) for t in terms if 2 in t]
    k = len(terms[0])
    return [
        tuple(int(f) for f in np.bincount([i, j, m], minlength=k))
        for i in bent
        for j in bent
        for m in bent
        if i <= j <= m
    ]
