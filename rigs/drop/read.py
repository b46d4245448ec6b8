"""Tracks of drops as plain arrays: what a diagnosis is made from, read by the same code
for bench and twin."""

import math
from contextlib import suppress
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from benchtwin.bench.air import air_of, drag_of_hops, hop_s
from benchtwin.bench.constants import G_MM_S2
from benchtwin.bench.language import tr
from benchtwin.bench.priors import unstated_sd
from benchtwin.twin.pair import Curve
from benchtwin.twin.seen import Observed, no_rows, sections_of, seen_of, track_of
from benchtwin.vision.evidence.readings import rows_alike
from benchtwin.vision.evidence.tables import read_readings
from benchtwin.vision.foreign.as_evidence import read_impacts
from benchtwin.vision.foreign.unit_inference import free_falls
from benchtwin.vision.measurement import MeasurementError
from benchtwin.vision.motion.down import upright
from benchtwin.vision.motion.drop_sound import impacts_in_sound, sound_of
from benchtwin.vision.motion.flight import (
    FEW_ROWS,
    Flights,
    find_few_flights,
    find_flights,
)
from benchtwin.vision.motion.impact_chain import estimate_time_sds
from benchtwin.vision.motion.several_drops import drop_rows
from benchtwin.vision.motion.track import Track
from benchtwin.vision.recording import Recording

# of a scale that only the fall itself gives: gravity is then no judge of it any more
SCALE_OF_GRAVITY_SD = 0.1
# factors by which films are slowed: 60 to 1000 frames per second, shown at 24 to 60
SLOWED = (1, 2, 2.5, 4, 5, 8, 10, 16, 20, 32, 40)
DRAG_OF_TIMES = 0.03  # relative, of an acceleration by what air takes
SURE_SDS = 3.0
READING = "rebound_height_mm"
# key of how well one fall by itself gives a scale, relative
FALL_SD = "scale_of_fall_sd"
LEAST_FALL_SD = 1e-5
UPWARDS = 0.3  # of the worth of falls, that of parabolas which open upwards in a drop


@dataclass(frozen=True, eq=False)
class SeenTrack:
    """One drop. Arrays of one length n; flight (n,): which flight a row belongs to, −1:
    none (held, in contact, an outlier).

    x_mm to the right, y_mm up, as the picture has them (not turned upright); angle_deg:
    anticlockwise, NaN where not seen, None where nobody looked. sd_mm: stated, NaN
    where not; weight: 1 over the rows' relative sd; late: in which share of
    the camera's readout they were read, empty where that does not count, and
    readout_sd_s: sd of that readout. contacts_s: impacts between
    successive flights. release_seen: whether the first flight begins in the track. Of a
    drop that was only heard there are no rows,
    only contacts_s with contacts_sd_s. description: sections of recording.toml as plain
    values, `camera.scale_sd` (relative) and `camera.plumb_sd_deg` with what holds where
    nothing is stated. trouble: why there is nothing, "" when there is."""

    recording: str
    session: str
    frame: np.ndarray = field(default_factory=no_rows)
    time_s: np.ndarray = field(default_factory=no_rows)
    x_mm: np.ndarray = field(default_factory=no_rows)
    y_mm: np.ndarray = field(default_factory=no_rows)
    sd_mm: np.ndarray = field(default_factory=no_rows)
    weight: np.ndarray = field(default_factory=no_rows)
    late: np.ndarray = field(default_factory=no_rows)
    angle_deg: np.ndarray | None = None
    flight: np.ndarray = field(default_factory=no_rows)
    contacts_s: np.ndarray = field(default_factory=no_rows)
    release_seen: bool = False
    description: dict = field(default_factory=dict)
    notes: tuple[str, ...] = ()
    trouble: str = ""
    contacts_sd_s: np.ndarray = field(default_factory=no_rows)
    readout_sd_s: float = 0.0


