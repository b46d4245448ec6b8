"""Recordings of the predicted system, measured, and whether the prediction holds
them."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from benchtwin.calibrate.prediction.predict import MEAN, QUANTITIES, RIG_OF, Prediction
from benchtwin.calibrate.statistics.predictive import NORMAL_95
from benchtwin.twin import Parameters
from benchtwin.twin.bench_folder import Observed, RecordingReadings, read_bench
from benchtwin.twin.job import Job
from benchtwin.twin.scene import rig_of, section_of
from scipy import stats

APART_P = (
    0.01  # two-sided F test: the recordings scatter more than the simulated packings do
)


@dataclass(frozen=True, eq=False)
class Measured:
    """values: {quantity: (n,) readings [deg]}; reading_sd, shared_sd: of single
    readings and of all of them together [deg]; recordings: their names; notes: what was
    left out, and why."""

    values: dict[str, np.ndarray]
    reading_sd: float
    shared_sd: float
    recordings: tuple[str, ...]
    notes: tuple[str, ...]


@dataclass(frozen=True)
class Comparison:
    """One quantity: n readings with their mean [deg]; predicted mean and low, high:
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
    found = [
        s
        for s in read_bench(folder, RIG_OF[rig])
        if not s.rig
        or rig != "cylinder"
        or "cylinder_mm" in s.description.get("pile", {})
    ]
    if not any(s.rig for s in found):
        what = "pile whose [pile] states cylinder_mm" if rig == "cylinder" else rig
        raise ValueError(
            f"{folder}: no recording of a {what}"
            + "".join(f"; {s.trouble}" for s in found)
        )
    return found


def measured(found: list[RecordingReadings], rig: str, description: dict) -> Measured:
    """Readings of the recordings whose rig is the very one that `description`
    describes; others are named and left out.

    ValueError where none is left.
    """
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
    values = {
        q: np.concatenate([_readings(s, q) for s in taken]) for q in QUANTITIES[rig]
    }
    own = float(np.sqrt(np.mean(np.concatenate([s.reading_sd for s in taken]) ** 2)))
    return Measured(
        values,
        own,
        max(s.shared_sd for s in taken),
        tuple(s.recording for s in taken),
        tuple(notes),
    )


def _readings(seen: RecordingReadings, quantity: str) -> np.ndarray:
    return (
        seen.readings
        if seen.response == quantity
        else seen.further.get(quantity, np.zeros(0))
    )


def _built(rig: str, description: dict) -> str:
    """The rig with everything that is not stated at its default, as text."""
    return ", ".join(
        f"{k} {v}" for k, v in _whole(rig, description.get(RIG_OF[rig], {})).items()
    )


def _whole(rig: str, section: dict) -> dict:
    """A rig's section with everything that the rig knows of itself, and nothing that is
    a single recording's."""
    recording = Job(RIG_OF[rig], Parameters(), {RIG_OF[rig]: section}).recording(Path())
    known = section_of(rig_of(recording), type(getattr(recording, RIG_OF[rig]))())
    return known.model_dump(exclude_none=True, mode="json")


def described_by(found: list[RecordingReadings], rig: str) -> dict:
    """{rig: its section} as the first of these recordings has it."""
    first = next(s for s in found if s.rig)
    return {RIG_OF[rig]: _whole(rig, first.description.get(RIG_OF[rig], {}))}


def compare(found: Prediction, seen: Measured) -> list[Comparison]:
    """A comparison for each quantity of which there are readings."""
    return [_compared(found, seen, q) for q in found.of if seen.values[q].size]


def _compared(found: Prediction, seen: Measured, quantity: str) -> Comparison:
    """The mean of n recordings is expected where n further packings would be, with the
    recordings' own errors. Recordings that scatter by more than packings do (APART_P)
    count with their own scatter."""
    p, values = found.of[quantity], seen.values[quantity]
    n, mean = values.size, float(values.mean())
    packings = found.runs.loc[found.runs["kind"].eq(MEAN), quantity].dropna()
    errors = seen.shared_sd**2 + seen.reading_sd**2 / n
    note = ""
    if (
        n > 1
        and stats.f.sf(
            values.var(ddof=1) / (packings.var(ddof=1) + seen.reading_sd**2),
            n - 1,
            len(packings) - 1,
        )
        < APART_P
    ):
        errors += max(0.0, float(values.var(ddof=1)) - p.packing_sd**2) / n
        note = (
            f"; the recordings scatter by {values.std(ddof=1):.1f}°, more than"
            " packings do"
        )
    half = float(np.hypot(p.half_width(n), NORMAL_95 * np.sqrt(errors)))
    z = (mean - p.mean) / (half / NORMAL_95)
    name = QUANTITIES[found.rig][quantity]
    inside = (
        "lies within"
        if abs(mean - p.mean) <= half
        else f"lies {'above' if z > 0 else 'below'}"
    )
    many = f"the mean of {n} recordings" if n > 1 else "one recording"
    expected = f"the predicted {p.mean - half:.1f} to {p.mean + half:.1f}°"
    said = f"{name}: {many}, {mean:.1f}°, {inside} {expected} (z = {z:+.1f}){note}"
    return Comparison(quantity, mean, n, p.mean, p.mean - half, p.mean + half, z, said)
