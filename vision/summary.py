"""Means over repeats with 95 % intervals, scatter and outliers.

One line for each bench, rig, quantity, and level of a condition that has repeats at its
levels. Only recordings that state the same of rig and seed are repeats of each other;
ratios and angles, which are the material's, also at numbers without repeats."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass, fields, replace

import numpy as np
import pandas as pd

from benchtwin.bench import distributions as stats
from benchtwin.bench.numbers import EXACT_SHARE
from benchtwin.vision.measurement import (
    DOUBTFUL,
    FAILED,
    Observation,
    Quantity,
    failed,
    vague,
)

OUTLIER_P = 0.01  # chance that any recording of a group without outliers is named
MATERIAL = ("1", "deg")  # units of what does not grow with what is stated
SAME = 0.05  # relative, within which stated numbers are the same
LEAST_FOR_OUTLIERS = 4  # with three values, any two make an outlier of the third


@dataclass(frozen=True)
class Line:
    """The repeats of one quantity.

    `mean` is unweighted; `low`, `high` are the 95 % interval of the mean: Student's t
    on the scatter between the repeats, the errors that all recordings of a session
    share (`common`) added in quadrature; repeats that are all one number count as one.
    `scatter` is the sd between repeats (NaN for
    one), `measuring` the rms sd of the single measurements. `doubtful` counts repeats
    of doubtful quality, `outliers` names repeats far from the others; both are in the
    mean. `not_measured` counts those that failed."""

    bench: str
    rig: str
    quantity: str
    conditions: str
    n: int
    mean: float
    low: float
    high: float
    unit: str
    scatter: float
    measuring: float
    common: float
    doubtful: int
    not_measured: int
    outliers: tuple[str, ...]

    @property
    def all_equal(self) -> bool:
        """Whether the repeats are one number: they then tell no more than one of
        them."""
        return self.n > 1 and self.scatter <= EXACT_SHARE * abs(self.mean)


def summarise(observations: Iterable[Observation]) -> list[Line]:
    """One Line for each group of repeats, in the order in which they were measured;
    groups with nothing measured left out."""
    groups: dict[tuple, list[tuple[Observation, Quantity]]] = {}
    observations = [one for each in observations for one in _repeats_of(each)]
    places: dict[tuple[str, str], list[Observation]] = {}
    for observation in observations:
        place = observation.bench, observation.rig
        places.setdefault(place, []).append(observation)
    for place, inside in places.items():
        counts = sum(map(_count, inside))
        held, stated = (
            [getattr(o, n) for o in inside] for n in ("conditions", "stated")
        )
        split = _with_repeats(held, counts, _names(held))
        different = [n for n in _names(stated) if not _same(stated, n)]
        repeated = _with_repeats(stated, counts, different)
        for observation in inside:
            alike = _levels(observation.conditions, split)
            for q in observation.quantities:
                names = repeated if q.unit in MATERIAL else different
                levels = ", ".join([*_levels(observation.stated, names), *alike])
                groups.setdefault((*place, q.name, q.unit, levels), []).append(
                    (observation, q)
                )
    lines = [_line(key, repeats) for key, repeats in groups.items()]
    return [line for line in lines if line.n]


def mean_over_repeats(
    repeats: Sequence[tuple[Quantity, ...]],
) -> tuple[Quantity, ...]:
    """The mean of each quantity over the repeats that one recording holds, with the
    interval that `summarise` gives it; doubtful where a repeat is."""
    whole = Observation("", "", (), repeats=tuple(repeats))
    lines = {line.quantity: line for line in summarise([whole])}
    means = []
    for name in dict.fromkeys(q.name for one in repeats for q in one):
        each = [q for one in repeats for q in one if q.name == name]
        if (line := lines.get(name)) is None:
            means.append(failed(name, each[0].unit, each[0].reason))
            continue
        sd = (line.high - line.low) / 2 / 1.96
        mean = Quantity(name, line.mean, sd, line.unit, sd_common=line.common)
        reasons = dict.fromkeys(q.reason for q in each if q.quality == DOUBTFUL)
        share = "" if line.doubtful == line.n else f"{line.doubtful} of {line.n}: "
        doubt = f"{share}{'; '.join(reasons)}" if reasons else ""
        means.append(mean.doubt(doubt, vague(mean)))
    return tuple(means)


def _repeats_of(observation: Observation) -> list[Observation]:
    """An observation for each repeat that a recording holds; one without, itself."""
    return [
        replace(
            observation,
            recording=f"{observation.recording}/{number}",
            quantities=quantities,
            repeats=(),
        )
        for number, quantities in enumerate(observation.repeats, 1)
    ] or [observation]


def as_table(lines: Sequence[Line]) -> pd.DataFrame:
    """The lines as rows of summary.csv; outliers parted by semicolons."""
    rows = [asdict(line) | {"outliers": "; ".join(line.outliers)} for line in lines]
    return pd.DataFrame(rows, columns=[field.name for field in fields(Line)])


def _levels(stated: Mapping[str, float | str], names: Iterable[str]) -> list[str]:
    """Those of the names that are stated, with their values, in words."""
    held = ((k, stated[k]) for k in names if k in stated)
    return [f"{k} = {v:g}" if isinstance(v, float) else f"{k} = {v}" for k, v in held]


def _names(held: Sequence[Mapping[str, float | str]]) -> list[str]:
    return list(dict.fromkeys(name for one in held for name in one))


def _with_repeats(
    held: Sequence[Mapping[str, float | str]], count: int, names: Iterable[str]
) -> list[str]:
    """Those names whose levels are told apart: words always, numbers where there are
    repeats at them: two of `count` recordings or readings a level on average."""
    return [
        n
        for n in names
        if any(isinstance(one.get(n), str) for one in held)
        or 2 * len({one.get(n) for one in held}) <= count
    ]


def _same(stated: Sequence[Mapping[str, float | str]], name: str) -> bool:
    """Whether recordings state the same, but for how well anybody measures it."""
    values = {one.get(name) for one in stated}
    numbers = [v for v in values if isinstance(v, float)]
    if len(numbers) < len(values):
        return len(values) == 1
    return max(numbers) - min(numbers) <= SAME * max(map(abs, numbers))


def _count(observation: Observation) -> int:
    """How many repeats an observation stands for: its readings, or itself."""
    readings = observation.readings
    return 1 if readings is None or readings.empty else int(readings["n"].max())


def _line(key: tuple, repeats: list[tuple[Observation, Quantity]]) -> Line:
    bench, rig, name, unit, conditions = key
    measured = [
        (o, q) for o, q in repeats if q.quality != FAILED and np.isfinite(q.value)
    ]
    values = np.array([q.value for _, q in measured])
    n, mean = values.size, float(values.mean()) if values.size else np.nan
    sds = np.array([np.sqrt(max(q.sd**2 - q.sd_common**2, 0)) for _, q in measured])
    # errors that the recordings of one session share
    shared = pd.Series([q.sd_common for _, q in measured], dtype=float)
    shared = shared.groupby([o.session or "" for o, _ in measured]).sum()
    common = float(np.linalg.norm(shared)) / max(n, 1)
    count, scatter, half_alone = n, np.nan, np.nan
    if n > 1:
        scatter = float(values.std(ddof=1))
        half_alone = stats.t.ppf(0.975, n - 1) * scatter / np.sqrt(n)
        if scatter <= EXACT_SHARE * abs(mean) and np.isfinite(sds).any():
            half_alone = 1.96 * float(np.sqrt(np.nanmean(sds**2)))
    elif n:
        half_alone = 1.96 * float(sds[0])
        if (readings := measured[0][0].readings) is not None:  # a mean of readings
            rows = readings[readings["quantity"] == name]
            if len(rows) == 1:
                count, scatter = int(rows["n"].iloc[0]), float(rows["sd"].iloc[0])
    half = float(np.hypot(half_alone, 1.96 * common))
    measuring = float(np.sqrt(np.nanmean(sds**2))) if np.isfinite(sds).any() else np.nan
    return Line(
        bench,
        rig,
        name,
        conditions,
        count,
        mean,
        mean - half,
        mean + half,
        unit,
        scatter,
        measuring,
        common,
        sum(q.quality == DOUBTFUL for _, q in measured),
        len(repeats) - n,
        tuple(_outliers(measured, values, sds)),
    )


def _outliers(
    measured: list[tuple[Observation, Quantity]], values: np.ndarray, sds: np.ndarray
) -> Iterable[str]:
    """Repeats too far from the mean of the others (deleted residuals with Bonferroni
    correction)."""
    n = values.size
    if n < LEAST_FOR_OUTLIERS:
        return
    bound = stats.t.ppf(1 - OUTLIER_P / (2 * n), n - 2)
    for i, (observation, _) in enumerate(measured):
        others = np.delete(values, i)
        # equal readings have no scatter, yet are not exact
        least = np.nanmean(sds) if np.isfinite(sds).any() else 0.0
        spread = max(others.std(ddof=1), least) * np.sqrt(1 + 1 / (n - 1))
        if abs(values[i] - others.mean()) > bound * spread:
            yield observation.recording
