"""Which rig a recording shows, told by its evidence where nobody states it."""

from dataclasses import replace

import numpy as np
import pandas as pd

from benchtwin.bench.language import tr
from benchtwin.bench.rigs import READING_COLUMNS, RIGS, rigs_in_words
from benchtwin.vision.evidence.film_or_photos import film_or_photos
from benchtwin.vision.evidence.frames import open_frames
from benchtwin.vision.evidence.tables import read_readings
from benchtwin.vision.foreign.as_evidence import read_track
from benchtwin.vision.measurement import MeasurementError
from benchtwin.vision.recording import RIG_OF_KIND, Recording

LEAST_TILT_DEG = 3.0  # by which a plate turns while a block waits on it
WITHOUT_CAMERA = ("sound", "readings.csv")


def with_rig(recording: Recording) -> tuple[Recording, str]:
    """The recording with its rig, and a sentence on what told it and what is not known;
    "" where the rig is stated. MeasurementError, which names the command that goes on,
    where nothing tells it."""
    if recording.rig is not None:
        return recording, ""
    told = told_rig(recording)
    if told is None:
        raise MeasurementError(_which_rig(recording))
    rig, why = told
    known = replace(recording, rig=rig)
    missing = [
        f"[{section}] {key}"
        for section, key in RIGS[rig].wanted
        if getattr(getattr(known, section), key) is None
        and not (recording.evidence in WITHOUT_CAMERA and section == "camera")
    ]
    unknown = tr("; not stated: {}", ", ".join(missing)) if missing else ""
    return known, tr("taken for a {}: {}{}", rig, why, unknown)


def _which_rig(recording: Recording) -> str:
    """What to do where nothing tells the rig."""
    path, series = recording.path, ""
    if recording.evidence == "photos":
        judged = film_or_photos({p.name: p for p in recording.files})
        series = tr(
            ". Its pictures may be photos of piles, or one film: {}", judged.why
        )
    if path.is_dir():
        return tr(
            "{}: rig is missing, and nothing in the evidence tells it; it"
            " should be {}{}",
            recording.toml,
            rigs_in_words(),
            series,
        )
    return (
        f"{path}: rig is missing, and nothing in the evidence tells it; go on with:"
        f" benchtwin import {path} --rig roll --out my-bench (or drop, slide, pile)"
    )


def told_rig(recording: Recording) -> tuple[str, str] | None:
    """(rig, why) of a recording by its evidence; None where it tells none."""
    told = RIG_OF_KIND.get(recording.evidence)
    if told and (recording.evidence != "photos" or recording.rig is not None):
        return told  # without a rig, the pictures may be photos or a film's frames
    if recording.evidence == "readings.csv":
        columns = read_readings(recording.files[0]).rows.columns
        column = next(c for c in columns if c in READING_COLUMNS)
        return READING_COLUMNS[column][0], tr("readings of {}", column)
    if recording.evidence == "track.csv":
        return rig_of_rows(read_track(recording.files[0]).rows)
    if recording.evidence in ("frames", "video"):
        return _rig_of_film(recording)
    return None


def rig_of_rows(rows: pd.DataFrame) -> tuple[str, str] | None:
    """(rig, why) of a track by its rows, as those of track.csv; None where it is
    none's."""
    x, y = (rows.get(f"{axis}_mm", rows.get(f"{axis}_px")) for axis in "xy")
    time = rows["t_s"] if "t_s" in rows else rows["frame"]
    return rig_of_motion(*(np.asarray(c, float) for c in (time, x, y)))


def _rig_of_film(recording: Recording) -> tuple[str, str] | None:
    """A slide where a plate tilts, else by the path of what moves in the film."""
    from benchtwin.vision.motion.edge_line import track_edge
    from benchtwin.vision.motion.tilting_plate import LEAST_SEEN
    from benchtwin.vision.motion.track_seed import track_seed

    source = open_frames(recording)
    lines, *_ = track_edge(source)
    if lines and len(lines) >= LEAST_SEEN * source.count:
        turn = float(np.ptp(np.degrees([line.angle for line in lines.values()])))
        if turn > LEAST_TILT_DEG:
            return "slide", tr("a plate in the picture tilts by {:.0f}°", turn)
    for falling in (True, False):
        try:
            track = track_seed(open_frames(recording), falling=falling).track.used()
        except MeasurementError:
            continue  # nothing moves like that
        if told := rig_of_motion(track.time, track.x, track.y):
            return told
    return None


def rig_of_motion(
    time: np.ndarray, x: np.ndarray, y: np.ndarray
) -> tuple[str, str] | None:
    """(rig, why) of a track, y up, by the first rig in whose way it moves; None where
    it is none's."""
    moves = ((rig.name, rig.part("moves")) for rig in RIGS.values() if rig.moves)
    told = ((name, why) for name, of in moves if (why := of(time, x, y)))
    return next(told, None)
