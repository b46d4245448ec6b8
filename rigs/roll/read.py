"""Rolls as plain arrays: what a diagnosis is made from, read by the same code for bench
and twin."""

from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from benchtwin.bench.language import tr
from benchtwin.rigs.roll.inertia import inertia_of_recording
from benchtwin.rigs.roll.roll_path import stays_on_incline
from benchtwin.twin.pair import Curve
from benchtwin.twin.seen import Observed, no_rows, sections_of, seen_of, track_of
from benchtwin.vision.evidence.tables import read_readings
from benchtwin.vision.measurement import MeasurementError
from benchtwin.vision.motion.track import Track
from benchtwin.vision.recording import Recording

LEAST_ROWS = 4  # place, speed and acceleration, and one more by which they are checked
FEW_ROWS = 30  # of fewer, a wrong one cannot be told by its neighbours
# of the way, by which noise may put a row of a seed that rests behind the one before
BACK_SHARE = 0.03
BACK_AND_FORTH = (
    f"of fewer than {FEW_ROWS} rows each must lie further along the path than the one"
    " before"
)


@dataclass(frozen=True, eq=False)
class SeenRoll:
    """One seed that rolls down the incline and out. Arrays of one length n, outliers
    left out; empty where only the run-out was read off: run_out_mm holds the readings
    then.

    x_mm: travel along the path, incline included, growing as the seed rolls, either
    way; angle_deg: anticlockwise in the picture, NaN where not seen, None where nobody
    looked. description: sections of recording.toml as plain values, `camera.scale_sd`
    (relative) with what holds where nothing is stated; of a track `roll.seen_direction`
    ("+x", "-x") and `roll.ends_on_incline`. trouble: why there is nothing, "" when
    there is. sd_mm: stated, NaN where not. gates: the rows are passages of light gates,
    whose places are alike in all runs; what is uncertain of a row is its time."""

    recording: str
    session: str
    frame: np.ndarray = field(default_factory=no_rows)
    time_s: np.ndarray = field(default_factory=no_rows)
    x_mm: np.ndarray = field(default_factory=no_rows)
    angle_deg: np.ndarray | None = None
    description: dict = field(default_factory=dict)
    run_out_mm: np.ndarray = field(default_factory=no_rows)
    notes: tuple[str, ...] = ()
    trouble: str = ""
    sd_mm: np.ndarray = field(default_factory=no_rows)
    gates: bool = False


def read_rolls(folder: Path | Observed) -> list[SeenRoll]:
    """Every roll under `folder`; one that cannot be used says why. FileNotFoundError
    without a folder."""
    return list(seen_of(folder, "roll", SeenRoll, _seen, describe))


def _seen(entry: Recording, observed: Observed) -> list[SeenRoll]:
    if entry.evidence == "readings.csv":
        return [_readings(entry)]
    return [roll_of(track_of(entry, observed), entry)]


def _readings(recording: Recording) -> SeenRoll:
    table = read_readings(recording.files[0])
    if "run_out_mm" not in table.rows:
        raise MeasurementError(tr("{}: no column run_out_mm", recording.files[0]))
    return SeenRoll(
        recording.id,
        recording.session or "",
        description=describe(recording),
        run_out_mm=table.rows["run_out_mm"].dropna().to_numpy(float),
        notes=table.notes,
    )


def roll_of(track: Track, recording: Recording) -> SeenRoll:
    """A track as a diagnosis takes it; MeasurementError where scale, frame rate or
    motion is missing.

    A track that runs towards −x in the picture is turned round, the angle with it, so
    that a seed that rolls turns clockwise."""
    if track.unit != "mm" or not track.timed:
        missing = "mm_per_px" if track.unit != "mm" else "fps"
        raise MeasurementError(
            tr(
                "{}: [camera] {} is missing; a diagnosis needs lengths and times",
                recording.toml,
                missing,
            )
        )
    inertia_of_recording(recording)  # a gap that the ball falls through is told now
    used = track.used()
    if len(used) < LEAST_ROWS:
        raise MeasurementError(
            tr(
                "{} usable rows; a diagnosis of a roll needs at least {}",
                len(used),
                LEAST_ROWS,
            )
        )
    if not (np.isfinite(used.x).all() and np.isfinite(used.t_s).all()):
        raise MeasurementError(tr("x_mm or t_s holds rows without a number"))
    ends = max(1 if len(used) < FEW_ROWS else 3, len(used) // 50)
    way = float(np.median(used.x[-ends:]) - np.median(used.x[:ends]))
    if abs(way) < 2.0:
        raise MeasurementError(
            tr("the seed does not roll: it moves {:.3g} mm in all", abs(way))
        )
    forwards = np.diff(used.x) / way
    if len(used) < FEW_ROWS and (forwards < -BACK_SHARE).any():
        raise MeasurementError(
            tr(
                "{} usable rows, and x_mm goes back and forth; {}",
                len(used),
                tr(BACK_AND_FORTH),
            )
        )
    return seen_roll(track, recording, stays_on_incline(used, recording))


def seen_roll(track: Track, recording: Recording, stays: bool) -> SeenRoll:
    """A track in millimetres and seconds as it is; stays: on its incline."""
    used = track.used()
    ends = max(1 if len(used) < FEW_ROWS else 3, len(used) // 50)
    way = float(np.median(used.x[-ends:]) - np.median(used.x[:ends]))
    told, sign = describe(recording), 1.0 if way > 0 else -1.0
    told["roll"].setdefault("seen_direction", "+x" if way > 0 else "-x")
    told["roll"]["ends_on_incline"] = stays
    angle = None if used.angle_deg is None else sign * used.angle_deg
    return SeenRoll(
        recording.id,
        recording.session or "",
        used.frame,
        used.t_s,
        sign * used.x,
        angle,
        told,
        notes=tuple(track.notes),
        sd_mm=used.sd,
        gates=recording.evidence == "gates.csv",
    )


def describe(recording: Recording) -> dict:
    """Sections of recording.toml as plain values; camera.scale_sd (relative) is always
    there."""
    sections = sections_of(recording, "seed", "camera", "air", "roll")
    sections["camera"] |= {"scale_sd": recording.scale_sd}
    return sections


def curve(roll: SeenRoll, *, relative: bool, timed: bool) -> Curve:
    """Way over time."""
    if not len(roll.x_mm):
        raise MeasurementError(
            tr("{}: a run-out that was read off shows no curve", roll.recording)
        )
    start = np.median(roll.x_mm[: max(1, min(5, len(roll.x_mm) // 6))])
    way = roll.x_mm - start
    return Curve("time (s)", "way (mm)", roll.time_s, way, frame=roll.frame)
