"""Tracks and impact times as tables, whatever tool wrote the file, with keys for
recording.toml."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from benchtwin.vision.evidence.sound import Sound, read_sound
from benchtwin.vision.evidence.tables import Table, read_impacts_csv, read_track_csv
from benchtwin.vision.foreign import read_foreign, tool_of
from benchtwin.vision.foreign.contents import Contents, PointTrack
from benchtwin.vision.foreign.unit_inference import fits_gravity, free_fall
from benchtwin.vision.measurement import MeasurementError, require


@dataclass(frozen=True)
class Evidence:
    """kind: "track.csv", "impacts.csv" or "sound"; rig: "drop" where it can be nothing
    else, else ""; keys: that the file states."""

    kind: str
    rig: str
    keys: dict[str, dict[str, Any]]
    unitless: bool = False


def evidence_of(path: Path) -> Evidence:
    """The kind of evidence in the file; MeasurementError where it cannot be measured
    directly."""
    found = read_foreign(path)
    if found.runs:
        return Evidence("impacts.csv", "drop", found.keys)
    if found.waveform is not None:
        return Evidence("sound", "drop", found.keys)
    require(
        found.readings is None,
        f"{path}: heights that were read off: `benchtwin import` makes a"
        " readings.csv of them",
    )
    if found.tilt is not None:
        low, high = found.tilt["tilt_deg"].min(), found.tilt["tilt_deg"].max()
        raise MeasurementError(
            f"{path}: the angle of a plate ({low:.3g} to {high:.3g}°), and no motion:"
            f" {found.questions[0]}"
        )
    point_track, _ = choose_track(path, found, None)
    rig = "drop" if found.aside or falls_freely(found, point_track) else ""
    return Evidence("track.csv", rig, found.keys, found.unitless)


def read_track(path: Path) -> Table:
    """A track.csv as it is; a file of another tool converted to its columns, with notes
    on what was assumed."""
    if not tool_of(path):
        return read_track_csv(path)
    found = read_foreign(path)
    require(found.tracks, f"{path}: no track in it")
    require(not found.doubt, f"{path}: {found.doubt}")
    point_track, choice = choose_track(path, found, None)
    guesses = (f"taken to be so: {g}" for g in found.guesses)
    questions = (f"not known: {q}" for q in found.questions)
    return Table(track_rows(found, point_track), (*choice, *guesses, *questions))


def read_impacts(path: Path) -> Table:
    """An impacts.csv as it is; a file of another tool converted to its columns."""
    if not tool_of(path):
        return read_impacts_csv(path)
    runs = read_foreign(path).runs
    require(runs, f"{path}: no impact times in it")
    require(
        len(runs) <= 1,
        f"{path}: {len(runs)} runs of impact times in it: `benchtwin import` makes"
        " a recording of each",
    )
    return Table(impact_rows(path, *runs[0]))


def read_heard(path: Path) -> Sound:
    """The sound of a film or a sound file; a file of another tool converted to it."""
    if not tool_of(path):
        return read_sound(path)
    heard = read_foreign(path).waveform
    if heard is None:
        raise MeasurementError(f"{path}: no sound in it")
    return heard


def choose_track(
    path: Path, found: Contents, number: int | None
) -> tuple[PointTrack, tuple[str, ...]]:
    """The track of that number (from 1); without a number the longest that falls, or
    else the longest; and a note on the choice."""
    tracks = found.tracks
    require(
        number is None or 1 <= number <= len(tracks),
        f"{path}: --track {number}: it holds {len(tracks)}"
        f" track{'s' * (len(tracks) > 1)}",
    )
    if number is None and found.repeats:
        raise MeasurementError(
            f"{path}: {len(tracks)} repeats in it: `benchtwin import` makes a recording"
            " of each"
        )
    if number is not None or len(tracks) == 1:
        return tracks[(number or 1) - 1], ()
    falling = [t for t in tracks if falls_freely(found, t)]
    best = max(falling or tracks, key=lambda t: len(t.time))
    place = next(k for k, t in enumerate(tracks, 1) if t is best)
    which = "the longest that falls" if falling else "the longest; none falls"
    name = best.name or "without a name"
    return best, (f"{len(tracks)} tracks: number {place} ({name}) is taken, {which}",)


def falls_freely(found: Contents, point_track: PointTrack) -> bool:
    """Whether a track is a free fall: a parabola, downwards, with the acceleration of
    gravity where units are known."""
    fall = free_fall(point_track.time, point_track.x, point_track.y)
    if fall is None or fall.acceleration > 0:
        return False
    units_known = found.length_unit == "mm" and found.time_unit == "s"
    return not units_known or bool(found.doubt) or fits_gravity(fall.acceleration)


def track_rows(found: Contents, point_track: PointTrack) -> pd.DataFrame:
    """Rows of track.csv."""
    names = ("t_s" if found.time_unit == "s" else "frame", "x_{}", "y_{}")
    columns = (point_track.time, point_track.x, point_track.y)
    unit = found.length_unit
    return pd.DataFrame({n.format(unit): c for n, c in zip(names, columns)})


def impact_rows(path: Path, name: str, times: np.ndarray) -> pd.DataFrame:
    """Rows of impacts.csv."""
    if len(times) < 2 or not (np.diff(times) > 0).all():
        which = f"the impact times of {name}" if name else "its impact times"
        raise MeasurementError(
            f"{path}: {which} do not increase; they should, one after the other, two or"
            " more"
        )
    return pd.DataFrame({"t_s": times})
