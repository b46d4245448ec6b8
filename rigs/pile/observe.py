"""A photo of a pile, or the last frame of a film, → what is measured on it."""

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import cv2
import numpy as np

from benchtwin.bench.language import tr
from benchtwin.vision.board.camera import with_board
from benchtwin.vision.evidence.frames import HELD_BYTES, open_frames
from benchtwin.vision.evidence.photo import read_photo
from benchtwin.vision.measurement import MeasurementError, Observation
from benchtwin.vision.motion.of_recording import PICTURES, doubted
from benchtwin.vision.overlay.collapse import draw_collapse
from benchtwin.vision.overlay.pile import draw_repose
from benchtwin.vision.pile.collapse import filmed_collapse
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
MOVING = "the film ends before the heap is at rest"
SMALL_PX = 640  # a film is that wide, at most, where its frames are compared
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
    if recording.evidence not in ("photos", *PICTURES):
        raise MeasurementError(
            tr(
                "{}: a pile is measured on photos or a film, not on {}",
                recording.path,
                recording.evidence,
            )
        )
    options = _with_recording_options(options or PileOptions(), recording)
    filmed = recording.evidence in PICTURES
    film = _film(recording, progress) if filmed else None
    image, top_px = (
        (read_photo(recording.files[0]), 0) if film is None else (film.last, 0)
    )
    if film is not None and options.roi is None and options.baseline is None:
        image = image[(top_px := film.bar) : len(image) - film.bar]
    seen = with_board(recording, image)
    try:
        found = measure_repose(seen.picture, seen.recording.camera, options)
    except MeasurementError as error:
        raise MeasurementError(f"{recording.files[0]}: {error}") from error
    pictures, quantities, notes = {}, found.quantities, []
    flow = None
    if film is not None:
        notes.append(tr("measured on the film's last frame"))
        ends = tr(MOVING) if _moves(film, found, top_px) else ""
        found = found.doubted(ends)
        quantities = found.quantities
        try:
            flow = filmed_collapse(film.t_s, film.small, found, film.factor, top_px)
        except MeasurementError as why:
            notes.append(tr("gate and flow are not measured: {}", why))
        else:
            quantities += tuple(q.doubt(ends) for q in flow.collapse.quantities())
            pictures["collapse"] = draw_collapse(film.last, flow, film.factor)
    observation = Observation(
        recording.id,
        "pile",
        quantities,
        (*found.notes, *seen.notes, *notes),
        {"pile": draw_repose(image, found, seen.board), **pictures},
        heap=found,
        collapse=None if flow is None else flow.collapse,
    )
    return doubted(observation, seen.doubt)


@dataclass(frozen=True, eq=False)
class _Film:
    """Of a film: its last two frames that are not black (the first None where there is
    but one), all of them grey and smaller by `factor` (n, h, w), when they were taken
    (n,)."""

    before: np.ndarray | None
    last: np.ndarray
    small: np.ndarray
    t_s: np.ndarray
    factor: int

    @property
    def bar(self) -> int:
        """Rows of the black bars, alike above and below, that a letterbox has; 0
        without one."""
        lit = np.flatnonzero(self.last.reshape(len(self.last), -1).mean(axis=1) > BLACK)
        bar = min(int(lit[0]), len(self.last) - 1 - int(lit[-1]))
        return bar + BAR_EDGE_PX if bar else 0


def _film(recording: Recording, progress: "Progress | None") -> _Film:
    """Reads it once; MeasurementError where every frame is black."""
    before = last = None
    small, times, factor = [], [], 1
    source = open_frames(recording)
    for n, frame in enumerate(source.iterate()):
        if frame.pixels.mean() <= BLACK:
            continue
        before, last = last, frame.pixels
        high, wide = frame.pixels.shape[:2]
        room = np.sqrt(source.count * high * wide / HELD_BYTES)
        factor = int(np.ceil(max(wide / SMALL_PX, room)))
        small.append(_small(frame.pixels, factor))
        times.append(frame.t_s)
        if progress is not None:
            progress(n / max(source.count, 1))
    if last is None:
        raise MeasurementError(tr("{}: every frame is black", recording.files[0]))
    return _Film(before, last, np.array(small), np.array(times), factor)


def _small(pixels: np.ndarray, factor: int) -> np.ndarray:
    """Grey means over squares of `factor` px, rows and columns beyond the last one left
    out."""
    grey = pixels if pixels.ndim == 2 else cv2.cvtColor(pixels, cv2.COLOR_RGB2GRAY)
    high, wide = (n // factor for n in grey.shape)
    whole = grey[: high * factor, : wide * factor]
    return cv2.resize(whole, (wide, high), interpolation=cv2.INTER_AREA)


def _moves(film: _Film, found: Repose, top_px: int) -> bool:
    """Whether seeds on the heap's surface differ between the last two frames."""
    if film.before is None:
        return False
    x = np.flatnonzero(np.isfinite(found.surface))
    left, right = (
        found.crest[0] - found.roi[0] if t is None else t for t in found.toes
    )
    x = x[(x >= left) & (x <= right)]
    rows = np.rint(found.surface[x]).astype(int) + found.roi[1] + top_px
    places = np.clip(rows, 0, len(film.last) - 1), x + found.roi[0]
    change = np.abs(film.last[places].astype(float) - film.before[places])
    return bool((change.reshape(x.size, -1).mean(axis=1) > MOVED).mean() > MOST_MOVED)


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
                tr(
                    "{}: [pile] window_pct: two heights in %, at least {:g} apart",
                    recording.toml,
                    100 * LEAST_WINDOW,
                )
            )
        options = replace(options, window=(low, high))
    return options
