"""Recordings of the predicted system, measured, and whether the prediction holds
them."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy import stats

from benchtwin.bench.rigs import variant_of
from benchtwin.calibrate.prediction.predict import (
    QUANTITIES,
    SET,
    UNITS,
    Prediction,
    digits,
    sign,
)
from benchtwin.calibrate.statistics.predictive import NORMAL_95
from benchtwin.twin import Parameters
from benchtwin.twin.bench_folder import Observed, RecordingReadings, read_bench
from benchtwin.twin.job import Job, rig_named
from benchtwin.twin.scene import rig_of, section_of

APART_P = 0.01  # F test: the recordings scatter more than the simulated packings do


@dataclass(frozen=True, kw_only=True, eq=False)
class Measured:
    """values: {quantity: (n,) readings}; reading_sd, shared_sd: of single readings and
    of all of them together, of the rig's first quantity and others of its unit;
    recordings: their names; notes: what was left out, and why."""

    values: dict[str, np.ndarray]
    reading_sd: float
    shared_sd: float
    recordings: tuple[str, ...]
    notes: tuple[str, ...]


@dataclass(frozen=True, kw_only=True)
class Comparison:
    """One quantity: n readings with their mean; predicted mean and low, high:
    where the mean of so many recordings is expected, 95 %; z: difference over that
    expectation's sd; said: one sentence."""

    quantity: str
    measured: float
    n: int
    predicted: float
    low: float
    high: float
    z: float
    said: str


def recordings(folder: Path | Observed, rig: str) -> list[RecordingReadings]:
    """Recordings of this kind of rig under `folder`, measured, and what cannot be read
    at all. FileNotFoundError without a folder; ValueError where there is none."""
    of, keys = rig_named(rig)
    stated = ", ".join(keys.get(of, ()))
    what = f"{of} whose [{of}] states {stated}" if stated else rig
    found = read_bench(folder, of)
    found = [s for s in found if not s.rig or variant_of(of, s.description) == rig]
    if not any(s.rig for s in found):
        trouble = "".join(f"; {s.trouble}" for s in found)
        raise ValueError(f"{folder}: no recording of a {what}{trouble}")
    return found


def measured(found: list[RecordingReadings], rig: str, description: dict) -> Measured:
    """Readings of the recordings whose rig is the very one that `description`
    describes; others are named and left out. ValueError where none is left."""
    notes, taken = [], []
    for seen in found:
        if seen.trouble:
            notes.append(f"{seen.recording}: {seen.trouble}")
        elif _built(rig, seen.description) != _built(rig, description):
            notes.append(
                f"{seen.recording}: another {rig} than the predicted one "
                f"({_built(rig, seen.description)}); left out"
            )
        else:
            taken.append(seen)
    if not taken:
        raise ValueError(
            f"no recording of the predicted {rig} could be measured: {'; '.join(notes)}"
        )
    read = [{**s.further, s.response: s.readings} for s in taken]
    nothing, own = np.zeros(0), np.concatenate([s.reading_sd for s in taken])
    return Measured(
        values={
            q: np.concatenate([r.get(q, nothing) for r in read])
            for q in QUANTITIES[rig]
        },
        reading_sd=float(np.sqrt(np.mean(own**2))),
        shared_sd=max(s.shared_sd for s in taken),
        recordings=tuple(s.recording for s in taken),
        notes=tuple(notes),
    )


def _built(rig: str, description: dict) -> str:
    """The rig with everything that is not stated at its default, as text."""
    whole = _whole(rig, description.get(rig_named(rig)[0], {}))
    return ", ".join(f"{k} {v}" for k, v in whole.items())


def _whole(rig: str, section: dict) -> dict:
    """A rig's section with everything that the rig knows of itself, and nothing that is
    a single recording's."""
    recording = Job(
        rig_named(rig)[0], Parameters(), {rig_named(rig)[0]: section}
    ).recording(Path())
    known = section_of(rig_of(recording), type(getattr(recording, rig_named(rig)[0]))())
    return known.model_dump(exclude_none=True, mode="json")


def described_by(found: list[RecordingReadings], rig: str) -> dict:
    """{rig: its section} as the first of these recordings has it."""
    first = next(s for s in found if s.rig)
    return {
        rig_named(rig)[0]: _whole(rig, first.description.get(rig_named(rig)[0], {}))
    }


def compare(found: Prediction, seen: Measured) -> list[Comparison]:
    """A comparison for each quantity of which there are readings."""
    return [_compared(found, seen, q) for q in found.of if seen.values[q].size]


def _compared(found: Prediction, seen: Measured, quantity: str) -> Comparison:
    """The mean of n recordings is expected where n further packings would be, with the
    recordings' own errors. Recordings that scatter by more than packings do (APART_P)
    count with their own scatter."""
    p, values = found.of[quantity], seen.values[quantity]
    n, mean = values.size, float(values.mean())
    own, shared = _reading_errors(found.rig, seen, quantity)
    errors, note = shared**2 + own**2 / n, ""
    if n > 1:
        runs = found.runs.loc[found.runs["kind"].eq(SET), quantity].dropna()
        variance = values.var(ddof=1)
        ratio = variance / (runs.var(ddof=1) + own**2)
        if stats.f.sf(ratio, n - 1, len(runs) - 1) < APART_P:
            errors += max(0.0, float(variance) - p.packing_sd**2) / n
            sd = f"{digits(quantity, np.sqrt(variance))}{sign(quantity)}"
            note = f"; the recordings scatter by {sd}, more than packings do"
    half = float(np.hypot(p.half_width(n), NORMAL_95 * np.sqrt(errors)))
    low, high, z = p.mean - half, p.mean + half, (mean - p.mean) / (half / NORMAL_95)
    where = "within" if abs(mean - p.mean) <= half else "above" if z > 0 else "below"
    many = f"the mean of {n} recordings" if n > 1 else "one recording"
    at, *ends = (digits(quantity, v) + sign(quantity) for v in (mean, low, high))
    return Comparison(
        quantity=quantity,
        measured=mean,
        n=n,
        predicted=p.mean,
        low=low,
        high=high,
        z=z,
        said=(
            f"{QUANTITIES[found.rig][quantity]}: {many}, {at}, lies {where} the"
            f" predicted {' to '.join(ends)} (z = {z:+.1f}){note}"
        ),
    )


def _reading_errors(rig: str, seen: Measured, quantity: str) -> tuple[float, float]:
    """sd of single readings of a quantity, and of all of them together."""
    first = next(iter(QUANTITIES[rig]))
    alike = UNITS[quantity] == UNITS[first]
    return (seen.reading_sd, seen.shared_sd) if alike else (0.0, 0.0)
