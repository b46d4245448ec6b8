"""A file of another tool as evidence: the same table as track.csv or impacts.csv, and what the recording must know beside it."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from vision.evidence.tables import Table
from vision.foreign import read_foreign
from vision.foreign.fall import fits_gravity, free_fall
from vision.foreign.found import Found, Trail
from vision.measurement import MeasurementError


@dataclass(frozen=True)
class Evidence:
    """kind: "track.csv" or "impacts.csv", of which the file is one. rig: "drop" where it can be nothing else, else "". keys: of
    recording.toml, that the file states. bare: its lengths have no unit at all."""

    kind: str
    rig: str
    keys: dict[str, dict[str, Any]]
    bare: bool = False


def evidence_of(path: Path) -> Evidence:
    """What kind of evidence the file is; MeasurementError where it is none that can be measured as it is."""
    found = read_foreign(path)
    if found.runs:
        return Evidence("impacts.csv", "drop", found.keys)
    if found.tilt is not None:
        low, high = found.tilt["tilt_deg"].min(), found.tilt["tilt_deg"].max()
        raise MeasurementError(f"{path}: the angle of a plate ({low:.3g} to {high:.3g}°), and no motion: {found.questions[0]}")
    trail, _ = chosen(path, found, None)
    return Evidence("track.csv", "drop" if falls(found, trail) else "", found.keys, found.bare)


def foreign_track(path: Path) -> Table:
    """The rows of track.csv that the file comes down to, with what was assumed in the notes."""
    found = read_foreign(path)
    if not found.trails:
        raise MeasurementError(f"{path}: no track in it")
    if found.doubt:
        raise MeasurementError(f"{path}: {found.doubt}")
    trail, said = chosen(path, found, None)
    guesses, questions = (f"taken to be so: {g}" for g in found.guesses), (f"not known: {q}" for q in found.questions)
    return Table(track_rows(found, trail), (*said, *guesses, *questions))


def foreign_impacts(path: Path) -> Table:
    """The rows of impacts.csv that the file comes down to."""
    runs = read_foreign(path).runs
    if len(runs) != 1:
        said = f"{len(runs)} runs of impact times in it: `benchtwin import` makes a recording of each" if runs else "no impact times in it"
        raise MeasurementError(f"{path}: {said}")
    return Table(impact_rows(path, *runs[0]))


def chosen(path: Path, found: Found, number: int | None) -> tuple[Trail, tuple[str, ...]]:
    """The track of that number (from 1), or the one with the most places among those that fall, else among all; and a word on it."""
    tracks = found.trails
    if number is not None and not 1 <= number <= len(tracks):
        raise MeasurementError(f"{path}: --track {number}: it holds {len(tracks)} track{'s' * (len(tracks) > 1)}")
    if number is not None or len(tracks) == 1:
        return tracks[(number or 1) - 1], ()
    falling = [t for t in tracks if falls(found, t)]
    best = max(falling or tracks, key=lambda t: len(t.time))
    place = next(k for k, t in enumerate(tracks, 1) if t is best)
    which = "the longest that falls" if falling else "the longest; none falls"
    return best, (f"{len(tracks)} tracks: number {place} ({best.name or 'without a name'}) is taken, {which}",)


def falls(found: Found, trail: Trail) -> bool:
    """Whether it falls freely: along a parabola, downwards, and as gravity wants it where units are known."""
    fall = free_fall(trail.time, trail.x, trail.y)
    if fall is None or fall.acceleration > 0:
        return False
    units_known = found.length_unit == "mm" and found.time_unit == "s"
    return not units_known or bool(found.doubt) or fits_gravity(fall.acceleration)


def track_rows(found: Found, trail: Trail) -> pd.DataFrame:
    """Rows of track.csv."""
    time = {"t_s": trail.time} if found.time_unit == "s" else {"frame": trail.time}
    return pd.DataFrame(time | {f"x_{found.length_unit}": trail.x, f"y_{found.length_unit}": trail.y})


def impact_rows(path: Path, name: str, times: np.ndarray) -> pd.DataFrame:
    """Rows of impacts.csv."""
    if len(times) < 2 or not (np.diff(times) > 0).all():
        which = f"the impact times of {name}" if name else "its impact times"
        raise MeasurementError(f"{path}: {which} do not increase; they should, one after the other, two or more")
    return pd.DataFrame({"t_s": times})
