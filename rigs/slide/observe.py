"""A recording of a slide, whatever its evidence → what is measured on it."""

import numpy as np

from benchtwin.rigs.slide.measure import Slide, measure_slide
from benchtwin.rigs.slide.on_seeds import observe_on_seeds
from benchtwin.vision.evidence.frames import open_frames
from benchtwin.vision.measurement import Observation
from benchtwin.vision.motion.of_recording import (
    TABLES,
    Progress,
    Tabled,
    followed,
    need_track,
    table_track,
)
from benchtwin.vision.motion.tilting_plate import track_slide
from benchtwin.vision.motion.track import Track
from benchtwin.vision.overlay.plot import caption, plot_travel
from benchtwin.vision.overlay.track import on_picture
from benchtwin.vision.recording import Recording


def observe_slide(
    recording: Recording, options: object = None, progress: Progress | None = None
) -> Observation:
    """Friction of a slide; quantities that cannot be measured are failed, with the
    reason. options: of piles, not used."""
    if recording.slide.plate:
        return observe_on_seeds(recording, progress)
    need_track(recording)
    if recording.evidence in TABLES:
        read = Tabled(recording, table_track(recording))
        slide = measure_slide(read.track, recording)
        return read.observation(slide.quantities, slide.notes, _plot(read.track, slide))
    source = open_frames(recording)
    tracked, plate = track_slide(source, recording, progress)
    seen = followed(recording, source, tracked)
    slide = measure_slide(seen.track, seen.recording)
    pictures = {
        "track": on_picture(
            plate.picture,
            *plate.places,
            seen.track.outlier,
            lines=plate.lines,
            caption=caption(slide.quantities),
        ),
        **_plot(seen.track, slide),
    }
    return seen.observation(
        slide.quantities, slide.notes, pictures, places=plate.places
    )


def _plot(track: Track, slide: Slide) -> dict[str, np.ndarray]:
    return {"slide": plot_travel(track, slide.fitted, slide.onset, slide.quantities)}
