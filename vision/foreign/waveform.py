"""Sound as numbers in a text: samples one below the other with their rate above, or
beside their times, as oscilloscopes and sound editors write them."""

import re

import numpy as np

from benchtwin.vision.evidence.sound import LEAST_S, LONGEST_S, RATES_HZ, Sound
from benchtwin.vision.foreign.contents import Contents
from benchtwin.vision.foreign.source import TIME, Rows, Source, column
from benchtwin.vision.foreign.table_of_places import parsed
from benchtwin.vision.measurement import MeasurementError, require

TOOL = "waveform"
LEAST_ROWS = round(LEAST_S * RATES_HZ[0])
MOST_ABOVE = 40  # lines above the numbers
EVEN = 0.02  # of a step, by which steps differ beyond what rounding explains
SWINGS = 0.01  # of the rows, after which a sound has changed its sign
FULL = 0.9  # of full scale, to which the greatest sample is set
USUAL_HZ = 44_100
_SAMPLING = re.compile(
    r"(?:sampl|abtast|échantillon|muestreo|campionamento|\bfs\b|increment|xincr)"
    r"[^\d\n]{0,30}?(\d+\.?\d*(?:e[+-]?\d+)?)\s*(khz|hz|ms|µs|us)?",
    re.IGNORECASE,
)
_INTERVAL = re.compile("interval|increment|xincr|period|zeit", re.IGNORECASE)
_HERTZ = re.compile(r"(\d+\.?\d*)\s*(khz|hz)\b", re.IGNORECASE)


def recognises(source: Source) -> bool:
    """Whether a file is of this kind: numbers in one column, or in two of which the
    first counts time by steps as short as sound's, and a rate or swings."""
    if not source.is_text or len(source.first_lines) < 2:
        return False
    at = _first_numbers(source.first_rows)
    head = source.first_rows[at:]
    if at < 0 or len({len(_numbers(row)) for row in head}) > 1:
        return False
    wide = len(_numbers(head[0]))
    if wide > 2 or (wide == 2 and _step(source, head, at) > 1.01 / RATES_HZ[0]):
        return False
    samples = _samples(source)
    if len(samples) < LEAST_ROWS:
        return False
    level = samples - np.median(samples)
    turns = np.count_nonzero(np.diff(np.sign(level[level != 0]))) / len(level)
    return bool(turns > SWINGS) or (wide == 1 and _stated_rate(source, at) > 0)


def read(source: Source) -> Contents:
    """The samples, the greatest FULL of full scale; MeasurementError without a rate."""
    path, at = source.path, _first_numbers(source.first_rows)
    samples = _samples(source)
    two = len(_numbers(source.first_rows[at])) == 2
    rate = 1 / _step(source, source.rows[at:], at) if two else _stated_rate(source, at)
    require(
        rate,
        f"{path}: {len(samples):,} samples of a sound without their rate; at"
        f" {USUAL_HZ:,} a second they last {len(samples) / USUAL_HZ:.3g} s; write"
        f' it above them, such as "sample rate {USUAL_HZ} Hz"',
    )
    if not RATES_HZ[0] <= 1.01 * rate or rate > RATES_HZ[1]:
        low, high = RATES_HZ
        raise MeasurementError(
            f"{path}: {rate:g} samples a second; sound should have {low:,} to {high:,}"
        )
    level = samples[: round(LONGEST_S * rate)]
    level = level - np.median(level)
    level *= FULL / max(float(np.abs(level).max()), 1e-300)
    heard = Sound(path, level.astype(np.float32), float(rate), 0.0, lossy=False)
    return Contents(TOOL, waveform=heard)


def _first_numbers(rows: Rows) -> int:
    """Row at which the numbers begin that go on to the end of these rows; −1 where
    there are none."""
    at = len(rows)
    while at and any(isinstance(c, float) for c in rows[at - 1]):
        if any(isinstance(c, str) and c for c in rows[at - 1]):
            break
        at -= 1
    return at if at < min(len(rows) - 1, MOST_ABOVE) else -1


def _numbers(row: list) -> list[float]:
    return [c for c in row if isinstance(c, float)]


def _samples(source: Source) -> np.ndarray:
    """(n,) the last column of the file; none where it has words among its numbers."""
    rows = source.rows
    at = _first_numbers(rows[: len(source.first_rows)])
    if at < 0:
        return np.empty(0)
    try:
        found = column(
            source.path, rows[at:], len(_numbers(rows[at])) - 1, "sample", at + 1
        )
    except MeasurementError:
        return np.empty(0)
    return found[np.isfinite(found)]


def _step(source: Source, rows: Rows, at: int) -> float:
    """Time between rows [s], infinite where it is not even or beside a place."""
    heads = [parsed(cell) for cell in source.first_rows[at - 1]] if at else []
    time = np.array([_numbers(row)[0] for row in rows if len(_numbers(row)) == 2])
    steps = np.diff(time)
    place = any(h.holds in ("x", "y", "length") for h in heads)
    if place or not steps.size or not (steps > 0).all():
        return np.inf
    step = float(time[-1] - time[0]) / len(steps)
    digits = 10 ** np.floor(np.log10(max(abs(time[-1]), 1e-300)) - 5)  # of rounding
    even = np.abs(steps - step).max() <= EVEN * step + digits
    unit = next((h.unit for h in heads if h.holds == "clock"), "")
    return step * TIME.get(unit, 1.0) if even else np.inf


def _stated_rate(source: Source, at: int) -> float:
    """Samples a second that the lines above the numbers state, 0 where they do not."""
    above = "\n".join(source.first_lines[: at + MOST_ABOVE])
    above = "\n".join(
        line for line in above.splitlines() if re.search("[^\\W\\d]", line)
    )
    if found := _SAMPLING.search(above):
        number, unit = float(found[1]), (found[2] or "").lower()
        if unit in TIME or _INTERVAL.search(found[0]):
            return 1 / (number * TIME.get(unit, 1.0)) if number else 0.0
    elif not (found := _HERTZ.search(above)):
        return 0.0
    return float(found[1]) * (1000 if (found[2] or "").lower() == "khz" else 1)
