"""Shares with their intervals, and power curves."""

import math
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from scipy.optimize import minimize
from scipy.stats import binomtest

from benchtwin.prove.judge import Judged

FALSE_ALARM = 0.001  # p below which the diagnosis raises an alarm
GRID = np.exp(np.linspace(np.log(0.5), np.log(60), 120))
EDGES = (0.0, 0.5, 0.75, 0.9, 0.97, 1.0)
FLOOR = 1e-6  # of the log score: who rules the truth out loses 13.8, not everything


def binomial_interval(k: int, n: int, level: float = 0.95) -> tuple[float, float]:
    """Clopper–Pearson interval of a share.

    >>> [round(v, 4) for v in binomial_interval(0, 300)]
    [0.0, 0.0122]
    """
    if n == 0:
        return 0.0, 1.0
    found = binomtest(k, n).proportion_ci(level, method="exact")
    return float(found.low), float(found.high)


@dataclass(frozen=True)
class Power:
    """Share detected as a function of SNR: α + (1 − α) / (1 + (s₅₀/SNR)^k). NaN where
    the cases do not say; intervals by bootstrap."""

    n: int
    middle: float
    steepness: float
    snr50: float
    snr90: float
    interval50: tuple[float, float]
    interval90: tuple[float, float]

    def at(self, snr: np.ndarray) -> np.ndarray:
        return _share(np.log(snr), math.log(self.middle), self.steepness)


def power_curve(
    snr: np.ndarray, found: np.ndarray, rng: np.random.Generator, repeats: int = 200
) -> Power:
    """Fit detections (n,) bool at SNRs (n,). Needs ten cases and both outcomes."""
    nothing = (math.nan, math.nan)
    if len(snr) < 10 or found.all() or not found.any():
        return Power(len(snr), math.nan, math.nan, math.nan, math.nan, nothing, nothing)
    fit = _fit(snr, found)
    drawn = []
    for _ in range(repeats):
        rows = rng.integers(len(snr), size=len(snr))
        if found[rows].any() and not found[rows].all():
            drawn.append(_points(*_fit(snr[rows], found[rows])))
    if len(drawn) > 20:
        bands = np.quantile(drawn, [0.025, 0.975], axis=0)
    else:
        bands = np.full((2, 2), math.nan)
    low = tuple(bands[:, 0].tolist())
    high = tuple(bands[:, 1].tolist())
    return Power(len(snr), math.exp(fit[0]), fit[1], *_points(*fit), low, high)


def _share(log_snr, middle: float, steepness: float):
    return FALSE_ALARM + (1 - FALSE_ALARM) / (
        1 + np.exp(-steepness * (log_snr - middle))
    )


def _fit(snr: np.ndarray, found: np.ndarray) -> tuple[float, float]:
    x = np.log(np.maximum(snr, 1e-3))

    def cost(p: np.ndarray) -> float:
        share = np.clip(_share(x, p[0], math.exp(p[1])), 1e-9, 1 - 1e-9)
        # a weak pull towards the theory's steepness (about 6) keeps separated data
        # finite
        return (
            -float(np.where(found, np.log(share), np.log(1 - share)).sum())
            + 0.5 * ((p[1] - math.log(6)) / 1.0) ** 2
        )

    options = {"xatol": 1e-3, "fatol": 1e-4}
    best = minimize(
        cost, [math.log(4), math.log(5)], method="Nelder-Mead", options=options
    )
    return float(best.x[0]), float(math.exp(best.x[1]))


def _points(middle: float, steepness: float) -> tuple[float, float]:
    """SNRs at which half and nine tenths are detected."""
    half, most = (
        math.exp(min(middle + math.log(odds / (1 - odds)) / steepness, 50.0))
        for odds in ((p - FALSE_ALARM) / (1 - FALSE_ALARM) for p in (0.5, 0.9))
    )
    return half, most


@dataclass(frozen=True)
class Bin:
    """Verdicts said with probabilities from low up to high: k of n are right, mean_p is
    their mean probability."""

    low: float
    high: float
    n: int
    k: int
    mean_p: float

    @property
    def share(self) -> float:
        return self.k / self.n

    @property
    def bounds(self) -> tuple[float, float]:
        """95 %, Clopper–Pearson, of the share."""
        return binomial_interval(self.k, self.n)

    @property
    def holds(self) -> bool:
        return self.bounds[0] <= self.mean_p <= self.bounds[1]

    def to_dict(self) -> dict:
        found = {
            "share": self.share,
            "low95": self.bounds[0],
            "high95": self.bounds[1],
            "holds": self.holds,
        }
        return {
            "from": self.low,
            "to": self.high,
            "n": self.n,
            "right": self.k,
            "mean_p": self.mean_p,
        } | found


def reliability(judged: list[Judged]) -> list[Bin]:
    """The bins of EDGES that hold a verdict; verdicts without a probability are in
    none."""
    out = []
    for low, high in pairwise(EDGES):
        some = [
            j
            for j in judged
            if j.p is not None and (low <= j.p < high or j.p == high == EDGES[-1])
        ]
        if some:
            right = sum(j.as_said for j in some)
            mean_p = float(np.mean([j.p for j in some]))
            out.append(Bin(low, high, len(some), right, mean_p))
    return out


def log_score(judged: list[Judged]) -> tuple[float, float, int]:
    """(mean, its standard error, count) of ln of the probability given to the truth, at
    least FLOOR; NaN without any."""
    some = [math.log(max(j.p_truth, FLOOR)) for j in judged if j.p_truth is not None]
    if not some:
        return math.nan, math.nan, 0
    if len(some) > 1:
        error = float(np.std(some, ddof=1)) / math.sqrt(len(some))
    else:
        error = math.nan
    return float(np.mean(some)), error, len(some)