def falls(time: np.ndarray, x: np.ndarray, y: np.ndarray) -> str:
    """Why a motion, y up, is a drop's; "" where it is none's."""
    found = free_falls(time, x, y)
    down, up = (
        max((f.worth for f in found if f.acceleration * sign > 0), default=0.0)
        for sign in (-1, 1)
    )
    free = down > 0 and up < UPWARDS * down and np.ptp(y) > np.ptp(x) / 2
    return tr("it falls freely") if free else ""


def read_drops(folder: Path | Observed) -> list[SeenTrack]:
    """Every drop under `folder`, several of a recording that holds several; one that
    cannot be used says why. FileNotFoundError without a folder."""
    return one_scale(list(seen_of(folder, "drop", SeenTrack, _seen, describe)))


def one_scale(seen: list[SeenTrack]) -> list[SeenTrack]:
    """The same with one scale a session where only the falls give it: their mean,
    weighted by how well each gives it."""
    out = list(seen)
    for session in dict.fromkeys(s.session for s in seen):
        mine = [
            k
            for k, s in enumerate(seen)
            if s.session == session and FALL_SD in s.description.get("camera", {})
        ]
        if len(mine) < 2:
            continue
        cameras = [seen[k].description["camera"] for k in mine]
        scale = float(
            np.average(
                [c["mm_per_px"] for c in cameras],
                weights=[c[FALL_SD] ** -2 for c in cameras],
            )
        )
        for k, camera in zip(mine, cameras, strict=True):
            s, times = seen[k], scale / camera["mm_per_px"]
            told = s.description | {"camera": camera | {"mm_per_px": scale}}
            out[k] = replace(
                s,
                x_mm=times * s.x_mm,
                y_mm=times * s.y_mm,
                sd_mm=times * s.sd_mm,
                description=told,
            )
    return out


def _seen(entry: Recording, observed: Observed) -> list[SeenTrack]:
    if entry.evidence in ("impacts.csv", "sound"):
        return heard_of(entry)
    if entry.evidence == "readings.csv":
        return readings_of(entry)
    try:
        return drops_of(track_of(entry, observed), entry)
    except MeasurementError as error:
        if sound_of(entry) is None:
            raise
        return _heard_instead(entry, str(error))


def _heard_instead(entry: Recording, trouble: str) -> list[SeenTrack]:
    """Filmed drops in which nothing could be followed, by their sound."""
    try:
        heard = heard_of(entry)
    except MeasurementError as error:
        raise MeasurementError(f"{trouble}; {error}") from error
    alone = tr("from its sound alone: {}", trouble)
    return [replace(one, notes=(*one.notes, alone)) for one in heard]


def heard_of(recording: Recording) -> list[SeenTrack]:
    """The drops of a recording that were only heard: no rows, the times of their
    impacts; where there are several, each has its number in its name."""
    told = SeenTrack(
        recording.id, recording.session or "", description=describe(recording)
    )
    if recording.evidence == "impacts.csv":
        table = read_impacts(recording.files[0])
        times, sd = table.rows["t_s"].to_numpy(float), table.rows.get("sd_s")
        sd = estimate_time_sds(times) if sd is None else sd.to_numpy(float)
        return [replace(told, contacts_s=times, contacts_sd_s=sd, notes=table.notes)]
    file = sound_of(recording)
    if file is None:
        raise MeasurementError(tr("{}: holds no sound", recording.path))
    found = impacts_in_sound(file, recording)
    heard = []
    for drop in found.drops:
        description = describe(recording)
        if not drop.first:  # the height leads to an impact that was not heard
            description["drop"].pop("height_mm", None)
        heard.append(
            replace(
                told,
                contacts_s=drop.times,
                contacts_sd_s=drop.sd,
                notes=found.notes,
                description=description,
            )
        )
    return _numbered(heard)


def readings_of(recording: Recording) -> list[SeenTrack]:
    """Heights of rebound that somebody read off, a drop each: two impacts, as long
    apart as such a rebound lasts. MeasurementError where there are none."""
    table = read_readings(recording.files[0])
    if READING not in table.rows:
        raise MeasurementError(tr("{}: no column {}", recording.files[0], READING))
    parts = rows_alike(recording, "drop", table)
    if not any(told.drop.height_mm for told, _ in parts):
        missing = tr(
            "[drop] height_mm is missing; a rebound by itself tells no restitution"
        )
        raise MeasurementError(f"{recording.toml}: {missing}")
    seen = [
        _read_off(told, float(height_mm), table.notes)
        for told, rows in parts
        for height_mm in rows[READING].dropna()
        if told.drop.height_mm and height_mm > 0
    ]
    if not seen:
        raise MeasurementError(tr("{}: no rebound rose", recording.files[0]))
    return _numbered(seen)


