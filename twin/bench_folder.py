"""A bench folder as a calibration sees it: what was read on each recording, and what
the recordings state of the rig."""

import hashlib
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from benchtwin.bench.rigs import READING_COLUMNS, RIGS
from benchtwin.measure.observed import Observed as Observed
from benchtwin.vision.evidence.readings import rows_alike
from benchtwin.vision.evidence.tables import read_numbers as read_numbers
from benchtwin.vision.evidence.tables import read_readings
from benchtwin.vision.measurement import FAILED, MeasurementError, Observation
from benchtwin.vision.recording import Recording
from benchtwin.vision.recording import among_results as among_results

# what each rig is read for: its first column; further ones go beside it
RESPONSES = {rig: column for column, (rig, *_) in reversed(READING_COLUMNS.items())}
FURTHER = {
    rig: [c for c, (r, *_) in READING_COLUMNS.items() if r == rig and c != main]
    for rig, main in RESPONSES.items()
}
SECTIONS = ("seed", "camera", "air")


def no_readings() -> np.ndarray:
    """What a recording holds of what was not read."""
    return np.zeros(0)


@dataclass(frozen=True, eq=False)
class RecordingReadings:
    """One recording.

    response: the column its readings belong to (`rebound_height_mm` …); readings: (n,)
    in its unit, one for a film or photo, one a drop of several; reading_sd: (n,)
    measuring error that is each reading's own, 0 where none is known; shared_sd: error
    that all recordings of the session share (scale, plumb line); description: what
    recording.toml and bench.toml state, by section; trouble: why nothing could be read,
    "" when something was; doubt: why it is to be trusted less; further: other readings
    of the same piles, by column."""

    recording: str
    rig: str = ""
    response: str = ""
    description: dict = field(default_factory=dict)
    path: str = ""
    provenance: str = ""
    readings: np.ndarray = field(default_factory=no_readings)
    reading_sd: np.ndarray = field(default_factory=no_readings)
    shared_sd: float = 0.0
    notes: tuple[str, ...] = ()
    doubt: str = ""
    trouble: str = ""
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


def _seen(entry: Recording | MeasurementError, observed: Observed) -> RecordingReadings:
    if isinstance(entry, MeasurementError):
        return RecordingReadings(entry.recording, trouble=str(entry))
    rig, stated = entry.rig or "", (str(entry.path), entry.provenance)
    plain = RecordingReadings(
        entry.id, rig, RESPONSES.get(rig, ""), _description(entry), *stated
    )
    read = _readings if entry.evidence == "readings.csv" else _measured
    try:
        return read(entry, plain, observed.observe(entry))
    except MeasurementError as error:
        return replace(plain, trouble=str(error))
    except OSError as error:
        why = f"{error.filename or entry.path}: {error.strerror or error}"
        return replace(plain, trouble=why)


def _readings(
    entry: Recording, plain: RecordingReadings, seen: Observation
) -> RecordingReadings:
    """What somebody read off; the plausibility checks are those of `benchtwin
    measure`."""
    read_off, rig = read_readings(entry.files[0]), entry.rig or seen.rig
    told, table = rows_alike(entry, rig, read_off)[0]
    if len(table) < len(read_off.rows):
        stated = ", ".join(c for c in RIGS[rig].by_row if c in table)
        raise MeasurementError(
            f"{entry.files[0]}: its rows state several {stated}; a calibration takes"
            " one a recording: write a folder for each"
        )
    if (response := RESPONSES[rig]) not in table:
        raise MeasurementError(
            f"{entry.files[0]}: column {response} is missing; there are"
            f" {', '.join(table.columns)}"
        )
    columns = [response, *(c for c in FURTHER[rig] if c in table)]
    read = {c: table[c].dropna().to_numpy(dtype=float) for c in columns}
    values = read.pop(response)
    several = seen.quantities if len(values) > 1 else ()
    return replace(
        plain,
        rig=rig,
        response=response,
        description=_description(told),
        readings=values,
        reading_sd=np.zeros(values.size),
        notes=seen.notes,
        doubt=next((q.reason for q in several if q.reason), ""),
        further=read | _weights(entry),
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
    entry: Recording, plain: RecordingReadings, seen: Observation
) -> RecordingReadings:
    """One film, sound, track or photo: the quantity of its rig, once for each drop
    where it holds several."""
    name, unit = READING_COLUMNS[plain.response][1:]
    q = next((q for q in seen.quantities if q.name == name), None)
    derived = {o.name: o.value for o in seen.quantities if o.quality != FAILED}
    if q is None or q.quality == FAILED or not np.isfinite(q.value):
        gives = ", ".join(derived) or "nothing"
        why = q.reason if q else f"no {name} without a scale; it gives {gives}"
        raise MeasurementError(f"{entry.path}: {why}")
    if q.unit != unit:
        raise MeasurementError(
            f"{entry.toml}: {name} came out in {q.unit}: [camera] mm_per_px is missing"
        )
    of_camera = {"mm": entry.camera.scale_sd * q.value, "deg": entry.camera.plumb_sd}
    shared = float(min(of_camera.get(unit, 0.0), q.sd))
    repeats = [one for many in seen.repeats or [seen.quantities] for one in many]
    each = [one for one in repeats if one.name == name and one.quality != FAILED]
    own = [max(one.sd**2 - min(shared, one.sd) ** 2, 0.0) for one in each]
    columns = {column: READING_COLUMNS[column][1] for column in FURTHER[plain.rig]}
    further = {c: np.array([derived[n]]) for c, n in columns.items() if n in derived}
    return replace(
        plain,
        readings=np.array([one.value for one in each]),
        reading_sd=np.sqrt(own),
        shared_sd=shared,
        notes=seen.notes,
        doubt=q.reason,
        further=further | _weights(entry),
    )


def _description(entry: Recording) -> dict:
    """Sections of a recording.toml as plain values, those of the rig included."""
    names = (*SECTIONS, entry.rig) if entry.rig else SECTIONS
    sections = {
        name: getattr(entry, name).model_dump(exclude_none=True, mode="json")
        for name in names
    }
    return {name: values for name, values in sections.items() if values}
