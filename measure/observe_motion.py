"""Measures a drop, slide or roll from any evidence: track, light gates, impact times,
frames, video or sound."""

import itertools
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pandas as pd
from benchtwin.rigs.slide import RIG as SLIDE
from benchtwin.vision.evidence.frames import open_frames
from benchtwin.vision.foreign.as_evidence import read_impacts, read_track
from benchtwin.vision.foreign.unit_inference import free_falls, unit_doubt
from benchtwin.vision.measurement import (
    DOUBTFUL,
    GOOD,
    MeasurementError,
    Observation,
    Quantity,
    all_failed,
)
from benchtwin.vision.motion.drop_sound import (
    combine_with_sound,
    observe_sound,
    sound_of,
)
from benchtwin.vision.motion.film_doubts import camera_moved, size_doubt, stated_area_px
from benchtwin.vision.motion.impacts import measure_impacts
from benchtwin.vision.motion.places import places_of
from benchtwin.vision.motion.rebound import (
    QUANTITIES,
    Rebound,
    gravity_axes,
    measure_rebound,
)
from benchtwin.vision.motion.roll import measure_roll
from benchtwin.vision.motion.roll_path import roll_path
from benchtwin.vision.motion.rolling_shutter import average_over_readouts
from benchtwin.vision.motion.tilting_plate import PlateOverlay, track_slide
from benchtwin.vision.motion.track import Track, track_from_gates, track_from_table
from benchtwin.vision.motion.track_seed import TrackedSeed, track_seed
from benchtwin.vision.overlay.plot import plot
from benchtwin.vision.overlay.track import on_picture
from benchtwin.vision.recording import Recording, with_camera

MOVING_RIGS = ("drop", "slide", "roll")
_SHARE = np.linspace(0, 1, 60)  # of a flight


def observe_moving(
    recording: Recording, progress: Callable[[float], None] | None = None
) -> Observation:
    """Measure a drop, slide or roll of any evidence; quantities that cannot be measured
    are failed, with the reason."""
    if recording.rig not in MOVING_RIGS:
        raise MeasurementError(
            f"{recording.toml}: rig = {recording.rig!r} does not move; expected one of"
            f" {', '.join(MOVING_RIGS)}"
        )
    if recording.evidence == "impacts.csv":
        return _observe_impacts(recording)
    if recording.evidence == "track.csv":
        table = read_track(recording.files[0])
        track = _corrected(
            track_from_table(table.rows, recording.camera, table.notes), recording
        )
        _check_units(track, recording)
        return _observe_track(recording, track)
    if recording.evidence == "gates.csv":
        return _observe_track(recording, track_from_gates(recording))
    if recording.evidence == "sound":
        return observe_sound(recording, recording.files[0])
    if recording.evidence not in ("frames", "video"):
        raise MeasurementError(
            f"{recording.path}: {recording.evidence} of a {recording.rig} cannot be"
            " followed; frames, a video or track.csv can"
        )
    file = sound_of(recording) if recording.rig == "drop" else None
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
    if recording.rig != "drop" or not track.physical:
        return
    falls = free_falls(track.time, track.x, track.y)
    if doubt := unit_doubt(
        falls, 1.0, 1.0, bool((track.time == np.round(track.time)).all())
    ):
        raise MeasurementError(f"{recording.files[0]}: t_s, x_mm, y_mm: {doubt}")


def _observe_impacts(recording: Recording) -> Observation:
    if recording.rig != "drop":
        raise MeasurementError(
            f"{recording.files[0]}: impact times belong to a drop, not to a"
            f" {recording.rig}"
        )
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
    if recording.rig == "drop":
        result = measure_rebound(track, recording)
        pictures = {"flights": _plot_flights(result, recording)}
        return _observation(
            recording,
            result.quantities,
            (*track.notes, *result.notes),
            pictures,
            result.track,
            result.bounces,
        )
    if recording.rig == "slide":
        slide = SLIDE.part("measure")(track, recording)
        pictures = {
            "slide": _plot_travel(track, slide.fitted, slide.onset, slide.quantities)
        }
        return _observation(
            recording, slide.quantities, (*track.notes, *slide.notes), pictures, track
        )
    roll = measure_roll(track, recording)
    pictures = {
        "roll": _plot_travel(
            track, roll.fitted, roll.stop_time, roll.quantities, roll.junction
        )
    }
    return _observation(
        recording, roll.quantities, (*track.notes, *roll.notes), pictures, track
    )


