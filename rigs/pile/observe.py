"""A photo of a pile, or the last frame of a film, → what is measured on it."""

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from benchtwin.vision.board.camera import with_board
from benchtwin.vision.evidence.frames import open_frames
from benchtwin.vision.evidence.photo import read_photo
from benchtwin.vision.measurement import MeasurementError, Observation
from benchtwin.vision.motion.of_recording import doubted
from benchtwin.vision.overlay.pile import draw_repose
from benchtwin.vision.pile.repose import (
    PileOptions,
    Repose,
    measure_repose,
    rig_options,
)
from benchtwin.vision.recording import Recording

if TYPE_CHECKING:
    from benchtwin.vision.motion.of_recording import Progress

LEAST_WINDOW = 0.1  # of the crest's height
BLACK = 12.0  # levels of 255: a frame, or a row of it, that is darker on average
BAR_EDGE_PX = 2  # of a letterbox's bars, which compression blurs
# levels of 255, of more than this share of the surface: seeds on it still move
MOVED, MOST_MOVED = 25.0, 0.05


def observe_pile(
    recording: Recording,
    options: PileOptions | None = None,
    progress: "Progress | None" = None,
) -> Observation:
    """Measure the first photo of a pile recording (each photo is a recording of its
    own), or the last frame of a film."""
    if recording.evidence not in ("photos", "video"):
        apart = "; photos of different piles lie in the recording's folder, not in"
        more = f'{apart} "frames"' if recording.evidence == "frames" else ""
        raise MeasurementError(
            f"{recording.path}: a pile is measured on photos or a film, not on"
            f" {recording.evidence}{more}"
        )
    options = _with_recording_options(options or PileOptions(), recording)
    film = recording.evidence == "video"
    if film:
        before, image = _last_two(recording)
    else:
        before, image = None, read_photo(recording.files[0])
    if film and options.roi is None and options.baseline is None:
        rows = slice(bar := _bar(image), len(image) - bar)
        before, image = None if before is None else before[rows], image[rows]
    seen = with_board(recording, image)
    try:
        found = measure_repose(seen.picture, seen.recording.camera, options)
    except MeasurementError as error:
        raise MeasurementError(f"{recording.files[0]}: {error}") from error
    if before is not None and _moves(before, image, found):
        found = found.doubted("the film ends before the heap is at rest")
    last = ["measured on the film's last frame"] if film else []
    observation = Observation(
        recording.id,
        "pile",
        found.quantities,
        (*found.notes, *seen.notes, *last),
        {"pile": draw_repose(image, found, seen.board)},
        heap=found,
    )
    return doubted(observation, seen.doubt)


def _last_two(recording: Recording) -> tuple[np.ndarray | None, np.ndarray]:
    """The last two frames of a film that are not black, the first None where there is
    but one."""
    before = last = None
    for frame in open_frames(recording).iterate():
        if frame.pixels.mean() > BLACK:
            before, last = last, frame.pixels
    if last is None:
        raise MeasurementError(f"{recording.files[0]}: every frame is black")
    return before, last


def _bar(frame: np.ndarray) -> int:
    """Rows of the black bars, alike above and below, that a letterbox has; 0 without
    one."""
    lit = np.flatnonzero(frame.reshape(len(frame), -1).mean(axis=1) > BLACK)
    bar = min(int(lit[0]), len(frame) - 1 - int(lit[-1]))
    return bar + BAR_EDGE_PX if bar else 0


def _moves(before: np.ndarray, last: np.ndarray, found: Repose) -> bool:
    """Whether seeds on the heap's surface differ between two frames."""
    x = np.flatnonzero(np.isfinite(found.surface))
    left, right = (
        found.crest[0] - found.roi[0] if t is None else t for t in found.toes
    )
    x = x[(x >= left) & (x <= right)]
    rows = np.rint(found.surface[x]).astype(int) + found.roi[1]
    places = np.clip(rows, 0, len(last) - 1), x + found.roi[0]
    change = np.abs(last[places].astype(float) - before[places]).reshape(x.size, -1)
    return bool((change.mean(axis=1) > MOVED).mean() > MOST_MOVED)


def _with_recording_options(options: PileOptions, recording: Recording) -> PileOptions:
    """The options with base line, region and window as the recording states them, where
    they are not given."""
    pile, typical = recording.pile, PileOptions()
    options = rig_options(recording, options)
    if options.baseline is None and pile.baseline_px is not None:
        options = replace(options, baseline=pile.baseline_px)
    if options.roi is None and pile.roi_px is not None:
        options = replace(options, roi=pile.roi_px)
    if options.window == typical.window and pile.window_pct is not None:
        low, high = (share / 100 for share in pile.window_pct)
        if high - low < LEAST_WINDOW:
            raise MeasurementError(
                f"{recording.toml}: [pile] window_pct: two heights in %, at least"
                f" {100 * LEAST_WINDOW:g} apart"
            )
        options = replace(options, window=(low, high))
    return options
