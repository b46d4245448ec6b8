"""Scores with their targets, over all rigs and rig by rig, from judged cases: shares
with their intervals, power curves, reliability."""

import math
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import pandas as pd
from scipy.optimize import minimize
from scipy.stats import binomtest

from benchtwin.prove.judge import Judged, cases_table
from benchtwin.prove.plan import (
    CLEAN,
    COMPOUND,
    CONDITION,
    CONFOUNDED,
    SEPARATED,
    SINGLE,
    UNLISTED_KIND,
)
from benchtwin.prove.rigs import RIGS

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


NAMED_SNR, PAIR_SNR, HELD_OUT_SNR = 7.0, 10.0, 10.0


@dataclass(frozen=True)
class Row:
    """One score of one rig ("all": over all). k of n where it is a share; met: None
    where nothing can be said."""

    score: str
    target: str
    rig: str
    value: float
    low: float
    high: float
    k: int | None
    n: int
    met: bool | None


@dataclass(frozen=True)
class Share:
    """A score that is a share of cases: of those that `of` picks how many are such as
    `counts` says, both about columns of the table of cases. least or most: what the
    share must be."""

    name: str
    of: str
    counts: str
    least: float | None = None
    most: float | None = None

    @property
    def target(self) -> str:
        """What it must be, in words."""
        if self.least is not None:
            return f"≥ {100 * self.least:g} %"
        return f"≤ {100 * self.most:g} %" if self.most else "0"


IDENTIFIABLE = f"kind in ['{SINGLE}', '{SEPARATED}'] and snr >= {NAMED_SNR}"
TWINS = f"kind == '{CONFOUNDED}' and snr >= {NAMED_SNR}"
UNLISTED = f"kind == '{UNLISTED_KIND}' and snr >= {NAMED_SNR}"
CLEAN_CASES = f"kind == '{CLEAN}'"
ALL_CASES = "snr >= 0"
HOLDS_TRUTH = "without the separator: class (or name) holds the truth"
SHARES = (
    Share(
        "false alarms on clean", CLEAN_CASES, "alarm or verdict == 'missing'", most=0.01
    ),
    Share("false definite names on clean", CLEAN_CASES, "verdict == 'name'", most=0.0),
    Share("right name, SNR ≥ 7, identifiable", IDENTIFIABLE, "right", least=0.90),
    Share(
        "wrong definite name, SNR ≥ 7, identifiable",
        IDENTIFIABLE,
        "wrong_name",
        most=0.01,
    ),
    Share(
        "named with the separating recording",
        f"kind == '{SEPARATED}' and snr >= {NAMED_SNR}",
        "right",
        least=0.90,
    ),
    Share(
        "condition that matters named, SNR ≥ 7",
        f"kind == '{CONDITION}' and snr >= {NAMED_SNR}",
        "right",
        least=0.90,
    ),
    Share(HOLDS_TRUTH, TWINS, "class_holds or right", least=0.95),
    Share("without the separator: wrong definite name", TWINS, "wrong_name", most=0.02),
    Share(
        "compound, exact set, SNR ≥ 10 each",
        f"kind == '{COMPOUND}' and snr >= {PAIR_SNR}",
        "right",
        least=0.90,
    ),
    Share(
        "outside the library: said to be unknown",
        UNLISTED,
        "verdict == 'unknown'",
        least=0.85,
    ),
    Share("outside the library: sector right", UNLISTED, "sector_right", least=0.95),
    Share(
        "said rightly whether it matters",
        "matters_right.notna()",
        "matters_right == True",
        least=0.90,
    ),
    Share("no p_verdict", ALL_CASES, "p_verdict.isna()", most=0.0),
    Share("no explanations", ALL_CASES, "p_truth.isna()", most=0.0),
    Share("no diagnosis", ALL_CASES, "verdict == 'missing'", most=0.0),
)


def table(judged: list[Judged], rng: np.random.Generator) -> list[Row]:
    """Every score, first over all rigs, then rig by rig; rows without cases are left
    out."""
    rows = []
    for rig in ("all", *RIGS):
        some = [j for j in judged if rig in ("all", j.key.rig)]
        if not some:
            continue
        cases = cases_table(some)
        for share in SHARES:
            rows += _share_row(share, rig, cases)
        rows += _reliability_rows(rig, cases) + _power_rows(rig, some, rng)
        rows += _coverage_row(rig, some)
        rows += _held_out_row(rig, cases) + _time_row(rig, cases)
    return rows