def _observe_frames(recording: Recording, progress) -> Observation:
    source = open_frames(recording)
    if recording.rig == "slide":
        tracked, plate = track_slide(source, recording, progress)
    else:
        area = stated_area_px(recording)
        tracked = track_seed(
            source,
            falling=recording.rig == "drop",
            progress=progress,
            at=recording.track.follow_px,
            area_px=area,
            places=places_of(recording.track),
            only_places=bool(recording.track.only_places),
        )
    tracked = replace(tracked, track=_corrected(tracked.track, recording))
    recording, notes = _with_scale(recording, tracked)
    notes = [*source.notes, *notes]
    x, y = (
        plate.places
        if recording.rig == "slide"
        else (tracked.track.x, tracked.scene.shape[0] - 1 - tracked.track.y)
    )
    places = pd.DataFrame(
        {
            "frame": tracked.track.frame,
            "x_px": x,
            "y_px": y,
            "left_out": tracked.track.outlier,
        }
    )
    if recording.rig == "slide":
        return replace(
            _slide_in_frames(recording, tracked, plate, notes), places=places
        )
    measure = _drop_in_frames if recording.rig == "drop" else _roll_in_frames
    found = _doubted(measure(recording, tracked, notes), size_doubt(tracked, recording))
    return replace(_doubted(found, camera_moved(source)), places=places)


def _corrected(track: Track, recording: Recording) -> Track:
    """The track with the frames marked as outliers that [track] left_out_frames
    names."""
    struck = recording.track.left_out_frames
    return track.marked(np.isin(track.frame, struck)) if struck else track


def _doubted(found: Observation, doubt: str) -> Observation:
    """The observation with one doubt added to every quantity and bounce; unchanged
    where the doubt is empty."""
    if not doubt:
        return found
    bounces = (
        found.bounces
        if found.bounces is None
        else found.bounces.assign(quality=DOUBTFUL)
    )
    return replace(
        found,
        quantities=tuple(q.doubt(doubt) for q in found.quantities),
        bounces=bounces,
    )


def _drop_in_frames(
    recording: Recording, tracked: TrackedSeed, notes: list[str]
) -> Observation:
    share = 1 - tracked.track.y / max(tracked.scene.shape[0] - 1, 1)
    seen, camera = to_mm(tracked.track, recording.camera.mm_per_px), recording.camera
    high, wide = tracked.scene.shape
    axis = (
        (wide - 1) / 2 * (camera.mm_per_px or 1.0),
        (high - 1) / 2 * (camera.mm_per_px or 1.0),
    )
    result, note = average_over_readouts(
        seen,
        share,
        camera.readout_s,
        camera.fps,
        lambda track: measure_rebound(track, recording, axis),
    )
    notes = [*notes, note] if note else notes
    pictures = {
        "track": _draw_drop(tracked, result, recording),
        "flights": _plot_flights(result, recording),
    }
    notes = [*tracked.track.notes, *notes, *result.notes]
    return _observation(
        recording, result.quantities, notes, pictures, result.track, result.bounces
    )


def _slide_in_frames(
    recording: Recording, tracked: TrackedSeed, plate: PlateOverlay, notes: list[str]
) -> Observation:
    track = to_mm(tracked.track, recording.camera.mm_per_px)
    slide = SLIDE.part("measure")(track, recording)
    caption = _caption(slide.quantities)
    pictures = {
        "track": on_picture(
            plate.picture,
            *plate.places,
            track.outlier,
            lines=plate.lines,
            caption=caption,
        ),
        "slide": _plot_travel(track, slide.fitted, slide.onset, slide.quantities),
    }
    return _observation(
        recording,
        slide.quantities,
        [*track.notes, *notes, *slide.notes],
        pictures,
        track,
    )


def _roll_in_frames(
    recording: Recording, tracked: TrackedSeed, notes: list[str]
) -> Observation:
    if not np.isfinite(tracked.size):
        raise MeasurementError(
            f"{recording.toml}: [seed] length_mm, width_mm and [camera] mm_per_px are"
            " needed where all places are set by hand: how high the seed's middle rolls"
        )
    along = roll_path(tracked.track, tracked.size, recording)
    scale = recording.camera.mm_per_px or 1.0
    track = to_mm(along.track, recording.camera.mm_per_px)
    junction = (
        None
        if along.junction is None
        else (along.junction[0] * scale, along.junction[1] * scale)
    )
    roll = measure_roll(track, recording, junction=junction)
    if along.doubt:
        roll = replace(
            roll, quantities=tuple(q.doubt(along.doubt) for q in roll.quantities)
        )
    low = tracked.scene.shape[0] - 1  # y counts up from the bottom row
    marks = [
        (c, low - y)
        for c, y in along.marks(None if roll.stop is None else roll.stop / scale)
    ]
    legs = [((a[0], low - a[1]), (b[0], low - b[1])) for a, b in along.legs]
    x, y = tracked.track.x, low - tracked.track.y
    pictures = {
        "track": on_picture(
            tracked.scene.first,
            x,
            y,
            track.outlier,
            lines=legs,
            marks=marks,
            caption=_caption(roll.quantities),
        ),
        "roll": _plot_travel(
            track, roll.fitted, roll.stop_time, roll.quantities, roll.junction
        ),
    }
    return _observation(
        recording,
        roll.quantities,
        [*track.notes, *notes, *along.notes, *roll.notes],
        pictures,
        track,
    )


def to_mm(track: Track, mm_per_px: float | None) -> Track:
    """The track in millimetres where the scale is known; else unchanged."""
    if track.unit == "mm" or not mm_per_px:
        return track
    return replace(
        track,
        x=track.x * mm_per_px,
        y=track.y * mm_per_px,
        sd=track.sd * mm_per_px,
        unit="mm",
    )


