"""Flights that are not free: a seed's other end strikes some ms later, or it rocks to
rest.

A sudden change of velocity within a flight is more than any force bends it by, and no
force takes a tenth of its acceleration from one flight alone. Such flights are left
out; one that was touched just before its contact is cut there. Tested on whitened rows.
"""

from dataclasses import replace

import numpy as np
from numpy.polynomial import legendre

from benchtwin.bench.language import tr
from benchtwin.infer.noise import frame_lag
from benchtwin.rigs.drop.flight_model import ROUND
from benchtwin.rigs.drop.session import Session
from benchtwin.rigs.drop.track_noise import DEGREE, TrackNoise

AFTER_S = (0.0015, 0.002, 0.0025, 0.003, 0.005, 0.007, 0.009, 0.012, 0.016, 0.02)
# fall of χ² with 2 degrees of freedom, 4e-6 by chance, for which a flight is left out
SUDDEN = 25.0
SUDDEN_END = 15.0  # the same for the end of a flight, 6e-4 by chance
LEAST_ROWS = 60  # of a flight that is tested
SLOW_S, SLOW_DEGREE = 0.1, 4  # degree for short hops, which are too slow for air
HELD_SHARE, HELD_SD = (
    0.1,
    5.0,
)  # of the usual fall, and in its sds: by what one flight's own may differ


def without_second_contacts(
    tracks: tuple, session: Session, noise: TrackNoise
) -> tuple[tuple, tuple[str, ...]]:
    """Tracks without such flights or ends, and notes; the same tracks where there are
    none."""
    falls, sds = np.array(
        [_fall(session, noise, f) for f in range(len(session.middle))]
    ).T
    order = np.argsort(falls)
    weight = np.cumsum(1 / np.maximum(sds[order], 1e-12) ** 2)
    usual = falls[order][
        np.searchsorted(weight, weight[-1] / 2)
    ]  # median weighted by 1/sd²
    held = np.abs(falls - usual) > np.maximum(HELD_SHARE * abs(usual), HELD_SD * sds)
    out, notes = list(tracks), []
    left_out = tr("of its flights left out")
    for r, i in enumerate(i for i, t in enumerate(tracks) if not t.trouble):
        flights = np.flatnonzero(session.recording == r).tolist()
        whole, ends = [], []
        for f in flights:
            begin, end = (
                session.middle[f] - session.half[f],
                session.middle[f] + session.half[f],
            )
            if f != flights[0] and (held[f] or _second_touch(session, noise, f)):
                whole.append((begin, end))
            elif f in session.joint[:, 0] and (
                early := _second_touch(session, noise, f, at_end=True)
            ):
                ends.append((end - early, end))
        name, time, flight = (
            tracks[i].recording,
            tracks[i].time_s,
            tracks[i].flight.copy(),
        )
        if whole:
            notes.append(
                tr("{}: {} {}: second contact in flight", name, len(whole), left_out)
            )
        if ends:
            notes.append(
                tr(
                    "{}: the ends of {} {}: early second contact",
                    name,
                    len(ends),
                    left_out,
                )
            )
        for begin, end in whole:
            within = (time >= begin - 1e-9) & (time <= end + 1e-9)
            flight[np.isin(flight, np.unique(flight[within]))] = -1
        for begin, end in ends:
            flight[(time >= begin - 1e-9) & (time <= end + 1e-9)] = -1
        out[i] = replace(tracks[i], flight=flight)
    return tuple(out) if notes else tracks, tuple(notes)


def _fall(session: Session, noise: TrackNoise, flight: int) -> tuple[float, float]:
    """Downward acceleration of one flight and its sd [m/s²]."""
    rows = slice(session.first[flight], session.stop[flight])
    tau, half = session.tau[rows], session.half[flight]
    if len(tau) < 3:  # no acceleration
        return 0.0, np.inf
    data = session.places[rows, 1] / noise.sigma[session.recording[flight], 1]
    both = np.column_stack(
        [np.ones_like(tau), tau / half, -((tau / half) ** 2) / 2, data - data.mean()]
    )
    clean = noise.axes[1].whiten(both, frame_lag(session.frame[rows]))
    values = np.linalg.lstsq(clean[:, :3], clean[:, 3], rcond=None)[0]
    sd = np.sqrt(np.linalg.inv(clean[:, :3].T @ clean[:, :3])[2, 2])
    size = noise.sigma[session.recording[flight], 1] / half**2
    return float(values[2] * size), float(sd * size)


def _second_touch(
    session: Session, noise: TrackNoise, flight: int, *, at_end: bool = False
) -> float:
    """Time between a flight's first or last row and a sudden change of velocity [s], or
    0."""
    if session.elongation < ROUND:
        return 0.0
    rows = slice(session.first[flight], session.stop[flight])
    tau, half = session.tau[rows], session.half[flight]
    after = [a for a in AFTER_S if 3 * session.frame_s < a < 0.4 * 2 * half]
    if len(tau) < LEAST_ROWS or not after:
        return 0.0
    late = tau[-1] - tau if at_end else tau - tau[0]
    bends = np.column_stack([np.maximum(a - late, 0.0) for a in after]) / 1e-3
    basis = legendre.legvander(tau / half, DEGREE if half > SLOW_S / 2 else SLOW_DEGREE)
    angle, lag = session.angle[rows], frame_lag(session.frame[rows])
    if np.ptp(2 * angle) > 2 * np.pi:
        basis = np.column_stack([basis, np.cos(2 * angle), np.sin(2 * angle)])
    falls = np.zeros(len(after))
    for axis in (0, 1):
        data = session.places[rows, axis] / noise.sigma[session.recording[flight], axis]
        clean = noise.axes[axis].whiten(
            np.column_stack([basis, bends, data - data.mean()]), lag
        )
        smooth, rest = clean[:, : basis.shape[1]], clean[:, basis.shape[1] :]
        rest = rest - smooth @ np.linalg.lstsq(smooth, rest, rcond=None)[0]
        columns, left = rest[:, :-1], rest[:, -1]
        falls += (columns.T @ left) ** 2 / np.maximum((columns**2).sum(0), 1e-12)
    return (
        after[int(np.argmax(falls))]
        if falls.max() > (SUDDEN_END if at_end else SUDDEN)
        else 0.0
    )
