"""The recordings in a file of another tool as tables, whatever tool wrote it."""

from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import pandas as pd

from benchtwin.vision.evidence.sound import Sound, read_sound
from benchtwin.vision.evidence.tables import Table, read_impacts_csv, read_track_csv
from benchtwin.vision.foreign import read_foreign, tool_of
from benchtwin.vision.foreign.contents import Contents, PointTrack
from benchtwin.vision.foreign.unit_inference import fits_gravity
from benchtwin.vision.measurement import MeasurementError, require


@dataclass(frozen=True)
class Evidence:
    """One recording in a file. kind: "track.csv", "impacts.csv", "tilt.csv",
    "readings.csv" or "sound"; rig, why: that of which it is, "" where it is not told;
    rows: of the table of that kind, none of a sound; number: from 1, 0 where it is the
    only one; notes: on which of several it is."""

    found: Contents
    kind: str
    rig: str = ""
    why: str = ""
    rows: pd.DataFrame = field(default_factory=pd.DataFrame)
    number: int = 0
    notes: tuple[str, ...] = ()


def evidence_in(path: Path, number: int | None = None) -> list[Evidence]:
    """The recordings in a file of another tool, or the one of that number (from 1).
    Several tracks are one recording, of which one is taken, unless they are repeats:
    the longest that falls, or else the longest."""
    found = read_foreign(path)
    for kind, rig, why, held in (
        ("tilt.csv", "slide", "a plate tilts", found.tilt),
        ("readings.csv", "drop", "heights of rebounds were read off", found.readings),
        ("sound", "drop", "impacts were heard", found.waveform),
    ):
        if held is not None:
            rows = pd.DataFrame() if isinstance(held, Sound) else held
            return [Evidence(found, kind, rig, why, rows)]
    count = len(found.runs or found.tracks)
    several = "runs of impact times" if found.runs else f"track{'s' * (count > 1)}"
    require(
        number is None or 1 <= number <= count,
        f"{path}: --track {number}: it holds {count} {several}",
    )
    if found.runs:
        heard = enumerate(found.runs, 1)
        return [_run(path, found, *one) for one in heard if number in (None, one[0])]
    if found.repeats:
        numbers = [number] if number else range(1, count + 1)
        return [
            _track(found, k, f"repeat {k} of {count}: {found.tracks[k - 1].name}")
            for k in numbers
        ]
    return [_track(found, number, "") if number else _likeliest(found)]


def evidence_of(path: Path) -> Evidence:
    """The one recording in the file; MeasurementError where it cannot be measured
    directly."""
    one, *others = evidence_in(path)
    require(
        one.kind != "readings.csv",
        f"{path}: heights that were read off: `benchtwin import` makes a"
        " readings.csv of them",
    )
    if (tilt := one.found.tilt) is not None:
        low, high = tilt["tilt_deg"].min(), tilt["tilt_deg"].max()
        raise MeasurementError(
            f"{path}: the angle of a plate ({low:.3g} to {high:.3g}°), and no motion:"
            f" {one.found.questions[0]}"
        )
    several = "repeats" if one.found.repeats else "runs of impact times"
    require(
        not others,
        f"{path}: {1 + len(others)} {several} in it: `benchtwin import` makes a"
        " recording of each",
    )
    return one


def read_track(path: Path) -> Table:
    """A track.csv as it is; a file of another tool converted to its columns, with notes
    on what was assumed."""
    if not tool_of(path):
        return read_track_csv(path)
    one = evidence_of(path)
    require(one.kind == "track.csv", f"{path}: no track in it")
    require(not one.found.doubt, f"{path}: {one.found.doubt}")
    guesses = (f"taken to be so: {g}" for g in one.found.guesses)
    questions = (f"not known: {q}" for q in one.found.questions)
    return Table(one.rows, (*one.notes, *guesses, *questions))


def read_impacts(path: Path) -> Table:
    """An impacts.csv as it is; a file of another tool converted to its columns."""
    if not tool_of(path):
        return read_impacts_csv(path)
    one = evidence_of(path)
    require(one.kind == "impacts.csv", f"{path}: no impact times in it")
    return Table(one.rows)


def read_heard(path: Path) -> Sound:
    """The sound of a film or a sound file; a file of another tool converted to it."""
    if not tool_of(path):
        return read_sound(path)
    heard = read_foreign(path).waveform
    if heard is None:
        raise MeasurementError(f"{path}: no sound in it")
    return heard


def falls_freely(found: Contents, point_track: PointTrack) -> bool:
    """Whether a track is a free fall: a parabola, downwards, with the acceleration of
    gravity where units are known."""
    known = found.length_unit == "mm" and found.time_unit == "s" and not found.doubt
    fall = point_track.acceleration
    return fall < 0 and (not known or fits_gravity(fall))


def _likeliest(found: Contents) -> Evidence:
    """Of several tracks the longest that falls, or else the longest."""
    tracks, note = found.tracks, ""
    falling = [t for t in tracks if falls_freely(found, t)]
    best = max(falling or tracks, key=lambda t: len(t.time))
    number = next(k for k, t in enumerate(tracks, 1) if t is best)
    if len(tracks) > 1:
        which = "the longest that falls" if falling else "the longest; none falls"
        name = best.name or "without a name"
        note = f"{len(tracks)} tracks: number {number} ({name}) is taken, {which}"
    return _track(found, number, note)


def _track(found: Contents, number: int, note: str) -> Evidence:
    """A track as rows of track.csv."""
    one, unit = found.tracks[number - 1], found.length_unit
    why = "it falls freely" if falls_freely(found, one) else ""
    if found.aside and not why:
        why = "it falls freely, along x"
    clock = "t_s" if found.time_unit == "s" else "frame"
    rows = pd.DataFrame({clock: one.time, f"x_{unit}": one.x, f"y_{unit}": one.y})
    notes = (note.rstrip(": "),) if note else ()
    number = number if found.repeats else 0
    return Evidence(found, "track.csv", "drop" * bool(why), why, rows, number, notes)


def _run(
    path: Path, found: Contents, number: int, run: tuple[str, np.ndarray]
) -> Evidence:
    """Impact times as rows of impacts.csv."""
    (name, times), count = run, len(found.runs)
    if len(times) < 2 or not (np.diff(times) > 0).all():
        which = f"the impact times of {name}" if name else "its impact times"
        raise MeasurementError(
            f"{path}: {which} do not increase; they should, one after the other, two or"
            " more"
        )
    notes = (f"run {number} of {count}: {name}",) if name else ()
    rows, number = pd.DataFrame({"t_s": times}), number if count > 1 else 0
    why = "impacts were heard"
    return Evidence(found, "impacts.csv", "drop", why, rows, number, notes)
