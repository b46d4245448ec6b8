"""readings.csv → means with sds, n and range, and what follows from them for the
rig."""

import math
from dataclasses import dataclass, replace

import numpy as np
import pandas as pd
from pydantic import ValidationError

from benchtwin.bench.distributions import t as student
from benchtwin.bench.language import tr
from benchtwin.bench.priors import unstated_sd
from benchtwin.bench.resolution import reading_step
from benchtwin.bench.rigs import READING_COLUMNS, RIGS
from benchtwin.bench.robust import robust_sd
from benchtwin.vision.evidence.tables import Table, read_readings
from benchtwin.vision.measurement import MeasurementError, Observation, Quantity
from benchtwin.vision.recording import Recording
from benchtwin.vision.summary import mean_over_repeats

# Systematic errors of instruments, shared by all readings of a session: zero of a
# protractor, ruler or scale, a stop watch by hand; release height.
INSTRUMENT_SD = {
    "deg": unstated_sd("reader-zero"),
    "mm": unstated_sd("ruler-zero"),
    "g": 0.05,
    "s": 0.1,
}
LEAST_IN_TURN, LEAST_FACTOR = 3, 2.0  # of readings that fall in turn
STATISTICS = ("mean", "sd", "sd_mean", "n", "low", "high", "unit", "left_out")


@dataclass(frozen=True)
class Summary:
    """Statistics of n repeated readings. sd_mean = sd / √n, widened by Student's t so
    that mean ± 1.96 sd_mean is a 95 % interval. sd_rounding: error due to the step of
    the readings, which repeats reduce only where they scatter by more than a step."""

    mean: float
    sd: float
    sd_mean: float
    n: int
    low: float
    high: float
    sd_rounding: float


@dataclass(frozen=True)
class Derived:
    """What follows from the mean of a rig's readings: quantities, notes, and doubts
    about the readings themselves."""

    quantities: tuple[Quantity, ...] = ()
    notes: tuple[str, ...] = ()
    doubts: tuple[str, ...] = ()


def summarise(values: np.ndarray, trim: bool = False) -> Summary:
    """Statistics of `values` (n ≥ 1); trim: without the highest and the lowest (n ≥ 4),
    whose scatter is then understated."""
    values = np.sort(np.asarray(values, dtype=float))
    if trim and values.size >= 4:
        values = values[1:-1]
    step, n = reading_step(values), values.size
    sd = float(values.std(ddof=1)) if n > 1 else float("nan")
    sd_mean = float(sd / np.sqrt(n) * student.ppf(0.975, max(n - 1, 1)) / 1.96)
    # A mean of rounded readings is off by at most step/π exp(−2π² σ²/step²), σ the
    # scatter before rounding; all of it when σ = 0.
    unrounded = max(sd**2 - step**2 / 12, 0.0) if n > 1 else 0.0
    unheld = np.exp(-2 * np.pi**2 * unrounded / step**2) if step else 0.0
    rounding = step / np.sqrt(12) * unheld
    mean = float(values.mean())
    low = float(values[0])
    return Summary(mean, sd, sd_mean, n, low, float(values[-1]), float(rounding))


def observe_readings(recording: Recording, trim: bool = False) -> Observation:
    """Means of readings, and what follows from them for the rig; where rows state
    different things, what follows from each and the mean of that alone."""
    table: Table = read_readings(recording.files[0])
    columns = [c for c in table.rows if c in READING_COLUMNS]
    rig = recording.rig or READING_COLUMNS[columns[0]][0]
    if other := [c for c in columns if READING_COLUMNS[c][0] != rig]:
        raise MeasurementError(
            tr(
                "{}: {} belongs to a {}, the rig is {}",
                recording.files[0],
                other[0],
                READING_COLUMNS[other[0]][0],
                rig,
            )
        )
    parts = [
        _part(each, rig, rows, columns, trim)
        for each, rows in rows_alike(recording, rig, table)
    ]
    tables = [part.readings for part in parts if part.readings is not None]
    readings = pd.concat(tables, ignore_index=True)
    notes = tuple(dict.fromkeys(n for part in parts for n in part.notes))
    if len(parts) == 1:
        read = [READING_COLUMNS[c][1] for c in columns]
        alone = {name for name in read if (readings["n"] == 1).all()}
        single = tr("a single reading: no standard deviation") if alone else ""
        quantities = tuple(q.doubt(single) for q in parts[0].quantities)
        return replace(parts[0], quantities=quantities, notes=(*table.notes, *notes))
    told = {READING_COLUMNS[c][1] for c in columns}
    repeats = tuple(
        tuple(q for q in part.quantities if q.name not in told) for part in parts
    )
    found = mean_over_repeats([each for each in repeats if each])
    several = tr(
        "{} different {}: no mean of readings", len(parts), ", ".join(RIGS[rig].by_row)
    )
    return Observation(
        recording.id,
        rig,
        found,
        (*table.notes, several, *notes),
        readings=readings,
        repeats=repeats,
    )


