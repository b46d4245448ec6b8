"""Measures a drop from any evidence: track, light gates, impact times, frames, video
or sound."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from benchtwin.bench.language import tr
from benchtwin.rigs.drop.heard import measure_impacts
from benchtwin.rigs.drop.measure import QUANTITIES, Rebound, measure_drop
from benchtwin.rigs.drop.on_seeds import observe_on_seeds
from benchtwin.rigs.drop.read import as_it_fell
from benchtwin.rigs.drop.with_sound import combine_with_sound, observe_sound
from benchtwin.vision.foreign.as_evidence import read_impacts
from benchtwin.vision.foreign.unit_inference import free_falls, unit_doubt
from benchtwin.vision.measurement import MeasurementError, Observation, all_failed
from benchtwin.vision.motion.drop_sound import sound_of
from benchtwin.vision.motion.of_recording import (
    TABLES,
    Progress,
    follow_seed,
    need_track,
    observation,
    table_track,
)
from benchtwin.vision.motion.several_drops import drop_rows, over_drops
from benchtwin.vision.motion.track import Track
from benchtwin.vision.motion.track_seed import TrackedSeed
from benchtwin.vision.overlay.plot import caption, plot
from benchtwin.vision.overlay.track import on_picture
from benchtwin.vision.recording import Recording

_SHARE = np.linspace(0, 1, 60)  # of a flight


def observe_drop(
    recording: Recording,
    options: object = None,
    progress: Progress | None = None,
) -> Observation:
    """Measure a drop of any evidence; quantities that cannot be measured are failed,
    with the reason. options: of piles, not used."""
    if recording.drop.plate:
        return observe_on_seeds(recording, progress)
    if recording.evidence == "impacts.csv":
        return _observe_impacts(recording)
    if recording.evidence == "sound":
        return observe_sound(recording, recording.files[0])
    need_track(recording)
    if recording.evidence in TABLES:
        track = table_track(recording)
        if recording.evidence == "track.csv":
            _check_units(track, recording)
        return _observe_track(recording, track)
    file = sound_of(recording)
    if file is None:
        return _observe_frames(recording, progress)
    try:
        seen = _observe_frames(recording, progress)
    except MeasurementError as error:
        seen = Observation(recording.id, "drop", all_failed(QUANTITIES, str(error)))
        both = combine_with_sound(seen, recording, file)
        if both.bounces is None:
            raise MeasurementError(f"{error}; {both.notes[-1]}") from error
        return both
    return combine_with_sound(seen, recording, file)


def _check_units(track: Track, recording: Recording) -> None:
    """MeasurementError where the acceleration of a drop contradicts the units of its
    columns."""
    if not track.physical:
        return
    falls = free_falls(track.time, track.x, track.y)
    if doubt := unit_doubt(
        falls, 1.0, 1.0, bool((track.time == np.round(track.time)).all())
    ):
        raise MeasurementError(tr("{}: t_s, x_mm, y_mm: {}", recording.files[0], doubt))


def _observe_impacts(recording: Recording) -> Observation:
    table = read_impacts(recording.files[0])
    sd = table.rows["sd_s"].to_numpy() if "sd_s" in table.rows else None
    quantities, bounces, notes = measure_impacts(
        table.rows["t_s"].to_numpy(), sd, recording
    )
    time, high = bounces.t_s.to_numpy(), bounces.height_mm.to_numpy()
    gap = np.append(np.diff(time), table.rows["t_s"].iloc[-1] - time[-1])
    arcs = [
        (t + g * _SHARE, 4 * h * _SHARE * (1 - _SHARE))
        for t, g, h in zip(time, gap, high)
    ]
    picture = plot(
        time + gap / 2,
        high,
        np.zeros(len(high)),
        labels=("t [s]", "height [mm]"),
        curves=arcs,
        caption=recording.id,
    )
    return Observation(
        recording.id,
        "drop",
        quantities,
        (*table.notes, *notes),
        {"intervals": picture},
        None,
        bounces,
    )


def _observe_track(recording: Recording, track: Track) -> Observation:
    track, recording, said = as_it_fell(track, recording)
    drops = _measure_drops(
        track, recording, lambda rows: measure_drop(track.take(rows), recording)
    )
    return _of_drops(recording, drops, track, said)


def _observe_frames(recording: Recording, progress: Progress | None) -> Observation:
    seen = follow_seed(recording, progress, falling=True)
    found = _drop_in_frames(seen.recording, seen.tracked, list(seen.notes))
    return seen.doubted(seen.with_places(found))


def _drop_in_frames(
    recording: Recording, tracked: TrackedSeed, notes: list[str]
) -> Observation:
    share = 1 - tracked.track.y / max(tracked.scene.shape[0] - 1, 1)
    camera = recording.camera
    seen = replace(tracked.track, late=share).in_mm(camera.mm_per_px)
    seen, recording, said = as_it_fell(seen, recording)
    high, wide = tracked.scene.shape
    axis = (
        (wide - 1) / 2 * (camera.mm_per_px or 1.0),
        (high - 1) / 2 * (camera.mm_per_px or 1.0),
    )
    drops = _measure_drops(
        seen,
        recording,
        lambda rows: measure_drop(seen.take(rows), recording, axis),
    )
    found = _of_drops(recording, drops, seen, [*notes, *said])
    picture = _draw_drop(tracked, drops, recording, caption(found.quantities))
    return replace(found, pictures={"track": picture, **found.pictures})


@dataclass(frozen=True)
class _Drop:
    """One drop of a track: its rows, and what was measured."""

    rows: slice
    result: Rebound


def _measure_drops(
    track: Track,
    recording: Recording,
    measure: Callable[[slice], Rebound],
) -> list[_Drop]:
    """Each drop of a track, measured by its rows; the whole as one drop where fewer
    than two parts of it bounce."""
    parts = drop_rows(track, recording)
    drops = [_Drop(rows, measure(rows)) for rows in parts] if len(parts) > 1 else []
    drops = [drop for drop in drops if drop.result.bounces is not None]
    whole = slice(0, len(track))
    return drops if len(drops) > 1 else [_Drop(whole, measure(whole))]


def _of_drops(
    recording: Recording, drops: list[_Drop], track: Track, notes: Sequence[str]
) -> Observation:
    """The observation of one drop, or of several with their means, with its plot."""
    each = [
        observation(
            recording,
            drop.result.quantities,
            [*track.notes, *notes, *drop.result.notes],
            {},
            drop.result.track,
            drop.result.bounces,
        )
        for drop in drops
    ]
    found = each[0] if len(each) == 1 else over_drops(each)
    used = _as_used(track, drops)
    said = caption(found.quantities)
    picture = _plot_flights(drops, _as_read(used, drops), recording, said)
    return replace(found, pictures={"flights": picture}, track=used.to_table())


def _as_used(track: Track, drops: list[_Drop]) -> Track:
    """The whole track with the outliers that the drops were measured with; what is of
    none of them is an outlier."""
    outlier = np.ones(len(track), bool)
    for drop in drops:
        outlier[drop.rows] = drop.result.track.outlier
    return replace(track, outlier=outlier)


def _as_read(track: Track, drops: list[_Drop]) -> Track:
    """The same with the times at which its rows were read."""
    t_s = track.t_s.copy()
    for drop in drops:
        own = track.take(drop.rows).read_out(drop.result.readout_s)
        t_s[drop.rows] = own.t_s
    return replace(track, t_s=t_s)


def _plot_flights(
    drops: list[_Drop], track: Track, recording: Recording, caption: str
) -> np.ndarray:
    up, _ = track.upright(recording.camera.plumb_deg)
    curves = [[(t, h) for t, h, _ in drop.result.curves] for drop in drops]
    labels = (f"t [{track.time_unit}]", f"height [{track.unit}]")
    return plot(
        track.time,
        up,
        track.outlier,
        labels=labels,
        curves=[curve for one in curves for curve in one],
        marks=[(t[0], h[0]) for one in curves for t, h in one[1:]],
        caption=caption,
    )


def _draw_drop(
    tracked: TrackedSeed, drops: list[_Drop], recording: Recording, caption: str
) -> np.ndarray:
    """Places and fitted flights on the first frame, with the plate's line below the
    seed at contact."""
    track, height = tracked.track, tracked.scene.shape[0]
    scale = recording.camera.mm_per_px or 1.0
    turn = np.radians(recording.camera.plumb_deg or 0.0)
    curves, marks = [], []
    for drop in drops:
        for number, (_, h, side) in enumerate(drop.result.curves):
            x = (h * np.sin(turn) + side * np.cos(turn)) / scale
            y = height - 1 - (h * np.cos(turn) - side * np.sin(turn)) / scale
            curves.append((x, y))
            if number:
                marks.append((x[0], y[0]))
    lines = []
    if marks and np.isfinite(tracked.size):
        along = np.array([np.cos(turn), np.sin(turn)])
        below = np.array(marks[0]) + tracked.size / 2 * np.array([-along[1], along[0]])
        wide = 3 * tracked.size * along
        lines = [(tuple(below - wide), tuple(below + wide))]
    return on_picture(
        tracked.scene.first,
        track.x,
        height - 1 - track.y,
        _as_used(track, drops).outlier,
        curves=curves,
        marks=marks,
        lines=lines,
        caption=caption,
    )
