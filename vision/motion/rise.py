"""How far a seed rises again from seeds that it fell on: from where fall and rise meet
to the apex of the rise, whichever way it flies."""

from dataclasses import dataclass

import numpy as np

from benchtwin.bench.constants import G_MM_S2
from benchtwin.bench.language import tr
from benchtwin.vision.measurement import require
from benchtwin.vision.motion.flight import find_flights
from benchtwin.vision.motion.track import Track
from benchtwin.vision.recording import Recording

LEAST_ROWS = 3  # after the impact: fewer say neither how it flies nor that it stays


@dataclass(frozen=True)
class Rise:
    """rise_mm: after the first impact, 0 of a seed that stays; sd_mm; fall_mm: from the
    release to the lowest place of that impact, NaN where the release is not in the
    track or the seed stays."""

    rise_mm: float
    sd_mm: float
    fall_mm: float = np.nan


def rise_of(track: Track, recording: Recording) -> Rise:
    """How far the seed rises after the first impact; where it leaves the picture before
    its highest place, by its speed there. MeasurementError where scale or time is
    unknown, or next to nothing is seen of it after the impact."""
    track.need_physical(recording)
    stated = np.where(np.isfinite(track.sd), track.sd, np.nan)
    flights = find_flights(track.time, track.frame, track.y, track.x, stated, G_MM_S2)
    flown = len(flights.rows) > 1
    after = len(track.time) - 1 - int(flights.rows[0][-1])
    require(
        len(flights.rows[1]) if flown else after >= LEAST_ROWS,
        tr(
            "{}: next to nothing is seen of the seed after its impact: it left the"
            " picture, or the recording ends there",
            recording.path,
        ),
    )
    if not flown:
        return Rise(0.0, flights.noise)
    contact = flights.contact_time(0)
    low = float(flights.height(0, contact))
    apex = float(flights.height(1, flights.apex_time(1)))
    # the time of impact is off by noise over the change of speed there
    before, after_it = flights.speed(0, contact), flights.speed(1, contact)
    off = abs(before / (after_it - before)) if after_it != before else 0.0
    rows = [1 / len(r) for r in flights.rows[:2]]
    # of the rise's height at its apex, in those of one row
    tau = flights.time[flights.rows[1]] - flights.middle[1]
    since = flights.apex_time(1) - flights.middle[1]
    highest = 1 / len(tau) + since**2 / np.sum(tau**2)
    sd = flights.noise * float(np.sqrt(highest + rows[0] + off**2 * sum(rows)))
    fall = np.nan
    if flights.release_seen():
        fall = float(flights.height(0, flights.apex_time(0))) - low
    return Rise(max(apex - low, 0.0), sd, fall)
