"""A photo of a pile → what is measured on it."""

from dataclasses import replace
from typing import TYPE_CHECKING

from benchtwin.vision.board.camera import with_board
from benchtwin.vision.evidence.photo import read_photo
from benchtwin.vision.measurement import MeasurementError, Observation
from benchtwin.vision.motion.of_recording import doubted
from benchtwin.vision.overlay.pile import draw_repose
from benchtwin.vision.pile.repose import PileOptions, measure_repose, rig_options
from benchtwin.vision.recording import Recording

if TYPE_CHECKING:
    from benchtwin.vision.motion.of_recording import Progress

LEAST_WINDOW = 0.1  # of the crest's height


def observe_pile(
    recording: Recording,
    options: PileOptions | None = None,
    progress: "Progress | None" = None,
) -> Observation:
    """Measure the first photo of a pile recording (each photo is a recording of its
    own)."""
    if recording.evidence != "photos":
        apart = "; photos of different piles lie in the recording's folder, not in"
        more = f'{apart} "frames"' if recording.evidence == "frames" else ""
        raise MeasurementError(
            f"{recording.path}: a pile is measured on photos, not on"
            f" {recording.evidence}{more}"
        )
    image = read_photo(recording.files[0])
    options = _with_recording_options(options or PileOptions(), recording)
    seen = with_board(recording, image)
    try:
        found = measure_repose(seen.picture, seen.recording.camera, options)
    except MeasurementError as error:
        raise MeasurementError(f"{recording.files[0]}: {error}") from error
    observation = Observation(
        recording.id,
        "pile",
        found.quantities,
        (*found.notes, *seen.notes),
        {"pile": draw_repose(image, found, seen.board)},
        heap=found,
    )
    return doubted(observation, seen.doubt)


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
