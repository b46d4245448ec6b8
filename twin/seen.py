"""What was seen of the recordings of a bench, as plain arrays for a diagnosis: bench
and twin are read by the same code, in each rig's `read.py`."""

import math
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TypeVar

import numpy as np

from benchtwin.bench.rigs import RIGS, rigs_in_words
from benchtwin.measure.observed import Observed as Observed
from benchtwin.vision.foreign.as_evidence import read_track
from benchtwin.vision.measurement import MeasurementError
from benchtwin.vision.motion.of_recording import TABLES, table_track
from benchtwin.vision.motion.track import Track, track_from_table
from benchtwin.vision.recording import Recording as Recording

Seen = TypeVar("Seen")


def no_rows() -> np.ndarray:
    """What a recording holds of what was not seen."""
    return np.zeros(0)


@dataclass(frozen=True)
class Listed:
    """One recording of a folder before anything is read of it: trouble says why nothing
    can be, aside why nothing is, "" when it is."""

    recording: str
    rig: str
    evidence: str
    session: str
    trouble: str = ""
    notes: tuple[str, ...] = ()
    aside: str = ""


def listed(folder: Path | Observed) -> list[Listed]:
    """What a folder holds. FileNotFoundError without one."""
    observed = Observed.under(folder)
    return [_entry(entry, observed.told) for entry in observed.entries]


def _entry(entry: Recording | MeasurementError, told: Mapping[str, str]) -> Listed:
    if isinstance(entry, MeasurementError):
        return Listed(entry.recording, "", "", "", str(entry))
    missing = f"{entry.toml}: rig is missing; it should be {rigs_in_words()}"
    trouble = "" if entry.rig else missing
    return Listed(
        entry.id,
        entry.rig or "",
        entry.evidence,
        entry.session or "",
        trouble,
        (*filter(None, [told.get(entry.id, "")]), *entry.sds_beyond_belief()),
        not_diagnosed(entry),
    )


def not_diagnosed(recording: Recording) -> str:
    """Why a diagnosis leaves out a rig that is built as this one; ""."""
    if recording.rig is None:
        return ""
    return RIGS[recording.rig].not_diagnosed.get(recording.variant, "")


def entries_of(folder: Path | Observed, rig: str) -> Observed:
    """Recordings of one rig under `folder` that a diagnosis judges, and what could not
    be read at all. FileNotFoundError without a folder."""
    observed = Observed.under(folder)
    return observed.only(
        entry
        for entry in observed.entries
        if isinstance(entry, MeasurementError)
        or (entry.rig == rig and not not_diagnosed(entry))
    )


def seen_of(
    folder: Path | Observed,
    rig: str,
    kind: Callable[..., Seen],
    read: Callable[[Recording, Observed], Iterable[Seen]],
    describe: Callable[[Recording], dict],
) -> Iterator[Seen]:
    """What `read` gives of every recording of a rig under `folder`; in the place of one
    that cannot be used, a `kind` that says why. FileNotFoundError without a folder."""
    found = entries_of(folder, rig)
    for entry in found.entries:
        if isinstance(entry, MeasurementError):
            yield kind(entry.recording, "", trouble=str(entry))
            continue
        try:
            yield from read(entry, found)
        except MeasurementError as error:
            told, session = describe(entry), entry.session or ""
            yield kind(entry.id, session, description=told, trouble=str(error))


def track_of(recording: Recording, observed: Observed) -> Track:
    """A recording's track, read from its table or as it was observed on its frames."""
    if recording.evidence in TABLES:
        return table_track(recording)
    table = observed.observe(recording).track
    if table is None:
        raise MeasurementError(f"{recording.path}: {recording.evidence} holds no track")
    return track_from_table(table, recording.camera)


def stated_by(
    recordings: Iterable[Recording],
    section: str,
    key: str,
    absent: float,
    overruled_by: str = "",
) -> tuple[float, ...]:
    """The numbers that recordings state by a key, each once; absent: what stands for it
    where it is not stated; NaN too where a table holds the column beside which the key
    counts for nothing."""
    told = set()
    for recording in recordings:
        value = getattr(getattr(recording, section), key)
        overruled = overruled_by and _holds(recording, overruled_by)
        told.add(math.nan if overruled else absent if value is None else value)
    return tuple(sorted(told))


def _holds(recording: Recording, column: str) -> bool:
    """Whether a recording is a table with that column, in millimetres or seconds."""
    if recording.evidence != "track.csv":
        return recording.evidence.endswith(".csv")
    return column in read_track(recording.files[0]).rows


def sections_of(recording: Recording, *names: str) -> dict:
    """Those sections of recording.toml, with [reading] and [conditions], as plain
    values: {section: {key: value}}."""
    sections = {
        name: getattr(recording, name).model_dump(exclude_none=True)
        for name in (*names, "reading")
    }
    return sections | {"conditions": dict(recording.conditions)}
