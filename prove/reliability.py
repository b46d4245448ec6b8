"""Whether stated probabilities hold: shares of right verdicts at each level of probability, and the log score."""

import math
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from prove.intervals import binomial_interval
from prove.judge import Judged

EDGES = (0.0, 0.5, 0.75, 0.9, 0.97, 1.0)
FLOOR = 1e-6  # of the log score: who rules the truth out loses 13.8, not everything


@dataclass(frozen=True)
class Bin:
    """Verdicts said with probabilities from low up to high: k of n are right, mean_p is their mean probability."""

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
        found = {"share": self.share, "low95": self.bounds[0], "high95": self.bounds[1], "holds": self.holds}
        return {"from": self.low, "to": self.high, "n": self.n, "right": self.k, "mean_p": self.mean_p} | found


def reliability(judged: list[Judged]) -> list[Bin]:
    """The bins of EDGES that hold a verdict; verdicts without a probability are in none."""
    out = []
    for low, high in pairwise(EDGES):
        some = [j for j in judged if j.p is not None and (low <= j.p < high or j.p == high == EDGES[-1])]
        if some:
            out.append(Bin(low, high, len(some), sum(j.as_said for j in some), float(np.mean([j.p for j in some]))))
    return out


def log_score(judged: list[Judged]) -> tuple[float, float, int]:
    """(mean, its standard error, count) of ln of the probability given to the truth, at least FLOOR; NaN without any."""
    some = [math.log(max(j.p_truth, FLOOR)) for j in judged if j.p_truth is not None]
    if not some:
        return math.nan, math.nan, 0
    error = float(np.std(some, ddof=1)) / math.sqrt(len(some)) if len(some) > 1 else math.nan
    return float(np.mean(some)), error, len(some)