def _part(
    recording: Recording, rig: str, rows: pd.DataFrame, columns: list[str], trim: bool
) -> Observation:
    """What rows tell that state the same."""
    derive = RIGS[rig].part("derive") if RIGS[rig].derive else None
    quantities: list[Quantity] = []
    notes: list[str] = []
    table, section = [], getattr(recording, rig)
    stated = {k: getattr(section, k) for k in RIGS[rig].by_row if k in rows}
    for column in columns:
        _, name, unit = READING_COLUMNS[column]
        values = rows[column].dropna().to_numpy()
        if not len(values):
            continue
        s = summarise(values, trim)
        common = float(np.hypot(s.sd_rounding, INSTRUMENT_SD[unit]))
        told = derive(recording, s, common) if derive else Derived()
        notes += told.notes
        read = mean_quantity(name, s.mean, s.sd_mean, common, unit)
        doubts = (*told.doubts, _far_off(values), _in_radians(values, unit))
        doubts = (*doubts, falls_in_turn(values))
        quantities += [q.doubt(*doubts) for q in (read, *told.quantities)]
        left_out = values.size - s.n
        statistics = (s.mean, s.sd, s.sd_mean, s.n, s.low, s.high)
        table.append(
            (recording.id, name, *stated.values(), *statistics, unit, left_out)
        )
        trimmed = tr("; one highest and one lowest left out") if left_out else ""
        if s.n > 1:
            notes.append(
                tr(
                    "{}: n = {}, sd {:.3g} {}, range {:g}–{:g} {}{}",
                    name,
                    s.n,
                    s.sd,
                    unit,
                    s.low,
                    s.high,
                    unit,
                    trimmed,
                )
            )
    heading = ["recording", "quantity", *stated, *STATISTICS]
    readings = pd.DataFrame(table, columns=heading)
    return Observation(
        recording.id, rig, tuple(quantities), tuple(notes), readings=readings
    )


def _in_radians(values: np.ndarray, unit: str) -> str:
    """A doubt where angles are small enough to be radians; ""."""
    if unit != "deg" or values.max() > np.pi / 2:
        return ""
    degrees = np.degrees(values.mean())
    return tr("all readings lie below 1.6°: are they radians ({:.3g}°)?", degrees)


def _far_off(values: np.ndarray) -> str:
    """A doubt where one reading lies far from the others; ""."""
    off = np.abs(values - np.median(values))
    typical = robust_sd(off)
    if values.size >= 4 and typical > 0 and off.max() > 8 * typical:
        return tr("the reading {:g} lies far from the others", values[off.argmax()])
    return ""


def mean_quantity(
    name: str, value: float, sd: float, common: float, unit: str
) -> Quantity:
    """A quantity of readings. sd: of the mean, from the scatter; common: sd that
    repeats do not reduce."""
    return Quantity(name, value, float(np.hypot(sd, common)), unit, sd_common=common)


def root_of_heights(
    name: str, read: Summary, common: float, height_mm: float, height_sd_mm: float
) -> Quantity:
    """√(h'/h) from the mean of rises h' [mm] after falls of h; common: sd of that mean
    that repeats do not reduce."""
    e = math.sqrt(read.mean / height_mm)
    shared = math.hypot(common / read.mean, height_sd_mm / height_mm)
    own = read.sd_mean / read.mean
    return mean_quantity(name, e, e / 2 * own, e / 2 * shared, "1")


def rows_alike(
    recording: Recording, rig: str, table: Table
) -> list[tuple[Recording, pd.DataFrame]]:
    """The rows that state the same, each with the recording as they state it, in the
    order of the table; all rows where none states anything."""
    rows, known = table.rows, RIGS[rig]
    if known.in_turn and known.in_turn[0] in rows:
        rows = _each_from_the_last(recording, rig, rows)
        recording = _stating(recording, rig, {known.in_turn[1]: None}, rows)
    columns = [c for c in known.by_row if c in rows]
    if not columns:
        return [(recording, rows)]
    groups = rows.groupby(columns, dropna=False, sort=False)
    parts = []
    for level, part in groups:
        named = zip(columns, level, strict=True)
        stated: dict[str, float | None] = {
            c: float(v) for c, v in named if np.isfinite(v)
        }
        parts.append((_stating(recording, rig, stated, part), part))
    return parts


def falls_in_turn(values: np.ndarray) -> str:
    """A doubt where readings fall from each to the next to less than a half, which
    repeats of one thing do not; ""."""
    falls = len(values) >= LEAST_IN_TURN and (np.diff(values) < 0).all()
    if not falls or values[0] < LEAST_FACTOR * values[-1]:
        return ""
    return tr(
        "each reading is lower than the one before, from {:g} to {:g}: no"
        " repeats of one thing? Successive bounces need a column bounce",
        values[0],
        values[-1],
    )


def _stating(
    recording: Recording, rig: str, known: dict[str, float | None], rows: pd.DataFrame
) -> Recording:
    """The recording with these keys of its rig's section."""
    section = getattr(recording, rig)
    try:
        told = type(section)(**section.model_dump(exclude_none=True) | known)
    except ValidationError as error:
        wrong = error.errors()[0]
        message = tr(
            "{}: {} = {} in row", recording.files[0], wrong["loc"][0], wrong["input"]
        )
        raise MeasurementError(
            f"{message} {rows.index[0] + 2}: {wrong['msg']}"
        ) from error
    return replace(recording, **{rig: told})


def _each_from_the_last(
    recording: Recording, rig: str, rows: pd.DataFrame
) -> pd.DataFrame:
    """The rows with the key that each states for the next one, by their number; row 0
    states it for the first. A number that does not rise begins a new series."""
    number, key = RIGS[rig].in_turn
    column = next(iter(RIGS[rig].readings))
    count, value = rows[number].to_numpy(float), rows[column].to_numpy(float)
    if not (np.isfinite(count) & (count >= 0) & (count == np.round(count))).all():
        raise MeasurementError(f"{recording.files[0]}: {number} counts 1, 2, 3 …")
    begins = [getattr(getattr(recording, rig), key) or np.nan]
    if key in rows:
        begins = rows[key].to_numpy(float)
    before = np.full(len(rows), np.nan)
    for k, n in enumerate(count):
        if n == 1:
            before[k] = begins[k % len(begins)]
        if k and count[k - 1] == n - 1:
            before[k] = value[k - 1]
    return rows.assign(**{key: before})[count > 0]
