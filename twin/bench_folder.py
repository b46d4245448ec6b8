"""A bench folder as a calibration sees it: what was read on each recording, and what
the recordings state of the rig."""

import hashlib
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from benchtwin.bench.rigs import READING_COLUMNS, RIGS
from benchtwin.measure.observed import Observed as Observed
from benchtwin.vision.evidence.tables import read_numbers as read_numbers
from benchtwin.vision.evidence.tables import read_readings
from benchtwin.vision.measurement import FAILED, MeasurementError
from benchtwin.vision.recording import Recording
from benchtwin.vision.recording import among_results as among_results

# what each rig is read for: its first column; further ones go beside it
RESPONSES = {rig: column for column, (rig, *_) in reversed(READING_COLUMNS.items())}
FURTHER = {
    rig: [c for c, (r, *_) in READING_COLUMNS.items() if r == rig and c != main]
    for rig, main in RESPONSES.items()
}
SECTIONS = ("seed", "camera", "air")


@dataclass(frozen=True, eq=False)
class RecordingReadings:
    """One recording.

    response: the column its readings belong to (`rebound_height_mm` …); readings: (n,)
    in its unit, one for a film or photo, one a drop of several; reading_sd: (n,)
    measuring error that is each reading's own, 0 where none is known; shared_sd: error
    that all recordings of the session share (scale, plumb line); description: what
    recording.toml and bench.toml state, by section; trouble: why nothing could be read,
    "" when something was; doubt:
    why it is to be trusted less; further: other readings of the same piles, by column.
    """

    recording: str
    rig: str
    response: str
    readings: np.ndarray
    reading_sd: np.ndarray
    shared_sd: float
    description: dict
    path: str
    provenance: str
    notes: tuple[str, ...] = ()
    doubt: str = ""
    trouble: str = ""
    derived: dict[str, float] = field(default_factory=dict)
    further: dict[str, np.ndarray] = field(default_factory=dict)


def read_bench(
    folder: Path | Observed, rig: str | None = None
) -> list[RecordingReadings]:
    """Every recording under `folder`, or those of one rig, measured; one that could not
    be measured says why.

    FileNotFoundError without a folder.
    """
    observed = Observed.under(folder)
    return [
        _seen(entry, observed)
        for entry in observed.entries
        if rig is None or getattr(entry, "rig", rig) == rig
    ]


def hashes(folder: Path | Observed) -> dict[str, str]:
    """SHA-256 of every file under `folder` by its relative path."""
    folder = Path(folder)
    files = sorted(
        p
        for p in folder.rglob("*")
        if p.is_file() and not p.name.startswith(".") and not among_results(p, folder)
    )
    out = {}
    for file in files:
        with file.open("rb") as stream:
            out[str(file.relative_to(folder))] = hashlib.file_digest(
                stream, "sha256"
            ).hexdigest()
    return out


Name = tuple[str, str, str]  # recording, rig, response
Described = tuple[dict, str, str]  # sections, path, provenance


def _seen(entry: Recording | MeasurementError, observed: Observed) -> RecordingReadings:
    nothing = np.zeros(0)
    if isinstance(entry, MeasurementError):
        return RecordingReadings(
            entry.recording,
            "",
            "",
            nothing,
            nothing,
            0.0,
            {},
            "",
            "",
            trouble=str(entry),
        )
    told = (
        (entry.id, entry.rig, RESPONSES[entry.rig]) if entry.rig else (entry.id, "", "")
    )
    rest = (_description(entry), str(entry.path), entry.provenance)
    try:
        if entry.evidence == "readings.csv":
            return _readings(entry, observed, told, rest)
        return _measured(entry, observed, told, rest)
    except MeasurementError as error:
        return RecordingReadings(
            *told, nothing, nothing, 0.0, *rest, trouble=str(error)
        )
    except OSError as error:
        why = f"{error.filename or entry.path}: {error.strerror or error}"
        return RecordingReadings(*told, nothing, nothing, 0.0, *rest, trouble=why)


def _readings(
    entry: Recording, observed: Observed, told: Name, rest: Described
) -> RecordingReadings:
    """What somebody read off; the plausibility checks are those of `benchtwin
    measure`."""
    observation, table = observed.observe(entry), read_readings(entry.files[0]).rows
    rig = entry.rig or observation.rig
    response = RESPONSES[rig]
    if response not in table:
        raise MeasurementError(
            f"{entry.files[0]}: column {response} is missing; there are"
            f" {', '.join(table.columns)}"
        )
    values = table[response].dropna().to_numpy(dtype=float)
    doubt = next(
        (q.reason for q in observation.quantities if q.reason and len(values) > 1), ""
    )
    derived = {q.name: q.value for q in observation.quantities}
    further = {
        c: table[c].dropna().to_numpy(dtype=float) for c in FURTHER[rig] if c in table
    } | _weights(entry)
    nothing = np.zeros(values.size)
    return RecordingReadings(
        told[0],
        rig,
        response,
        values,
        nothing,
        0.0,
        *rest,
        notes=observation.notes,
        doubt=doubt,
        derived=derived,
        further=further,
    )


def _weights(entry: Recording) -> dict[str, np.ndarray]:
    """What recording.toml says was weighed."""
    if entry.rig is None:
        return {}
    section, names = getattr(entry, entry.rig), RIGS[entry.rig].weighed
    stated = {name: getattr(section, name) for name in names}
    return {
        name: np.array([value]) for name, value in stated.items() if value is not None
    }


def _measured(
    entry: Recording, observed: Observed, told: Name, rest: Described
) -> RecordingReadings:
    """One film, sound, track or photo: the quantity of its rig, once for each drop
    where it holds several."""
    observation = observed.observe(entry)
    name, unit = READING_COLUMNS[told[2]][1:]
    found = {q.name: q for q in observation.quantities}
    q = found.get(name)
    derived = {
        other.name: other.value
        for other in observation.quantities
        if other.quality != FAILED
    }
    if q is None or q.quality == FAILED or not np.isfinite(q.value):
        if q is not None:
            why = q.reason
        else:
            why = (
                f"no {name} without a scale; it gives {', '.join(derived) or 'nothing'}"
            )
        raise MeasurementError(f"{entry.path}: {why}")
    if q.unit != unit:
        raise MeasurementError(
            f"{entry.toml}: {name} came out in {q.unit}: [camera] mm_per_px is missing"
        )
    of_camera = {"mm": entry.camera.scale_sd * q.value, "deg": entry.camera.plumb_sd}
    shared = float(min(of_camera.get(unit, 0.0), q.sd))
    each = [
        one
        for repeat in observation.repeats or [observation.quantities]
        for one in repeat
        if one.name == name and one.quality != FAILED
    ]
    own = np.sqrt([max(one.sd**2 - min(shared, one.sd) ** 2, 0.0) for one in each])
    columns = {column: READING_COLUMNS[column][1] for column in FURTHER[told[1]]}
    further = {
        column: np.array([derived[n]]) for column, n in columns.items() if n in derived
    } | _weights(entry)
    return RecordingReadings(
        *told,
        np.array([one.value for one in each]),
        own,
        shared,
        *rest,
        notes=observation.notes,
        doubt=q.reason,
        derived=derived,
        further=further,
    )


def _description(entry: Recording) -> dict:
    """Sections of a recording.toml as plain values, those of the rig included."""
    names = (*SECTIONS, entry.rig) if entry.rig else SECTIONS
    sections = {
        name: getattr(entry, name).model_dump(exclude_none=True, mode="json")
        for name in names
    }
    return {name: values for name, values in sections.items() if values}