def _read_off(
    recording: Recording, height_mm: float, notes: tuple[str, ...]
) -> SeenTrack:
    """A drop whose rebound was read off as height_mm."""
    told = describe(recording)
    drag, _ = drag_of_hops(air_of(told), recording.drop.height_mm / 1000)
    lasts = float(hop_s(np.array(height_mm / 1000), drag))
    sd_s = unstated_sd("row-of-few") / math.sqrt(G_MM_S2 * height_mm)
    return SeenTrack(
        recording.id,
        recording.session or "",
        contacts_s=np.array([0.0, lasts]),
        contacts_sd_s=np.full(2, sd_s),
        description=told,
        notes=notes,
    )


def _numbered(drops: list[SeenTrack]) -> list[SeenTrack]:
    """The drops of one recording, each with its number in its name where there are
    several."""
    if len(drops) < 2:
        return drops
    return [
        replace(drop, recording=f"{drop.recording}/{number}")
        for number, drop in enumerate(drops, 1)
    ]


def as_it_fell(
    track: Track, recording: Recording
) -> tuple[Track, Recording, tuple[str, ...]]:
    """A track in the time in which it was taken, its recording with the direction of
    the fall, and notes on both."""
    track, slowed = _at_speed(track, recording)
    recording, said = upright(track, recording)
    return track, recording, (*slowed, *said)


def _at_speed(track: Track, recording: Recording) -> tuple[Track, tuple[str, ...]]:
    """The track of a film whose rate is not stated, where the acceleration of its falls
    is that of a usual slow motion; and a note."""
    if recording.evidence != "video" or recording.camera.fps or not track.physical:
        return track, ()
    seen, _ = upright(track, recording)
    try:
        falls = flights_of(track, seen)
    except MeasurementError:
        return track, ()
    if not falls.free > 0:
        return track, ()
    times = math.sqrt(G_MM_S2 / falls.free)
    known = (DRAG_OF_TIMES, recording.scale_sd, falls.free_sd / falls.free)
    near = min(SLOWED, key=lambda k: abs(math.log(times / k)))
    if near == 1 or abs(times / near - 1) > SURE_SDS * math.hypot(*known) / 2:
        return track, ()
    shown = float(np.median(np.diff(track.frame) / np.diff(track.t_s)))
    note = tr(
        "[camera] fps is not stated; by gravity the film plays {:g} × slower than it"
        " was taken: at {:.4g} frames per second",
        near,
        near * shown,
    )
    return replace(track, t_s=track.t_s / near), (note,)


def drops_of(track: Track, recording: Recording) -> list[SeenTrack]:
    """The drops of a track in which the seed is let go several times; the whole as one
    where fewer than two parts of it can be used. Raises as `drop_of`."""
    track, recording, said = as_it_fell(track, recording)
    track = replace(track, notes=(*track.notes, *said))
    track, readout_sd_s = _read_out(track, recording)
    parts, seen = drop_rows(track, recording), []
    for rows in parts if len(parts) > 1 else []:
        with suppress(MeasurementError):
            seen.append(drop_of(track.take(rows), recording))
    seen = [one for one in seen if len(one.contacts_s)]
    seen = seen if len(seen) > 1 else [drop_of(track, recording)]
    return _numbered([replace(one, readout_sd_s=readout_sd_s) for one in seen])


def _read_out(track: Track, recording: Recording) -> tuple[Track, float]:
    """A track with the times at which a rolling shutter read its rows, and the sd [s]
    of the readout. Not stated it is any up to a frame; stated it is known, whatever
    that of other films of its session."""
    readout = recording.camera.readout_s
    if track.late is None or not track.timed:
        return track, 0.0
    if readout is not None:
        return replace(track.read_out(readout), late=None), 0.0
    return track.read_out(track.step / 2), track.step / math.sqrt(12)