def _with_scale(
    recording: Recording, tracked: TrackedSeed
) -> tuple[Recording, list[str]]:
    """The recording with the scale of graph paper in the picture where it states none,
    and notes."""
    if recording.camera.mm_per_px:
        return recording, []
    from benchtwin.vision.paper.scale import read_scale

    grey_background = tracked.scene.grey_background
    picture = np.clip(
        grey_background * (255 / max(float(grey_background.max()), 1.0)), 0, 255
    ).astype(np.uint8)
    try:
        scale = read_scale(picture)
    except MeasurementError as error:
        return recording, [
            "no scale: [camera] mm_per_px is missing, and no graph paper was read"
            f" ({error})"
        ]
    if scale.quality != GOOD:
        doubt = f"({scale.mm_per_px:.3g} mm per px? {scale.reason})"
        return recording, [
            "no scale: [camera] mm_per_px is missing, and that of the graph paper is"
            f" doubtful {doubt}"
        ]
    note = (
        f"scale read from the graph paper in the picture: {scale.mm_per_px:.5g} ±"
        f" {scale.mm_per_px_sd:.2g} mm per px"
    )
    return with_camera(
        recording, mm_per_px=scale.mm_per_px, mm_per_px_sd=scale.mm_per_px_sd
    ), [note]


def _observation(
    recording: Recording, quantities, notes, pictures, track: Track, bounces=None
) -> Observation:
    unique = tuple(dict.fromkeys(notes))
    return Observation(
        recording.id,
        recording.need_rig(),
        tuple(quantities),
        unique,
        pictures,
        track.to_table(),
        bounces,
    )


def _caption(quantities: tuple[Quantity, ...]) -> str:
    known = [q for q in quantities if np.isfinite(q.value)]
    shown = [
        f"{q.name} {q.value:.4g} ± {q.sd:.2g}" + (f" {q.unit}" if q.unit != "1" else "")
        for q in known
    ]
    return "; ".join(shown[:2]) if shown else "nothing could be measured"


def _flight_curves(result: Rebound) -> list[tuple[np.ndarray, np.ndarray]]:
    """(time, height) of each fitted flight from contact to contact, for the plot."""
    if (flights := result.flights) is None:
        return []
    first, last = flights.time[flights.rows[0][0]], flights.time[flights.rows[-1][-1]]
    times = [first, *flights.contact_times()[:-1], last]
    spans = [np.linspace(a, b, 80) for a, b in itertools.pairwise(times)]
    return [(t, flights.height(k, t)) for k, t in enumerate(spans)]


def _plot_flights(result: Rebound, recording: Recording) -> np.ndarray:
    track = result.track
    up, _ = gravity_axes(track, recording)
    curves = _flight_curves(result)
    marks = [(t[0], h[0]) for t, h in curves[1:]]
    labels = (f"t [{track.time_unit}]", f"height [{track.unit}]")
    return plot(
        track.time,
        up,
        track.outlier,
        labels=labels,
        curves=curves,
        marks=marks,
        caption=_caption(result.quantities),
    )


def _draw_drop(
    tracked: TrackedSeed, result: Rebound, recording: Recording
) -> np.ndarray:
    """Places and fitted flights on the first frame, with the plate's line below the
    seed at contact."""
    track, height = tracked.track, tracked.scene.shape[0]
    scale = recording.camera.mm_per_px or 1.0
    turn = np.radians(recording.camera.plumb_deg or 0.0)
    _, across = gravity_axes(result.track.used(), recording)
    time = result.track.used().time
    curves, marks = [], []
    for t, h in _flight_curves(result):
        side = np.interp(t, time, across)
        x, y = (
            (h * np.sin(turn) + side * np.cos(turn)) / scale,
            (h * np.cos(turn) - side * np.sin(turn)) / scale,
        )
        curves.append((x, height - 1 - y))
        marks.append((x[0], height - 1 - y[0]))
    lines = []
    if len(marks) > 1 and np.isfinite(tracked.size):
        column, row = marks[1]
        low, wide = row + tracked.size / 2, 3 * tracked.size
        slope = np.tan(turn)
        lines = [
            ((column - wide, low - slope * wide), (column + wide, low + slope * wide))
        ]
    return on_picture(
        tracked.scene.first,
        track.x,
        height - 1 - track.y,
        result.track.outlier,
        curves=curves,
        marks=marks[1:],
        lines=lines,
        caption=_caption(result.quantities),
    )


def _plot_travel(track: Track, fitted, at, quantities, place=None) -> np.ndarray:
    marks = []
    if fitted is not None and at is not None:
        marks.append((at, float(np.interp(at, *fitted))))
    if fitted is not None and place is not None:
        marks.append((float(fitted[0][np.argmin(np.abs(fitted[1] - place))]), place))
    curves = [] if fitted is None else [fitted]
    labels = (f"t [{track.time_unit}]", f"travel [{track.unit}]")
    return plot(
        track.time,
        track.x,
        track.outlier,
        labels=labels,
        curves=curves,
        marks=marks,
        caption=_caption(quantities),
    )
