"""The block of a slide on its tilting plate, with the plate's angle, in a film whose
frames are rotated with the plate."""

import contextlib
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from benchtwin.bench.language import tr
from benchtwin.vision.evidence.frames import FrameSource
from benchtwin.vision.measurement import MeasurementError
from benchtwin.vision.motion.edge_line import Line, track_edge
from benchtwin.vision.motion.plate_frames import PlateFrames, plate_frames
from benchtwin.vision.motion.template import LATE, by_template
from benchtwin.vision.motion.track import Track, places_of
from benchtwin.vision.motion.track_seed import TrackedSeed, track_seed
from benchtwin.vision.recording import Recording

LEAST_SEEN = 0.5  # of the frames: an edge seen in fewer is not used
SUBTRACTED = (
    "the background was subtracted: against it the block was not seen from the first"
    " frames on"
)
RESTS_PX, MOVED_PX = 3.0, 6.0  # of a block: at most, while it rests; at least, later


@dataclass(frozen=True)
class PlateOverlay:
    """For the overlay: the last picture, the block's places in it (columns, rows), and
    plate lines as segments."""

    picture: np.ndarray
    places: tuple[np.ndarray, np.ndarray]
    lines: list


def track_slide(
    source: FrameSource,
    recording: Recording,
    progress: Callable[[float], None] | None = None,
) -> tuple[TrackedSeed, PlateOverlay]:
    """Track the block along the tilting plate [px], with the plate's angle, both from
    the pictures. Angles are against the picture's horizontal plus `camera.plumb_deg`.
    In pictures rotated with the plate only the block moves."""
    lines, shape, last = track_edge(source)
    if lines is not None and len(lines) < LEAST_SEEN * source.count:
        source.note(
            tr(
                "the plate's edge is seen in {} of {} frames only and is not used",
                len(lines),
                source.count,
            )
        )
        lines = None
    if lines is None:
        return _without_plate(source, recording, progress)
    strip = plate_frames(source, lines, shape)
    tracked = _block(strip, recording, progress)
    shown = [lines[min(lines)], lines[max(lines)]]
    segments = [
        (tuple(line.at(line.extent[0])), tuple(line.at(line.extent[1])))
        for line in shown
    ]
    overlay = PlateOverlay(last, strip.in_picture(tracked.track), segments)
    track = _with_tilt(tracked.track, lines, recording)
    return replace(tracked, track=track), overlay


def _block(
    strip: PlateFrames,
    recording: Recording,
    progress: Callable[[float], None] | None,
) -> TrackedSeed:
    """The block in frames that are rotated with the plate. The background turns in
    them: where it hides the block, at first or always, it is subtracted."""
    stated, places = recording.track, places_of(recording.track)

    def tracked(frames: PlateFrames) -> TrackedSeed:
        found = track_seed(
            frames,
            falling=False,
            progress=progress,
            at=frames.follow(stated.follow_px),
            places=frames.places(places),
            only_places=bool(stated.only_places),
        )
        return found if places else by_template(found, frames, along=True)

    def against_grey() -> TrackedSeed:
        found = tracked(strip.without_background())
        notes = (*found.track.notes, tr(SUBTRACTED))
        return replace(found, track=replace(found.track, notes=notes))

    try:
        found = [tracked(strip)]
    except MeasurementError:
        if places:
            raise
        return against_grey()
    by_hand = places or stated.follow_px is not None
    if not (by_hand or _like_a_block(found[0].track, strip)[0]):
        with contextlib.suppress(MeasurementError):
            found.append(against_grey())
    return max(found, key=lambda t: _like_a_block(t.track, strip))


def _like_a_block(track: Track, strip: PlateFrames) -> tuple[bool, bool, int]:
    """Whether a track is that of a block that rests from the film's beginning on and
    then slides; whether it moves down the plate; and how many rows it has."""
    used = track.used()
    begins = used.frame[0] - next(strip.iterate()).index
    down = (used.x[-1] - used.x[0]) * strip.downhill > MOVED_PX
    rests = begins < LATE and np.ptp(used.x[:LATE]) < RESTS_PX
    return bool(rests and down), bool(down), len(used)


def _with_tilt(track: Track, lines: dict[int, Line], recording: Recording) -> Track:
    """The track with the plate's angle in each frame, positive however it leans."""
    camera = recording.camera
    angles = [np.degrees(lines[int(frame)].angle) for frame in track.frame]
    tilt = np.array(angles) - (camera.plumb_deg or 0.0)
    flip = -1.0 if np.median(tilt) < 0 else 1.0
    edge_sd = float(np.median([line.angle_sd for line in lines.values()]))
    notes, level_sd = track.notes, camera.plumb_sd
    if camera.plumb_deg is None and camera.plumb_sd_deg is None:
        missing = tr("{}: [camera] plumb_deg is missing", recording.toml)
        known = tr("the plate's angle is known to ± {:g}° only", level_sd)
        notes = (*notes, f"{missing}: {known}")
    sd = float(np.hypot(level_sd, np.degrees(edge_sd)))
    return replace(track, tilt_deg=flip * tilt, tilt_sd_deg=sd, notes=notes)


def _without_plate(
    source: FrameSource,
    recording: Recording,
    progress: Callable[[float], None] | None,
) -> tuple[TrackedSeed, PlateOverlay]:
    """The block where no plate is seen, whose angle is stated."""
    if recording.slide.tilt_rate_deg_s is None:
        text = tr(
            "no tilting plate edge is seen in the picture, and [slide] start_deg and"
            " tilt_rate_deg_s are missing"
        )
        raise MeasurementError(f"{recording.toml}: {text}")
    stated = recording.track
    tracked = track_seed(
        source,
        falling=False,
        progress=progress,
        at=stated.follow_px,
        places=places_of(stated),
        only_places=bool(stated.only_places),
    )
    track, height = tracked.track, tracked.scene.shape[0]
    centre = np.array([np.median(track.x), np.median(track.y)])
    offset = np.column_stack([track.x, track.y]) - centre
    # the travel along the principal axis of its places
    _, _, directions = np.linalg.svd(offset, full_matrices=False)
    travel = offset @ directions[0]
    places = (track.x, height - 1 - track.y)
    return replace(
        tracked, track=replace(track, x=travel, y=offset @ directions[1])
    ), PlateOverlay(tracked.scene.first, places, [])
