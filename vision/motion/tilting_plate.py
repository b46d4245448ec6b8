"""Tracks the block of a slide on its tilting plate, with the plate's angle, in a film."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from vision.evidence.frames import FrameSource
from vision.measurement import MeasurementError
from vision.motion.edge_line import Line, track_edge
from vision.motion.plate_frames import PlateFrames, plate_only
from vision.motion.scene import learn_scene
from vision.motion.track_seed import TrackedSeed, track_seed
from vision.recording import Recording

UNPLUMBED_SD_DEG = 1.0  # of the horizontal where [camera] plumb_deg is not stated
LEAST_SEEN = 0.5  # of the frames: an edge seen in fewer is not used


@dataclass(frozen=True)
class PlateOverlay:
    """For the overlay: the last picture, the block's places in it (columns, rows), and plate lines as segments."""

    picture: np.ndarray
    places: tuple[np.ndarray, np.ndarray]
    lines: list


def track_slide(
    source: FrameSource, recording: Recording, progress: Callable[[float], None] | None = None
) -> tuple[TrackedSeed, PlateOverlay]:
    """Track the block along the tilting plate [px], with the plate's angle, both from the pictures.

    The plate's edge is tracked through the film and the pivot estimated. In pictures that are rotated with the plate only the block
    moves. Angles are against the picture's horizontal plus `camera.plumb_deg`.
    """
    lines, shape, last = track_edge(source)
    if lines is not None and len(lines) < LEAST_SEEN * source.count:
        source.note(f"the plate's edge is seen in {len(lines)} of {source.count} frames only and is not used")
        lines = None
    if lines is None:
        if recording.slide.tilt_rate_deg_s is None:
            text = "no tilting plate edge is seen in the picture, and [slide] start_deg and tilt_rate_deg_s are missing"
            raise MeasurementError(f"{recording.toml}: {text}")
        tracked = track_seed(source, falling=False, progress=progress)
        return _along_own_line(tracked)
    pivot = _pivot(lines)
    unit = shape[1] / 640
    ends = np.array([[line.along @ (line.at(s) - line.foot(pivot)) for s in line.extent] for line in lines.values()])
    reach = (int(ends.min() - 10), int(ends.max() + 10))
    strip = PlateFrames(source, lines, pivot, reach, above=round(110 * unit), below=round(14 * unit))
    tracked = track_seed(strip, falling=False, progress=progress, scene=learn_scene(strip, still=plate_only))
    plumb = recording.camera.plumb_deg or 0.0
    tilt = np.array([np.degrees(lines[int(f)].angle) for f in tracked.track.frame]) - plumb
    flip = -1.0 if np.median(tilt) < 0 else 1.0
    own = float(np.median([line.angle_sd for line in lines.values()]))
    notes, level_sd = tracked.track.notes, recording.camera.plumb_sd
    if recording.camera.plumb_deg is None and recording.camera.plumb_sd_deg is None:
        level_sd = UNPLUMBED_SD_DEG
        notes = (*notes, f"{recording.toml}: [camera] plumb_deg is missing: the plate's angle is known to ± {level_sd:g}° only")
    sd = float(np.hypot(level_sd, np.degrees(own)))
    track = replace(tracked.track, tilt_deg=flip * tilt, tilt_sd_deg=sd, notes=notes)
    rows = strip.height - 1 - track.y
    strip_places = np.column_stack([track.x, rows, np.ones(len(track))])
    places = np.array([strip.matrix(int(f)) @ p for f, p in zip(track.frame, strip_places)])
    shown = [lines[min(lines)], lines[max(lines)]]
    segments = [(tuple(line.at(line.extent[0])), tuple(line.at(line.extent[1]))) for line in shown]
    return replace(tracked, track=track), PlateOverlay(last, (places[:, 0], places[:, 1]), segments)


def _along_own_line(tracked: TrackedSeed) -> tuple[TrackedSeed, PlateOverlay]:
    """Without a plate in the picture: the travel along the principal axis of the block's places."""
    track, height = tracked.track, tracked.scene.shape[0]
    centre = np.array([np.median(track.x), np.median(track.y)])
    offset = np.column_stack([track.x, track.y]) - centre
    _, _, directions = np.linalg.svd(offset, full_matrices=False)
    travel = offset @ directions[0]
    places = (track.x, height - 1 - track.y)
    return replace(tracked, track=replace(track, x=travel, y=offset @ directions[1])), PlateOverlay(tracked.scene.first, places, [])


def _pivot(lines: dict[int, Line]) -> np.ndarray:
    """The pivot P of the plate: n·P − d = c for every line with normal n and offset c; d is constant."""
    normals = np.array([line.across for line in lines.values()])
    offsets = np.array([line.offset for line in lines.values()])
    design = np.column_stack([normals, -np.ones(len(normals))])
    # A small rotation hardly separates d from P; hinges lie near their plate: prior of d, 600 times an edge's error.
    rows = np.vstack([design, [0.0, 0.0, 1 / 600]])
    return np.linalg.lstsq(rows, np.concatenate([offsets, [0.0]]), rcond=None)[0][:2]