def _share_row(share: Share, rig: str, cases: pd.DataFrame) -> list[Row]:
    chosen = cases.query(share.of).eval(share.counts)
    k, n = int(chosen.sum()), len(chosen)
    if not n:
        return []
    least, most = share.least or 0.0, 1.0 if share.most is None else share.most
    ends, met = binomial_interval(k, n), least <= k / n <= most
    return [Row(share.name, share.target, rig, k / n, *ends, k, n, met)]


def _reliability_rows(rig: str, cases: pd.DataFrame) -> list[Row]:
    """Of verdicts said with about the same probability the share that is right; and
    what the explanations gave to the truth."""
    rows = []
    for one in reliability(cases).to_dict("records"):
        name = f"right, of verdicts said with {one['from']:g}–{one['to']:g}"
        target = f"{100 * one['mean_p']:.1f} % within"
        ends, counts = (one["low95"], one["high95"]), (one["right"], one["n"])
        rows.append(Row(name, target, rig, one["share"], *ends, *counts, one["holds"]))
    clean = cases.kind == CLEAN
    for name, some in (("clean", clean), ("something missing", ~clean)):
        mean, error, n = log_score(cases.p_truth[some])
        ends = (mean - 1.96 * error, mean + 1.96 * error)
        if n:
            rows.append(Row(f"log score, {name}", "", rig, mean, *ends, None, n, None))
    return rows


def power(judged: list[Judged], rng: np.random.Generator) -> Power:
    """Power curve over all cases with one concealed effect."""
    some = [j for j in judged if len(j.key.effects) == 1]
    return power_curve(
        np.array([j.key.snr for j in some]),
        np.array([j.alarm for j in some], dtype=bool),
        rng,
    )


def _power_rows(rig: str, judged: list[Judged], rng) -> list[Row]:
    curve = power(judged, rng)
    if curve.n < 10:
        return []
    points = (
        (curve.snr50, curve.interval50, 4.0, "50 %"),
        (curve.snr90, curve.interval90, 5.5, "90 %"),
    )
    rows = []
    for value, interval, most, share in points:
        name, met = f"detection: SNR at {share} power", value <= most
        known = met if math.isfinite(value) else None
        rows.append(
            Row(name, f"≤ {most:g}", rig, value, *interval, None, curve.n, known)
        )
    return rows


def _coverage_row(rig: str, judged: list[Judged]) -> list[Row]:
    covers = [c for j in judged for c in j.covers]
    if not covers:
        return []
    k, n = sum(covers), len(covers)
    name, target, met = "95 % intervals cover", "92–97.5 %", 0.92 <= k / n <= 0.975
    return [Row(name, target, rig, k / n, *binomial_interval(k, n), k, n, met)]


def _held_out_row(rig: str, cases: pd.DataFrame) -> list[Row]:
    """Mean of the removed fractions; a case without one counts as zero."""
    kinds = cases.kind.isin([SINGLE, SEPARATED, COMPOUND])
    some = cases.removed_fraction[kinds & (cases.snr >= HELD_OUT_SNR)]
    some = some.astype(float).fillna(0.0)
    if some.empty:
        return []
    value, se = float(some.mean()), float(some.sem())
    ends = (value - 1.96 * se, value + 1.96 * se)
    name = "held-out removed fraction, SNR ≥ 10"
    return [Row(name, "≥ .9", rig, value, *ends, None, len(some), value >= 0.9)]


def _time_row(rig: str, cases: pd.DataFrame) -> list[Row]:
    """Wall time of a folder, pictures left out; low and high are the 5th and 95th
    percentiles."""
    seconds = cases.seconds[~cases.rendered].dropna()
    if seconds.empty:
        return []
    low, middle, high = seconds.quantile([0.05, 0.5, 0.95]).tolist()
    name, target = "time per folder of tracks [s]", "≤ 6; 95 % ≤ 15"
    met = bool(middle <= 6 and high <= 15)
    return [Row(name, target, rig, middle, low, high, None, len(seconds), met)]


def confusion(judged: list[Judged]) -> pd.DataFrame:
    """Concealed (rows) beside said (columns): counts. What is said is the one definite
    name, else the verdict."""
    last = ["class with the truth", "class without it", "unknown", "none", "missing"]

    def said(j: Judged) -> str:
        if j.verdict == "name":
            return " + ".join(sorted(j.names))
        return last[not j.class_holds] if j.verdict == "class" else j.verdict

    concealed = [
        f"{j.key.rig}: {' + '.join(e.name for e in j.key.effects) or 'clean'}"
        for j in judged
    ]
    counts = pd.crosstab(np.array(concealed), np.array([said(j) for j in judged]))
    names = counts.columns.difference(last)
    return counts[[*names, *(verdict for verdict in last if verdict in counts)]]
