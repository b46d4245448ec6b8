"""A track or a film of a seed that falls onto a bed → how far it rises again: from
where fall and rise meet to the apex of the rise."""

from collections.abc import Iterable

import numpy as np

from benchtwin.rigs.bed.equation import doubt_of
from benchtwin.vision.measurement import Observation, Quantity
from benchtwin.vision.motion.of_recording import Progress, seed_of
from benchtwin.vision.motion.rise import rise_of
from benchtwin.vision.motion.track import Track
from benchtwin.vision.overlay.plot import plot
from benchtwin.vision.recording import Recording


def observe_bed(
    recording: Recording, options: object = None, progress: Progress | None = None
) -> Observation:
    """Measure bed_rebound [mm] and apparent_restitution; MeasurementError with the
    reason. options: of piles, not used."""
    seen = seed_of(recording, progress, falling=True)
    found = measure_rise(seen.track, seen.recording)
    pictures = {"bed": _plot(seen.track, found)}
    return seen.doubted(seen.observation(found, (), pictures))


def measure_rise(track: Track, recording: Recording) -> tuple[Quantity, ...]:
    """The quantities of one fall; a seed that stays rises by 0 mm."""
    doubt, height = doubt_of(recording), recording.bed.height_mm
    risen = rise_of(track, recording)
    rise, rise_sd = risen.rise_mm, risen.sd_mm
    found = [Quantity("bed_rebound", rise, rise_sd, "mm").doubt(doubt)]
    if height is not None and rise > 0:
        e = float(np.sqrt(rise / height))
        own = Quantity("apparent_restitution", e, e / 2 * rise_sd / rise, "1")
        found.append(own.doubt(doubt))
    return tuple(found)


def _plot(track: Track, found: Iterable[Quantity]) -> np.ndarray:
    said = "; ".join(q.in_words for q in found)
    labels = ("t [s]", f"height [{track.unit}]")
    return plot(track.time, track.y, track.outlier, labels=labels, caption=said)
