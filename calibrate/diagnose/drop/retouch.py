"""Seeds that touch twice: a long seed's other end strikes some milliseconds after the first, and only then it flies.

A sudden change of velocity within a flight is more than any curve of degree 6 that physics could bend it by. Such a flight is
left out whole: where it was touched once it may have been touched again. Asked of the whitened rows of flights after a contact.
"""

from dataclasses import replace

import numpy as np
from numpy.polynomial import legendre

from calibrate.diagnose.drop.model import ROUND
from calibrate.diagnose.drop.noise_of_track import DEGREE, TrackNoise
from calibrate.diagnose.drop.session import Session
from calibrate.diagnose.noise import frame_lag, whiten

AFTER_S = (0.003, 0.005, 0.007, 0.009, 0.012, 0.016, 0.02)
SUDDEN = 25.0  # fall of χ² with 2 degrees of freedom: 4e-6 by chance
LEAST_ROWS = 60  # of a flight that such a question can be put to


def retouched(tracks: tuple, session: Session, noise: TrackNoise) -> tuple[tuple, tuple[str, ...]]:
    """Tracks without the flights that were touched twice, and notes; the same tracks where there was none."""
    if session.elongation < ROUND:
        return tracks, ()
    spans: dict[int, list[tuple[float, float]]] = {}
    for f, r in enumerate(session.recording):
        first = f == np.flatnonzero(session.recording == r)[0]
        if not first and _second_touch(session, noise, f):
            middle, half = session.middle[f], session.half[f]
            spans.setdefault(int(r), []).append((middle - half - 1e-9, middle + half + 1e-9))
    used = [i for i, t in enumerate(tracks) if not t.trouble]
    out, notes = list(tracks), []
    for r, found in spans.items():
        track = tracks[used[r]]
        flight = track.flight.copy()
        for begin, end in found:
            flight[np.isin(flight, np.unique(flight[(track.time_s >= begin) & (track.time_s <= end)]))] = -1
        out[used[r]] = replace(track, flight=flight)
        notes.append(f"{track.recording}: {len(found)} of its flights left out, touched twice")
    return tuple(out), tuple(notes)


def _second_touch(session: Session, noise: TrackNoise, flight: int) -> bool:
    """Whether the velocity changes suddenly within the first moments of a flight."""
    rows = slice(session.first[flight], session.stop[flight])
    tau, half = session.tau[rows], session.half[flight]
    after = [a for a in AFTER_S if 3 * session.frame_s < a < 0.4 * 2 * half]
    if len(tau) < LEAST_ROWS or not after:
        return False
    late = tau - tau[0]
    bends = np.column_stack([np.maximum(a - late, 0.0) for a in after]) / 1e-3
    basis = legendre.legvander(tau / half, DEGREE)
    angle, lag = session.angle[rows], frame_lag(session.frame[rows])[:, None]
    if np.ptp(2 * angle) > 2 * np.pi:
        basis = np.column_stack([basis, np.cos(2 * angle), np.sin(2 * angle)])
    falls = np.zeros(len(after))
    for axis in (0, 1):
        data = session.places[rows, axis] / noise.sigma[session.recording[flight], axis]
        both = np.column_stack([basis, bends, data - data.mean()])[:, None, :]
        clean = whiten(both, lag, noise.axes[axis].rho, noise.axes[axis].white)[0][:, 0]
        smooth, rest = clean[:, : basis.shape[1]], clean[:, basis.shape[1] :]
        rest = rest - smooth @ np.linalg.lstsq(smooth, rest, rcond=None)[0]
        columns, left = rest[:, :-1], rest[:, -1]
        falls += (columns.T @ left) ** 2 / np.maximum((columns**2).sum(0), 1e-12)
    return bool(falls.max() > SUDDEN)
