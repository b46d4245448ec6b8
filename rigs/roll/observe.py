"""A recording of a roll, whatever its evidence → what is measured on it."""

from dataclasses import replace

import numpy as np

from benchtwin.bench.language import tr
from benchtwin.rigs.roll.measure import RunOut, measure_roll
from benchtwin.rigs.roll.roll_path import roll_path
from benchtwin.vision.measurement import MeasurementError, Observation
from benchtwin.vision.motion.of_recording import (
    Followed,
    Progress,
    seed_of,
)
from benchtwin.vision.motion.track import Track
from benchtwin.vision.overlay.plot import caption, plot_travel
from benchtwin.vision.overlay.track import on_picture
from benchtwin.vision.recording import Recording


def observe_roll(
    recording: Recording, options: object = None, progress: Progress | None = None
) -> Observation:
    """Run-out and rolling friction of a roll; quantities that cannot be measured are
    failed, with the reason. options: of piles, not used."""
    seen = seed_of(recording, progress)
    if isinstance(seen, Followed):
        return seen.doubted(_in_pictures(seen))
    roll = measure_roll(seen.track, recording)
    pictures = {"roll": _plot(seen.track, roll)}
    return seen.observation(roll.quantities, roll.notes, pictures)


def _in_pictures(seen: Followed) -> Observation:
    recording, tracked = seen.recording, seen.tracked
    if not np.isfinite(tracked.size):
        raise MeasurementError(
            tr(
                "{}: [seed] length_mm, width_mm and [camera] mm_per_px are needed where"
                " all places are set by hand: how high the seed's middle rolls",
                recording.toml,
            )
        )
    along = roll_path(tracked.track, tracked.size, recording)
    scale, corner = recording.camera.mm_per_px or 1.0, along.junction
    track = along.track.in_mm(recording.camera.mm_per_px)
    junction = None if corner is None else (corner[0] * scale, corner[1] * scale)
    roll = measure_roll(track, recording, junction=junction)
    if along.doubt:
        doubtful = tuple(q.doubt(along.doubt) for q in roll.quantities)
        roll = replace(roll, quantities=doubtful)
    low = seen.height_px - 1  # y counts up from the bottom row
    stop = None if roll.stop is None else roll.stop / scale
    picture = on_picture(
        tracked.scene.first,
        tracked.track.x,
        low - tracked.track.y,
        track.outlier,
        lines=[((a[0], low - a[1]), (b[0], low - b[1])) for a, b in along.legs],
        marks=[(column, low - y) for column, y in along.marks(stop)],
        caption=caption(roll.quantities),
    )
    pictures = {"track": picture, "roll": _plot(track, roll)}
    notes = (*along.notes, *roll.notes)
    return seen.observation(roll.quantities, notes, pictures, track)


def _plot(track: Track, roll: RunOut) -> np.ndarray:
    at, place = roll.stop_time, roll.junction
    return plot_travel(track, roll.fitted, at, roll.quantities, place)
