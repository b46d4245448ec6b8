"""The mean of repeated bench readings with its standard deviation, and recordings that
contradict each other."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike
from scipy import stats

from benchtwin.bench.language import tr


@dataclass(frozen=True)
class BenchMean:
    """value: mean of n readings; scatter_sd: its standard deviation from their scatter,
    on df degrees of freedom; shared_sd: error that all readings share (scale, plumb),
    taken as known; same unit throughout."""

    value: float
    scatter_sd: float
    df: float
    shared_sd: float
    n: int

    @property
    def sd(self) -> float:
        return float(np.hypot(self.scatter_sd, self.shared_sd))


def bench_mean(
    readings: ArrayLike,
    *,
    name: str,
    reading_sd: ArrayLike = 0.0,
    shared_sd: float = 0.0,
    trimmed: int = 0,
) -> BenchMean:
    """Mean of repeated readings.

    name: what is read, for error messages; reading_sd: measuring error of each reading,
    one or n (the scatter contains it; it counts where the scatter shows less than it);
    shared_sd: error common to all readings, which repeats do not lessen. trimmed: how
    many highest and how many lowest readings were left out before (the paper: 1 of each
    of 12). What is left scatters too little; the standard error is then the trimmed
    mean's, s_w/((1 − 2γ)√N) with winsorised s_w on n − 1 degrees of freedom (Tukey &
    McLaughlin 1963). Raises ValueError: one reading only, readings not finite, all
    equal with no reading_sd, a negative sd."""
    x = np.asarray(readings, dtype=float)
    own = np.broadcast_to(np.asarray(reading_sd, dtype=float), x.shape)
    if x.ndim != 1 or x.size < 2:
        raise ValueError(
            tr("{}: {} reading has no scatter; give at least two", name, x.size)
        )
    if not np.isfinite(x).all():
        first = int(np.argmin(np.isfinite(x))) + 1
        raise ValueError(tr("{}: reading {} is not finite", name, first))
    if (own < 0).any() or shared_sd < 0 or trimmed < 0:
        raise ValueError(
            tr("{}: reading_sd, shared_sd and trimmed must not be negative", name)
        )
    measured = float(np.sqrt(np.mean(own**2)))
    if np.ptp(x) == 0 and measured == 0:
        raise ValueError(
            tr(
                "{}: all {} readings equal {:g}; resolution hides their scatter: state"
                " reading_sd",
                name,
                x.size,
                x[0],
            )
        )
    full = x.size + 2 * trimmed
    winsorised = np.concatenate([x, np.repeat([x.min(), x.max()], trimmed)])
    scatter = winsorised.std(ddof=1) / (x.size / full * np.sqrt(full))
    sd = float(max(scatter, measured / np.sqrt(x.size)))
    return BenchMean(float(x.mean()), sd, x.size - 1.0, float(shared_sd), x.size)


def one_reading(
    value: float, *, name: str, scatter_sd: float, df: float, shared_sd: float = 0.0
) -> BenchMean:
    """A single reading whose scatter is known from elsewhere, say a photo of one pile
    and the simulated piles' packing noise on df.

    Raises ValueError for an sd that is not positive or df below 1.
    """
    if not (np.isfinite(value) and scatter_sd > 0 and df >= 1 and shared_sd >= 0):
        raise ValueError(
            tr(
                "{}: one reading needs a scatter_sd above 0 from elsewhere, on df of at"
                " least 1",
                name,
            )
        )
    return BenchMean(float(value), float(scatter_sd), float(df), float(shared_sd), 1)


def pooled_mean(
    readings: ArrayLike,
    *,
    name: str,
    scatter_sd: float,
    df: float,
    pooled: bool = True,
    alpha: float = 0.05,
    reading_sd: ArrayLike = 0.0,
    shared_sd: float = 0.0,
) -> BenchMean:
    """The mean of a few readings whose scatter is known from elsewhere too, scatter_sd
    on df: both scatters are pooled, unless they contradict each other (two-sided F test
    at alpha) or `pooled` is False; then the readings' own counts.

    A single reading takes the other scatter alone. Raises ValueError as `bench_mean`
    and `one_reading`."""
    x = np.asarray(readings, dtype=float)
    if x.size == 1:
        own = float(np.max(np.asarray(reading_sd, dtype=float)))
        sd, df = float(np.hypot(scatter_sd, own)), max(df, 1.0)
        return one_reading(x[0], name=name, scatter_sd=sd, df=df, shared_sd=shared_sd)
    if x.size and np.isfinite(x).all() and pooled:
        variance = float(x.var(ddof=1))
        p = stats.f.sf(variance / scatter_sd**2, x.size - 1, df)
        if alpha / 2 <= p <= 1 - alpha / 2:
            free = x.size - 1 + df
            both = ((x.size - 1) * variance + df * scatter_sd**2) / free
            sd = float(np.sqrt(both / x.size))
            return BenchMean(float(x.mean()), sd, float(free), float(shared_sd), x.size)
    return bench_mean(x, name=name, reading_sd=reading_sd, shared_sd=shared_sd)


@dataclass(frozen=True, kw_only=True)
class Verification:
    """Simulated repeats at the calibrated parameters beside the bench (the paper's
    relative errors).

    simulated: their mean, sd: its standard deviation; relative_error: |simulated −
    bench|/bench; t, p: of the difference, Welch's test with the measuring error in it;
    agrees: p ≥ alpha."""

    simulated: float
    sd: float
    bench: float
    relative_error: float
    t: float
    p: float
    agrees: bool


def verify(
    repeats: ArrayLike, bench: BenchMean, *, name: str, alpha: float = 0.01
) -> Verification:
    """Compare verification runs with the bench's mean. Raises ValueError with fewer
    than two repeats or a bench value of zero."""
    y = np.asarray(repeats, dtype=float)
    if y.ndim != 1 or y.size < 2 or not np.isfinite(y).all():
        raise ValueError(
            tr(
                "{}: verification needs at least two finite repeats; here are {}",
                name,
                y.size,
            )
        )
    if bench.value == 0:
        raise ValueError(
            tr("{}: a relative error needs a bench value other than zero", name)
        )
    own = y.var(ddof=1) / y.size
    variance = own + bench.sd**2
    df = variance**2 / (own**2 / (y.size - 1) + bench.scatter_sd**4 / bench.df)
    difference = float(y.mean() - bench.value)
    t = difference / np.sqrt(variance)
    p = float(2 * stats.t.sf(abs(t), df))
    error = abs(difference / bench.value)
    return Verification(
        simulated=float(y.mean()),
        sd=float(np.sqrt(own)),
        bench=bench.value,
        relative_error=error,
        t=float(t),
        p=p,
        agrees=p >= alpha,
    )


def agreement(
    names: Sequence[str], values: ArrayLike, sds: ArrayLike, alpha: float = 0.01
) -> pd.DataFrame:
    """Which recordings of one quantity, each a value with its sd, lie farther from the
    rest than chance allows.

    Columns name, value, sd, others (weighted mean of those others that do not
    contradict), z (distance from it in standard deviations), contradicts. The farthest
    is set aside first, at level alpha/n, and the rest compared anew, so that one bad
    recording does not accuse the others; of two, both are flagged. Raises ValueError
    with fewer than two recordings or an sd that is not positive."""
    y, s = np.asarray(values, dtype=float), np.asarray(sds, dtype=float)
    if y.size < 2:
        raise ValueError(tr("agreement needs at least two recordings"))
    if not (s > 0).all():
        raise ValueError(tr("{}: sd must be positive", list(names)[int(np.argmin(s))]))
    w = 1 / s**2
    limit = stats.norm.ppf(1 - alpha / (2 * y.size))
    aside = np.zeros(y.size, dtype=bool)
    while True:
        kept = np.where(aside, 0.0, w)
        weight = kept.sum() - kept
        others = (np.sum(w[~aside] * y[~aside]) - np.where(aside, 0.0, w * y)) / weight
        z = (y - others) / np.sqrt(s**2 + 1 / weight)
        farthest = int(np.argmax(np.where(aside, 0.0, abs(z))))
        if abs(z[farthest]) <= limit:
            break
        if (~aside).sum() == 2:
            aside[:] = True
            break
        aside[farthest] = True
    columns = {"name": list(names), "value": y, "sd": s, "others": others, "z": z}
    return pd.DataFrame(columns | {"contradicts": aside})
