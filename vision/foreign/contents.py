"""What a file of another tool contains, whichever tool wrote it: tracks, impact times
or a plate's tilt."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from benchtwin.vision.evidence.sound import Sound
from benchtwin.vision.measurement import MeasurementError, require

LEAST_ROWS = 3
# name and rows (time, x, y) of each track
Listed = Sequence[tuple[str, np.ndarray | Sequence[Sequence[float]]]]
LARGEST = 1e9  # of a place or time, in any unit


@dataclass(frozen=True)
class PointTrack:
    """One tracked object: arrays of one length in the order of time, without NaN; x to
    the right, y up. acceleration: along y, in its free flight, in its units; NaN where
    it has none."""

    name: str
    time: np.ndarray
    x: np.ndarray
    y: np.ndarray
    acceleration: float = math.nan


@dataclass(frozen=True)
class Asked:
    """A question, and the keys that answer it: "[seed] length_mm, width_mm", "rig" at
    the file's top, "" for no key."""

    words: str
    answer: str = ""

    def __str__(self) -> str:
        return ": ".join(filter(None, (self.answer, self.words)))

    @property
    def section(self) -> str:
        return self.answer.rpartition("] ")[0].lstrip("[")

    @property
    def keys(self) -> list[str]:
        return [key for key in self.answer.rpartition("] ")[2].split(", ") if key]

    def beside(self, stated: Mapping[str, Mapping[str, Any]]) -> "Asked | None":
        """Of the keys that are not stated; None where all are."""
        rest = [k for k in self.keys if k not in stated.get(self.section, {})]
        answer = self.answer.replace(", ".join(self.keys), ", ".join(rest))
        return Asked(self.words, answer) if rest or not self.keys else None


@dataclass(frozen=True)
class Tracked:
    """Tracks as a file holds them: name and rows (time, x, y) of each; their units, of
    TIME or FRAMES and of LENGTH or PIXELS, and whether y is "up" or "down", each ""
    where the file does not state it. The rest as in Contents."""

    listed: Listed
    time_unit: str = ""
    length_unit: str = ""
    up: str = ""
    keys: dict[str, dict[str, Any]] = field(default_factory=dict)
    guesses: Sequence[str] = ()
    questions: Sequence[Asked] = ()
    repeats: bool = False


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
    questions: tuple[Asked, ...] = ()
    doubt: str = ""
    unitless: bool = False
    repeats: bool = False
    aside: bool = False


def tracks_of(path: Path, listed: Listed) -> tuple[PointTrack, ...]:
    """The tracks of which name and rows (time, x, y) are listed, those of fewer than
    LEAST_ROWS left out; MeasurementError where none is left."""
    found = []
    for name, each in listed:
        rows = pd.DataFrame(np.asarray(each, float).reshape(-1, 3))
        rows = rows[np.isfinite(rows).all(axis=1)].drop_duplicates()
        rows = rows.sort_values(0, kind="stable")
        if len(rows) < LEAST_ROWS:
            continue
        which = f"{path}: {name or 'the track'}"
        require(
            rows.abs().to_numpy().max() <= LARGEST,
            f"{which} holds a place or time above {LARGEST:g}, which cannot be",
        )
        if len(twice := rows[0][rows[0].duplicated()]):
            at = f"the time {twice.iloc[0]:g}"
            raise MeasurementError(f"{which} has two places at {at}; keep one")
        found.append(PointTrack(name, *rows.to_numpy().T))
    require(found, f"{path}: no track of {LEAST_ROWS} or more places")
    return tuple(found)


def numbered(
    number: np.ndarray, *columns: np.ndarray
) -> list[tuple[str, list[Sequence[float]]]]:
    """The rows of the columns (n,) by the number of their track (n,), with its name;
    those without a number left out."""
    rows = pd.DataFrame(np.column_stack(columns)).groupby(number)
    return [(f"track {n:g}", part.to_numpy().tolist()) for n, part in rows]
