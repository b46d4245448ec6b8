"""readings.csv → means with sds, n and range, and what follows from them for the
rig."""

from dataclasses import dataclass

import numpy as np
import pandas as pd

from benchtwin.bench.distributions import t as student
from benchtwin.bench.priors import unstated_sd
from benchtwin.bench.resolution import reading_step
from benchtwin.bench.rigs import READING_COLUMNS, RIGS
from benchtwin.bench.robust import robust_sd
from benchtwin.vision.evidence.tables import Table, read_readings
from benchtwin.vision.measurement import MeasurementError, Observation, Quantity
from benchtwin.vision.recording import Recording

# Systematic errors of instruments, shared by all readings of a session: zero of a
# protractor, ruler or scale, a stop watch by hand; release height.
INSTRUMENT_SD = {
    "deg": unstated_sd("reader-zero"),
    "mm": unstated_sd("ruler-zero"),
    "g": 0.05,
    "s": 0.1,
}


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
    if n > 1:
        sd_mean = float(sd / np.sqrt(n) * student.ppf(0.975, n - 1) / 1.96)
    else:
        sd_mean = float("nan")
    # A mean of rounded readings is off by at most step/π exp(−2π² σ²/step²), σ the
    # scatter before rounding; all of it when σ = 0.
    unrounded = max(sd**2 - step**2 / 12, 0.0) if n > 1 else 0.0
    if step:
        rounding = step / np.sqrt(12) * np.exp(-2 * np.pi**2 * unrounded / step**2)
    else:
        rounding = 0.0
    mean = float(values.mean())
    low = float(values[0])
    return Summary(mean, sd, sd_mean, n, low, float(values[-1]), float(rounding))


def observe_readings(recording: Recording, trim: bool = False) -> Observation:
    """Means of readings, and what follows from them for the rig."""
    table: Table = read_readings(recording.files[0])
    columns = [c for c in table.rows if c in READING_COLUMNS]
    rig = recording.rig or READING_COLUMNS[columns[0]][0]
    derive = RIGS[rig].part("derive") if RIGS[rig].derive else None
    quantities: list[Quantity] = []
    notes, rows = list(table.notes), []
    for column in columns:
        column_rig, name, unit = READING_COLUMNS[column]
        if column_rig != rig:
            raise MeasurementError(
                f"{recording.files[0]}: {column} belongs to a {column_rig}, the rig is"
                f" {rig}"
            )
        values = table.rows[column].dropna().to_numpy()
        s = summarise(values, trim)
        common = float(np.hypot(s.sd_rounding, INSTRUMENT_SD[unit]))
        told = derive(recording, s, common) if derive else Derived()
        notes += told.notes
        read = mean_quantity(name, s.mean, s.sd_mean, common, unit, s.n)
        doubts = (*told.doubts, _far_off(values), _in_radians(values, unit))
        quantities += [q.doubt(*doubts) for q in (read, *told.quantities)]
        left_out = values.size - s.n
        statistics = (s.mean, s.sd, s.sd_mean, s.n, s.low, s.high)
        rows.append((recording.id, name, *statistics, unit, left_out))
        trimmed = "; one highest and one lowest left out" if left_out else ""
        if s.n > 1:
            notes.append(
                f"{name}: n = {s.n}, sd {s.sd:.3g} {unit}, range {s.low:g}–{s.high:g}"
                f" {unit}{trimmed}"
            )
    heading = [
        "recording",
        "quantity",
        "mean",
        "sd",
        "sd_mean",
        "n",
        "low",
        "high",
        "unit",
        "left_out",
    ]
    readings = pd.DataFrame(rows, columns=heading)
    return Observation(
        recording.id, rig, tuple(quantities), tuple(notes), readings=readings
    )


def _in_radians(values: np.ndarray, unit: str) -> str:
    """A doubt where angles are small enough to be radians; ""."""
    if unit != "deg" or values.max() > np.pi / 2:
        return ""
    degrees = np.degrees(values.mean())
    return f"all readings lie below 1.6°: are they radians ({degrees:.3g}°)?"


def _far_off(values: np.ndarray) -> str:
    """A doubt where one reading lies far from the others; ""."""
    off = np.abs(values - np.median(values))
    typical = robust_sd(off)
    if values.size >= 4 and typical > 0 and off.max() > 8 * typical:
        return f"the reading {values[off.argmax()]:g} lies far from the others"
    return ""


def mean_quantity(
    name: str, value: float, sd: float, common: float, unit: str, n: int
) -> Quantity:
    """A quantity of n readings. sd: of the mean, from the scatter; common: sd that
    repeats do not reduce."""
    found = Quantity(name, value, float(np.hypot(sd, common)), unit, sd_common=common)
    return found.doubt("a single reading: no standard deviation" if n == 1 else "")
