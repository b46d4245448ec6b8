"""A track or a film of a seed that falls onto a bed → how far it rises again: from
where fall and rise meet to the apex of the rise."""

from collections.abc import Iterable

import numpy as np

from benchtwin.bench.constants import G_MM_S2
from benchtwin.rigs.bed.equation import doubt_of
from benchtwin.vision.measurement import Observation, Quantity
from benchtwin.vision.motion.flight import Flights, find_flights
from benchtwin.vision.motion.of_recording import Progress, seed_of
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
    track.need_physical(recording)
    sd = np.where(np.isfinite(track.sd), track.sd, np.nan)
    flights = find_flights(track.time, track.frame, track.y, track.x, sd, G_MM_S2)
    doubt, height = doubt_of(recording), recording.bed.height_mm
    rise, rise_sd = _rise(flights)
    found = [Quantity("bed_rebound", rise, rise_sd, "mm").doubt(doubt)]
    if height is not None and rise > 0:
        e = float(np.sqrt(rise / height))
        own = Quantity("apparent_restitution", e, e / 2 * rise_sd / rise, "1")
        found.append(own.doubt(doubt))
    return tuple(found)


def _rise(flights: Flights) -> tuple[float, float]:
    """Apex of the first flight after the impact above the place of impact, and its sd:
    each of both places is off by what one row is, over the root of the rows that its
    flight has."""
    if len(flights.rows) < 2:
        return 0.0, flights.noise
    contact = flights.contact_time(0)
    low = float(flights.height(0, contact))
    apex = float(flights.height(1, flights.apex_time(1)))
    # the time of impact is off by noise over the change of speed there
    before, after = flights.speed(0, contact), flights.speed(1, contact)
    off = abs(before / (after - before)) if after != before else 0.0
    rows = [1 / len(r) for r in flights.rows[:2]]
    sd = flights.noise * float(np.sqrt(rows[1] + rows[0] + off**2 * sum(rows)))
    return max(apex - low, 0.0), sd


def _plot(track: Track, found: Iterable[Quantity]) -> np.ndarray:
    said = "; ".join(q.in_words for q in found)
    labels = ("t [s]", f"height [{track.unit}]")
    return plot(track.time, track.y, track.outlier, labels=labels, caption=said)
