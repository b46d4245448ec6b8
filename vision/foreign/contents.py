"""What a file of another tool contains, whichever tool wrote it: tracks, impact times
or a plate's tilt."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from benchtwin.vision.evidence.sound import Sound
from benchtwin.vision.measurement import MeasurementError, require

LEAST_ROWS = 3
LARGEST = 1e9  # of a place or time, in any unit


@dataclass(frozen=True)
class PointTrack:
    """One tracked object: arrays of one length in the order of time, without NaN; x to
    the right, y up."""

    name: str
    time: np.ndarray
    x: np.ndarray
    y: np.ndarray


@dataclass(frozen=True)
class Contents:
    """Contents of a file of `tool`.

    tracks: in `length_unit` (mm or px) and `time_unit` (s or frame). runs: named series
    of impact times [s]. tilt: t_s and tilt_deg of a plate. waveform: sound. readings:
    heights that were read off, as readings.csv has them. keys: of
    recording.toml, {section: {key: value}}, that the file states. guesses: assumptions
    with reasons. questions: what the file leaves open. doubt: why its units cannot be
    right, or "". unitless: its lengths have no unit; they count as pixels. repeats:
    each track is a recording of its own. aside: something falls along x, with the
    acceleration of gravity in the units that the file states."""

    tool: str
    tracks: tuple[PointTrack, ...] = ()
    time_unit: str = "s"
    length_unit: str = "px"
    runs: tuple[tuple[str, np.ndarray], ...] = ()
    tilt: pd.DataFrame | None = None
    waveform: Sound | None = None
    readings: pd.DataFrame | None = None
    keys: dict[str, dict[str, Any]] = field(default_factory=dict)
    guesses: tuple[str, ...] = ()
    questions: tuple[str, ...] = ()
    doubt: str = ""
    unitless: bool = False
    repeats: bool = False
    aside: bool = False


def point_track(
    path: Path, name: str, time: np.ndarray, x: np.ndarray, y: np.ndarray
) -> PointTrack | None:
    """A track of the rows without NaN, sorted by time; None for fewer than LEAST_ROWS,
    an error for two places at one time."""
    rows = pd.DataFrame({"time": time, "x": x, "y": y}, dtype=float)
    rows = rows[np.isfinite(rows).all(axis=1)].drop_duplicates()
    rows = rows.sort_values("time", kind="stable")
    if len(rows) < LEAST_ROWS:
        return None
    which = name or "the track"
    require(
        rows.abs().to_numpy().max() <= LARGEST,
        f"{path}: {which} holds a place or time above {LARGEST:g}, which cannot be",
    )
    if len(twice := rows.time[rows.time.duplicated()]):
        at = f"the time {twice.iloc[0]:g}"
        raise MeasurementError(f"{path}: {which} has two places at {at}; keep one")
    return PointTrack(name, *rows.to_numpy().T)


def tracks_of(
    path: Path, listed: Iterable[tuple[str, Iterable[Sequence[float]]]]
) -> tuple[PointTrack, ...]:
    """The tracks of which name and rows (time, x, y) are listed, those of fewer than
    LEAST_ROWS left out; MeasurementError where none is left."""
    found = []
    for name, rows in listed:
        columns = np.array([*rows], float).reshape(-1, 3).T
        found.append(point_track(path, name, *columns))
    return require_tracks(path, found)


def numbered(
    number: np.ndarray, *columns: np.ndarray
) -> list[tuple[str, list[Sequence[float]]]]:
    """The rows of the columns (n,) by the number of their track (n,), with its name;
    those without a number left out."""
    rows = pd.DataFrame(np.column_stack(columns)).groupby(number)
    return [(f"track {n:g}", part.to_numpy().tolist()) for n, part in rows]


def require_tracks(
    path: Path, found: Sequence[PointTrack | None]
) -> tuple[PointTrack, ...]:
    """The tracks that are not None; MeasurementError where there are none."""
    tracks = tuple(t for t in found if t is not None)
    require(tracks, f"{path}: no track of {LEAST_ROWS} or more places")
    return tracks
