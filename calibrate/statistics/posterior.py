"""Posterior of the parameters over the box, given the bench's observables and the
surrogates' errors.

For one observable with bench mean ȳ and surrogate f̂(θ): ȳ − f̂(θ) ~ t with scale
    √(s_bench² + s_measuring² + var f̂(θ)) and Welch–Satterthwaite degrees of freedom,
which is the likelihood with the surrogate's coefficients integrated out (they enter
linearly). How far single piles scatter is in the bench mean's own sd."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import Protocol

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike
from scipy import special
from scipy.optimize import minimize

from benchtwin.bench.language import tr
from benchtwin.calibrate.statistics.bench import BenchMean
from benchtwin.calibrate.statistics.box import Box
from benchtwin.calibrate.statistics.prior import Prior

MOST_DF = 1e3  # with so many t is normal to every digit that matters
REACHED_Z = 3  # beyond it no parameters of the box give the bench's mean
TIED = 0.5  # correlation: a quarter of the one's variance goes with the other
SPREAD_OVER = 200  # cells of a grid: sds on fewer are off by more than some per cent


class Surrogate(Protocol):
    """What stands in for the simulation."""

    @property
    def box(self) -> Box: ...

    @property
    def df(self) -> float:
        """Degrees of freedom of the variance."""

    def evaluate(self, natural: ArrayLike) -> tuple[np.ndarray, np.ndarray]:
        """Mean (n,) and variance of the mean (n,) at natural points (n, k), columns in
        the order of `box.names`."""


@dataclass(frozen=True, eq=False)
class Observable:
    """A bench mean and the surrogate that predicts it; the surrogate may depend on some
    of the parameters only."""

    name: str
    surrogate: Surrogate
    bench: BenchMean


@dataclass(frozen=True, kw_only=True, eq=False)
class Posterior:
    """Draws from the posterior and how far they are to be believed.

    draws: (n,) rows of the factors, natural units; mode: {factor: value} of the one
    point with the highest joint density; r_hat, ess: per factor (NaN on a grid);
    converged: every r_hat < 1.01 and every ess large enough; tension: per observable at
    the mode: observable, bench, predicted, z, reached (|z| < 3: some parameters of the
    box give it); note: what to say of it."""

    prior: Prior
    draws: pd.DataFrame
    mode: dict[str, float]
    r_hat: np.ndarray
    ess: np.ndarray
    converged: bool
    tension: pd.DataFrame
    note: str


def log_posterior(
    natural: np.ndarray,
    observables: list[Observable],
    prior: Prior,
    correlation: np.ndarray | None = None,
) -> np.ndarray:
    """Log posterior density (n,), not normalised, at natural points (n, k).

    correlation: (m, m) between the observables' errors where they come from the same
    piles (both bench and simulated), itself estimated on those piles. Such are joined
    by a multivariate t, what is left when their covariance is integrated out (Gelman et
    al., Bayesian Data Analysis (3rd ed.), 3.6): with z (m) = (bench − predicted)/scale,
    ν the fewest degrees of freedom,

        log p = log Γ((ν + 1)/2) − log Γ((ν − m + 1)/2) − m/2 · log ν
                − Σ log scale − (ν + 1)/2 · log(1 + zᵀR⁻¹z/ν).

    Default: independent."""
    residuals = (residual(natural, o, prior) for o in observables)
    z, scale, df = (np.array(v) for v in zip(*residuals))
    out = prior.log_density(natural) - np.log(scale).sum(axis=0)
    m = len(observables)
    r = np.eye(m) if correlation is None else np.asarray(correlation, dtype=float)
    for block in _correlated_groups(r):
        size, own = len(block), r[np.ix_(block, block)]
        free = np.maximum(df[block].min(axis=0), size)
        square = np.einsum("in,ij,jn->n", z[block], np.linalg.inv(own), z[block])
        lost = special.gammaln((free - size + 1) / 2)
        out = out + special.gammaln((free + 1) / 2) - lost - size / 2 * np.log(free)
        out = out - (free + 1) / 2 * np.log1p(square / free)
    return out


def _correlated_groups(correlation: np.ndarray) -> list[np.ndarray]:
    """Indices of observables whose errors are correlated, directly or through others,
    one array a group."""
    steps = np.linalg.matrix_power(correlation != 0, len(correlation))
    first = steps.argmax(axis=1)  # of each group, whom all of it reach
    return [np.flatnonzero(first == k) for k in np.unique(first)]


def residual(
    natural: np.ndarray, o: Observable, prior: Prior
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """(bench − predicted)/scale, scale and degrees of freedom, each (n,)."""
    columns = [prior.box.names.index(n) for n in o.surrogate.box.names]
    mean, fit = o.surrogate.evaluate(natural[:, columns])
    variance = o.bench.sd**2 + fit
    spread = o.bench.scatter_sd**4 / o.bench.df + fit**2 / o.surrogate.df
    df = np.full_like(variance, MOST_DF)
    np.divide(variance**2, spread, out=df, where=spread > 0)
    scale = np.sqrt(variance)
    return (o.bench.value - mean) / scale, scale, np.minimum(df, MOST_DF)


def finish(
    draws: np.ndarray,
    log_density: np.ndarray,
    observables: list[Observable],
    prior: Prior,
    correlation: np.ndarray | None,
    *,
    r_hat: np.ndarray,
    ess: np.ndarray,
    converged: bool,
) -> Posterior:
    """A Posterior from draws (n, k) and their densities (n,): its mode, tension there,
    and the note."""
    start = draws[np.argmax(log_density)]
    best = _highest(start, observables, prior, correlation)
    rows = []
    for o in observables:
        z, scale, _ = (float(v[0]) for v in residual(best[None], o, prior))
        bench, reached = o.bench.value, abs(z) < REACHED_Z
        rows.append((o.name, bench, bench - z * scale, z, reached))
    columns = ["observable", "bench", "predicted", "z", "reached"]
    notes = [
        tr("no parameters of the box give the bench's {}", n)
        for n, *_, r in rows
        if not r
    ]
    if not converged:
        notes.insert(0, tr("not converged: draw longer before these numbers are used"))
    return Posterior(
        prior=prior,
        draws=pd.DataFrame(draws, columns=list(prior.box.names)),
        mode=dict(zip(prior.box.names, map(float, best))),
        r_hat=r_hat,
        ess=ess,
        converged=bool(converged),
        tension=pd.DataFrame(rows, columns=columns),
        note="; ".join(notes),
    )


def _highest(
    start: np.ndarray,
    observables: list[Observable],
    prior: Prior,
    correlation: np.ndarray | None,
) -> np.ndarray:
    """The point (k,) of highest density that is reached uphill from `start`."""
    box = prior.box

    def minus(coded: np.ndarray) -> float:
        point = np.clip(box.natural(coded), box.low, box.high)[None]
        return -float(log_posterior(point, observables, prior, correlation)[0])

    begin = box.coded(start)
    limits = [(-1.0, 1.0)] * len(begin)
    found = minimize(minus, begin, bounds=limits, method="L-BFGS-B")
    best = min(begin, found.x, key=minus)
    return np.clip(box.natural(best), box.low, box.high)


def on_grid(
    observables: list[Observable],
    prior: Prior,
    *,
    rng: np.random.Generator,
    cells: int = 31,
    draws: int = 4000,
    correlation: np.ndarray | None = None,
) -> Posterior:
    """Posterior on a grid of cells^k points, drawn from cell by cell: quick for up to
    three factors, and free of a chain.

    Converged where the weights are spread over at least SPREAD_OVER cells. Raises
    ValueError beyond a million cells."""
    k = len(prior.box.names)
    if cells**k > 1_000_000:
        raise ValueError(
            tr(
                "cells: {} to the power of {} factors is too many; sample instead",
                cells,
                k,
            )
        )
    axis = (np.arange(cells) + 0.5) / cells * 2 - 1
    coded = np.stack(np.meshgrid(*[axis] * k, indexing="ij"), axis=-1).reshape(-1, k)
    points = prior.box.natural(coded)
    log_density = log_posterior(points, observables, prior, correlation)
    weight = np.exp(log_density - log_density.max())
    weight /= weight.sum()
    chosen = rng.choice(len(weight), size=draws, p=weight)
    natural = prior.box.natural(coded[chosen] + rng.uniform(-1, 1, (draws, k)) / cells)
    nothing = np.full(k, np.nan)
    spread = 1 / np.sum(weight**2) >= SPREAD_OVER
    at = log_density[chosen]
    return finish(
        natural,
        at,
        observables,
        prior,
        correlation,
        r_hat=nothing,
        ess=nothing,
        converged=bool(spread),
    )


def summary(posterior: Posterior) -> pd.DataFrame:
    """One row a factor: factor, sd, prior_sd, sd_ratio (posterior over prior), r_hat,
    ess."""
    sd, prior_sd = posterior.draws.std().to_numpy(), posterior.prior.sd
    return pd.DataFrame(
        {
            "factor": list(posterior.draws.columns),
            "sd": sd,
            "prior_sd": prior_sd,
            "sd_ratio": sd / prior_sd,
            "r_hat": posterior.r_hat,
            "ess": posterior.ess,
        }
    )


def trade_offs(posterior: Posterior, of: Sequence[str]) -> pd.DataFrame:
    """Pairs of the factors `of` that the recordings tell together rather than apart,
    the closest first: columns one, other, correlation of the draws (|r| from TIED)."""
    r = posterior.draws[list(of)].corr().to_numpy()
    pairs = [(a, b, r[i, j]) for (i, a), (j, b) in combinations(enumerate(of), 2)]
    found = [pair for pair in pairs if abs(pair[2]) >= TIED]
    found.sort(key=lambda pair: -abs(pair[2]))
    return pd.DataFrame(found, columns=["one", "other", "correlation"])
