"""Measures a drop, slide or roll from any evidence: track, light gates, impact times,
frames, video or sound."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
import pandas as pd
from benchtwin.rigs.drop.measure import QUANTITIES, Rebound, measure_drop
from benchtwin.rigs.roll import RIG as ROLL
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
from benchtwin.vision.motion.roll_path import roll_path
from benchtwin.vision.motion.several_drops import drop_rows, over_drops
from benchtwin.vision.motion.tilting_plate import PlateOverlay, track_slide
from benchtwin.vision.motion.track import (
    Track,
    struck_out,
    track_from_gates,
    track_from_table,
)
from benchtwin.vision.motion.track_seed import TrackedSeed, track_seed
from benchtwin.vision.overlay.plot import plot
from benchtwin.vision.overlay.track import on_picture
from benchtwin.vision.recording import Recording, with_camera

_SHARE = np.linspace(0, 1, 60)  # of a flight


def observe_moving(
    recording: Recording,
    options: object = None,
    progress: Callable[[float], None] | None = None,
) -> Observation:
    """Measure a drop, slide or roll of any evidence; quantities that cannot be measured
    are failed, with the reason. options: of piles, not used."""
    if recording.evidence == "photos":
        raise MeasurementError(
            f"{recording.path}: a {recording.rig} is measured on frames, a video or a"
            " track, not on a photo"
        )
    if recording.evidence == "impacts.csv":
        return _observe_impacts(recording)
    if recording.evidence == "track.csv":
        table = read_track(recording.files[0])
        track = struck_out(
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
        drops = _measure_drops(
            track,
            recording,
            lambda rows: measure_drop(track.take(rows), recording),
        )
        return _of_drops(recording, drops, track, ())
    if recording.rig == "slide":
        slide = SLIDE.part("measure")(track, recording)
        pictures = {
            "slide": _plot_travel(track, slide.fitted, slide.onset, slide.quantities)
        }
        return _observation(
            recording, slide.quantities, (*track.notes, *slide.notes), pictures, track
        )
    roll = ROLL.part("measure")(track, recording)
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
    tracked = replace(tracked, track=struck_out(tracked.track, recording))
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
    drops = _measure_drops(
        seen,
        recording,
        lambda rows: measure_drop(seen.take(rows), recording, axis, share[rows]),
    )
    found = _of_drops(recording, drops, seen, notes)
    picture = _draw_drop(tracked, drops, recording, _caption(found.quantities))
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
        _observation(
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
    picture = _plot_flights(drops, used, recording, _caption(found.quantities))
    return replace(found, pictures={"flights": picture}, track=used.to_table())


def _as_used(track: Track, drops: list[_Drop]) -> Track:
    """The whole track with the times and outliers that the drops were measured with;
    what is of none of them is an outlier."""
    t_s, outlier = track.t_s.copy(), np.ones(len(track), bool)
    for drop in drops:
        t_s[drop.rows] = drop.result.track.t_s
        outlier[drop.rows] = drop.result.track.outlier
    return replace(track, t_s=t_s, outlier=outlier)


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
    roll = ROLL.part("measure")(track, recording, junction=junction)
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
    said = "; ".join(q.in_words for q in known[:2]).replace("_", " ")
    return said or "nothing could be measured"


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
        column, row = marks[0]
        low, wide = row + tracked.size / 2, 3 * tracked.size
        slope = np.tan(turn)
        lines = [
            ((column - wide, low - slope * wide), (column + wide, low + slope * wide))
        ]
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
