"""Tracks of drops as plain arrays: what a diagnosis is made from, read by the same code for bench and twin."""

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from calibrate.twin.run import observe
from vision.batch import find_all
from vision.evidence.tables import read_track
from vision.measurement import MeasurementError
from vision.motion.gravity import release_seen
from vision.motion.rebound import measure_rebound
from vision.motion.track import Track, track_from_table
from vision.recording import Recording


@dataclass(frozen=True, eq=False)
class SeenTrack:
    """One drop. Arrays of one length n; flight (n,): which flight a row belongs to, −1: none (held, in contact, an outlier).

    x_mm to the right, y_mm up, as the picture has them (not turned upright); angle_deg: anticlockwise, NaN where not seen, None
    where nobody looked; sd_mm: stated, NaN where not. contacts_s: impacts between successive flights. release_seen: whether the
    first flight begins in the track. description: sections of recording.toml as plain values, `camera.scale_sd` (relative) and
    `camera.plumb_sd_deg` with what holds where nothing is stated. trouble: why there is nothing, "" when there is.
    """

    recording: str
    session: str
    frame: np.ndarray
    time_s: np.ndarray
    x_mm: np.ndarray
    y_mm: np.ndarray
    sd_mm: np.ndarray
    angle_deg: np.ndarray | None
    flight: np.ndarray
    contacts_s: np.ndarray
    release_seen: bool
    description: dict
    notes: tuple[str, ...] = ()
    trouble: str = ""


def read_drops(folder: Path) -> list[SeenTrack]:
    """Every drop under `folder`; one that cannot be used says why. FileNotFoundError without a folder."""
    if not Path(folder).exists():
        raise FileNotFoundError(f"{folder}: no such file or folder")
    entries = find_all([Path(folder)])
    return [_seen(entry) for entry in entries if isinstance(entry, MeasurementError) or entry.rig == "drop"]


def _seen(entry: Recording | MeasurementError) -> SeenTrack:
    if isinstance(entry, MeasurementError):
        return _nothing(entry.recording, "", {}, str(entry))
    try:
        return drop_of(_track(entry), entry)
    except MeasurementError as error:
        return _nothing(entry.id, entry.session or "", describe(entry), str(error))


def _track(recording: Recording) -> Track:
    if recording.evidence == "track.csv":
        table = read_track(recording.files[0])
        return track_from_table(table.rows, recording.camera, table.notes)
    table = observe(recording).track
    if table is None:
        raise MeasurementError(f"{recording.path}: {recording.evidence} holds no track")
    return track_from_table(table, recording.camera)


def drop_of(track: Track, recording: Recording) -> SeenTrack:
    """A track with its flights told apart; MeasurementError where nothing flies, or scale or frame rate is unknown."""
    if track.unit != "mm" or not track.timed:
        missing = "scale (mm_per_px)" if track.unit != "mm" else "frame rate (fps)"
        raise MeasurementError(f"{recording.toml}: [camera] {missing} is missing; a diagnosis needs lengths and times")
    found = measure_rebound(track, recording)
    if found.flights is None:
        raise MeasurementError(found.quantities[0].reason)
    rows = np.flatnonzero(~track.outlier)
    flight = np.full(len(track), -1)
    for k, part in enumerate(found.flights.rows):
        flight[rows[part]] = k
    flight[found.track.outlier] = -1
    contacts = np.array([found.flights.meeting(k) for k in range(len(found.flights.rows) - 1)])
    return SeenTrack(
        recording.id, recording.session or "", track.frame, track.t_s, track.x, track.y, track.sd, track.angle_deg, flight,
        contacts, release_seen(found.flights, track), describe(recording), (*track.notes, *found.notes),
    )  # fmt: skip


def describe(recording: Recording) -> dict:
    """Sections of recording.toml as plain values; scale_sd (relative) and plumb_sd_deg are always there."""
    sections = {name: getattr(recording, name).model_dump(exclude_none=True) for name in ("seed", "camera", "air", "drop")}
    sections["camera"] |= {"scale_sd": recording.camera.scale_sd, "plumb_sd_deg": recording.camera.plumb_sd}
    return sections


def _nothing(recording: str, session: str, description: dict, trouble: str) -> SeenTrack:
    none = np.zeros(0)
    empty = SeenTrack(recording, session, none, none, none, none, none, None, none, none, False, description)
    return replace(empty, trouble=trouble)
