"""Scores with their targets, over all rigs and rig by rig, from judged cases."""

import math
from collections.abc import Callable
from dataclasses import dataclass
from operator import attrgetter

import numpy as np
import pandas as pd

from benchtwin.prove.intervals import (
    Power,
    binomial_interval,
    log_score,
    power_curve,
    reliability,
)
from benchtwin.prove.judge import Judged
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
    """A score that is a share of cases. least or most: what the share must be."""

    name: str
    of: Callable[[Judged], bool]
    counts: Callable[[Judged], bool]
    least: float | None = None
    most: float | None = None

    @property
    def target(self) -> str:
        """What it must be, in words."""
        if self.least is not None:
            return f"≥ {100 * self.least:g} %"
        return f"≤ {100 * self.most:g} %" if self.most else "0"


def _strong(kind: str, snr: float = NAMED_SNR) -> Callable[[Judged], bool]:
    return lambda j: j.key.kind == kind and j.key.snr >= snr


def _identifiable(j: Judged) -> bool:
    return j.key.kind in (SINGLE, SEPARATED) and j.key.snr >= NAMED_SNR


def _clean(j: Judged) -> bool:
    return j.key.kind == CLEAN


def _any(j: Judged) -> bool:
    return True


_right, _wrong_name = attrgetter("right"), attrgetter("wrong_name")
_unlisted = _strong(UNLISTED_KIND)
_confounded = _strong(CONFOUNDED)
HOLDS_TRUTH = "without the separator: class (or name) holds the truth"
SHARES = (
    Share("false alarms on clean", _clean, lambda j: j.alarm or j.missing, most=0.01),
    Share(
        "false definite names on clean", _clean, lambda j: j.verdict == "name", most=0.0
    ),
    Share("right name, SNR ≥ 7, identifiable", _identifiable, _right, least=0.90),
    Share(
        "wrong definite name, SNR ≥ 7, identifiable",
        _identifiable,
        _wrong_name,
        most=0.01,
    ),
    Share(
        "named with the separating recording", _strong(SEPARATED), _right, least=0.90
    ),
    Share(
        "condition that matters named, SNR ≥ 7", _strong(CONDITION), _right, least=0.90
    ),
    Share(HOLDS_TRUTH, _confounded, lambda j: j.class_holds or j.right, least=0.95),
    Share(
        "without the separator: wrong definite name",
        _confounded,
        _wrong_name,
        most=0.02,
    ),
    Share(
        "compound, exact set, SNR ≥ 10 each",
        _strong(COMPOUND, PAIR_SNR),
        _right,
        least=0.90,
    ),
    Share(
        "outside the library: said to be unknown",
        _unlisted,
        lambda j: j.verdict == "unknown",
        least=0.85,
    ),
    Share(
        "outside the library: sector right",
        _unlisted,
        attrgetter("sector_right"),
        least=0.95,
    ),
    Share(
        "said rightly whether it matters",
        lambda j: j.matters is not None,
        lambda j: bool(j.matters),
        least=0.90,
    ),
    Share("no p_verdict", _any, lambda j: j.p is None, most=0.0),
    Share("no explanations", _any, lambda j: j.p_truth is None, most=0.0),
    Share("no diagnosis", _any, lambda j: j.missing, most=0.0),
)


def table(judged: list[Judged], rng: np.random.Generator) -> list[Row]:
    """Every score, first over all rigs, then rig by rig; rows without cases are left
    out."""
    rows = []
    for rig in ("all", *RIGS):
        some = [j for j in judged if rig in ("all", j.key.rig)]
        if not some:
            continue
        rows += [
            _share_row(share, rig, some)
            for share in SHARES
            if any(share.of(j) for j in some)
        ]
        rows += _reliability_rows(rig, some) + _power_rows(rig, some, rng)
        rows += _coverage_row(rig, some)
        rows += _held_out_row(rig, some) + _time_row(rig, some)
    return rows


def _share_row(share: Share, rig: str, judged: list[Judged]) -> Row:
    chosen = [share.counts(j) for j in judged if share.of(j)]
    k, n = sum(chosen), len(chosen)
    value = k / n
    met = None
    if share.least is not None:
        met = value >= share.least
    elif share.most is not None:
        met = value <= share.most
    return Row(
        share.name, share.target, rig, value, *binomial_interval(k, n), k, n, met
    )


def _reliability_rows(rig: str, judged: list[Judged]) -> list[Row]:
    """Of verdicts said with about the same probability the share that is right; and
    what the explanations gave to the truth."""
    rows = []
    for one in reliability(judged):
        name = f"right, of verdicts said with {one.low:g}–{one.high:g}"
        target = f"{100 * one.mean_p:.1f} % within"
        rows.append(
            Row(name, target, rig, one.share, *one.bounds, one.k, one.n, one.holds)
        )
    for name, clean in (
        ("log score, clean", True),
        ("log score, something missing", False),
    ):
        mean, error, n = log_score([j for j in judged if _clean(j) == clean])
        if n:
            ends = (mean - 1.96 * error, mean + 1.96 * error)
            rows.append(Row(name, "", rig, mean, *ends, None, n, None))
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


def _held_out_row(rig: str, judged: list[Judged]) -> list[Row]:
    """Mean of the removed fractions; a case without one counts as zero."""
    some = [
        j.removed or 0.0
        for j in judged
        if j.key.kind in (SINGLE, SEPARATED, COMPOUND) and j.key.snr >= HELD_OUT_SNR
    ]
    if not some:
        return []
    value, n = float(np.mean(some)), len(some)
    se = float(np.std(some, ddof=1) / math.sqrt(n)) if n > 1 else math.nan
    ends = (value - 1.96 * se, value + 1.96 * se)
    name = "held-out removed fraction, SNR ≥ 10"
    return [Row(name, "≥ .9", rig, value, *ends, None, n, value >= 0.9)]


def _time_row(rig: str, judged: list[Judged]) -> list[Row]:
    """Wall time of a folder, pictures left out; low and high are the 5th and 95th
    percentiles."""
    seconds = [
        j.seconds for j in judged if not j.key.rendered and math.isfinite(j.seconds)
    ]
    if not seconds:
        return []
    low, middle, high = np.quantile(seconds, [0.05, 0.5, 0.95]).tolist()
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
