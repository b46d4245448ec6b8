"""Shares with their intervals, and power curves."""

import math
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import pandas as pd
from scipy.optimize import minimize
from scipy.stats import binomtest

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


def reliability(cases: pd.DataFrame) -> pd.DataFrame:
    """Of verdicts said with probabilities of each bin of EDGES: n, how many are right,
    their mean probability, share with its 95 % bounds, and whether these hold the mean;
    verdicts without a probability are in none."""
    rows = []
    for low, high in pairwise(EDGES):
        said = cases[cases.p_verdict.between(low, high, inclusive="left")]
        if high == EDGES[-1]:
            said = cases[cases.p_verdict >= low]
        if n := len(said):
            right, mean_p = int(said.as_said.sum()), float(said.p_verdict.mean())
            ends = binomial_interval(right, n)
            holds = ends[0] <= mean_p <= ends[1]
            rows.append((low, high, n, right, mean_p, right / n, *ends, holds))
    names = ["from", "to", "n", "right", "mean_p", "share", "low95", "high95", "holds"]
    return pd.DataFrame(rows, columns=names)


def log_score(p_truth: pd.Series) -> tuple[float, float, int]:
    """(mean, its standard error, count) of ln of the probability given to the truth, at
    least FLOOR; NaN without any."""
    logs = np.log(p_truth.dropna().astype(float).clip(FLOOR))
    return float(logs.mean()), float(logs.sem()), len(logs)
