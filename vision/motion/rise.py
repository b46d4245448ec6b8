"""How far a seed rises again from seeds that it fell on: from where fall and rise meet
to the apex of the rise, whichever way it flies."""

import numpy as np

from benchtwin.bench.constants import G_MM_S2
from benchtwin.vision.motion.flight import find_flights
from benchtwin.vision.motion.track import Track
from benchtwin.vision.recording import Recording


def rise_of(track: Track, recording: Recording) -> tuple[float, float]:
    """Rise after the first impact [mm] and its sd, each of both places being off by
    what one row is, over the root of the rows that its flight has; 0 of a seed that
    stays. MeasurementError where scale or time is unknown."""
    track.need_physical(recording)
    stated = np.where(np.isfinite(track.sd), track.sd, np.nan)
    flights = find_flights(track.time, track.frame, track.y, track.x, stated, G_MM_S2)
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
    return max(apex - low, 0.0), float(sd)