def drop_of(track: Track, recording: Recording) -> SeenTrack:
    """A track with its flights told apart; MeasurementError where nothing flies, or the
    frame rate is unknown.

    Where no scale is stated the free fall gives it, and the scale is taken for known no
    better than SCALE_OF_GRAVITY_SD; of several drops see `one_scale`."""
    if not track.timed:
        raise MeasurementError(
            tr(
                "{}: [camera] fps is missing; a diagnosis needs to know how fast things"
                " fell",
                recording.toml,
            )
        )
    found, notes, camera, scale = flights_of(track, recording), track.notes, {}, 1.0
    if track.unit == "px":
        if not found.free > 0:
            raise MeasurementError(
                tr(
                    "{}: [camera] mm_per_px is missing, and nothing in the track falls"
                    " freely",
                    recording.toml,
                )
            )
        scale = G_MM_S2 / found.free
        alone = max(found.free_sd / found.free, LEAST_FALL_SD)
        camera = {"scale_sd": SCALE_OF_GRAVITY_SD, FALL_SD: alone}
        notes = (
            *notes,
            (
                tr(
                    "no scale is stated: the free fall makes it {:.4g} mm per px, and"
                    " nothing is said about scale",
                    scale,
                )
            ),
        )
    seen = flown(track, recording, found, scale)
    seen.description["camera"] |= camera
    return replace(seen, notes=notes)


def flights_of(track: Track, recording: Recording) -> Flights:
    """The flights among a track's rows that are no outliers."""
    used = track.used()
    if len(used) < 4:
        raise MeasurementError(
            tr("{} usable frames; a flight needs at least 4", len(used))
        )
    up, across = used.upright(recording.camera.plumb_deg)
    if not np.ptp(up):
        raise MeasurementError(tr("nothing falls in it: its height never changes"))
    gates = recording.evidence == "gates.csv"
    gravity = G_MM_S2 if used.physical else None
    if gates or len(used) < FEW_ROWS:
        return find_few_flights(used.time, up, used.sd, gravity, gates=gates)
    return find_flights(used.time, used.frame, up, across, used.sd, gravity)


def flown(
    track: Track,
    recording: Recording,
    found: Flights,
    mm: float = 1.0,
    seconds: float = 1.0,
) -> SeenTrack:
    """A track with its flights; mm, seconds: in a unit of its lengths and times."""
    rows = np.flatnonzero(~track.outlier)
    flight, weight = np.full(len(track), -1), np.ones(len(track))
    for k, part in enumerate(found.rows):
        flight[rows[part]] = k
    flight[rows[found.outlier]] = -1
    weight[rows] = found.weight
    told = describe(recording)
    if track.unit == "px":
        told["camera"]["mm_per_px"] = mm
    return SeenTrack(
        recording.id,
        recording.session or "",
        track.frame,
        seconds * track.time,
        mm * track.x,
        mm * track.y,
        mm * track.sd,
        weight,
        no_rows() if track.late is None else track.late,
        track.angle_deg,
        flight,
        seconds * np.array(found.contacts()),
        found.release_seen(),
        told,
    )


def describe(recording: Recording) -> dict:
    """Sections of recording.toml as plain values; scale_sd (relative) and plumb_sd_deg
    are always there."""
    sections = sections_of(recording, "seed", "camera", "air", "drop")
    sections["camera"] |= {
        "scale_sd": recording.scale_sd,
        "plumb_sd_deg": recording.camera.plumb_sd,
    }
    return sections


def curve(drop: SeenTrack, *, relative: bool, timed: bool) -> Curve:
    """Height over time."""
    flies = drop.flight >= 0
    if not flies.any():
        raise MeasurementError(tr("{}: no flight was seen", drop.recording))
    height, time = drop.y_mm[flies], drop.time_s[flies]
    height = height - np.nanmin(height)
    return Curve("time (s)", "height (mm)", time, height, frame=drop.frame[flies])
