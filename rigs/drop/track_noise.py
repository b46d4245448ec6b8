"""Noise of a session's tracks: residuals about a curve more flexible than any
effect."""

from dataclasses import dataclass

import numpy as np
from numpy.polynomial import legendre

from benchtwin.bench.constants import G_M_S2
from benchtwin.infer.noise import Noise, Stretch, estimate, frame_lag, spreads
from benchtwin.rigs.drop.session import LEAST_ROWS, Session

TELLING = 20  # longest flights, which tell the correlation
DEGREE = 6  # of the curve; forces act in degrees 2 to 5
EXACT_M = 1e-7  # floor for simulated tracks
TRACKER_PX = 0.01  # smooth error of a silhouette's centre by light and pixels
UNSEEN_M = 10.0  # sd of a coordinate that was not recorded
UNTOLD = 1.0  # sd of ln of the slow noise's power, from which flights do not tell it
SMOOTH = range(2, DEGREE + 1)  # degrees beyond a straight line


@dataclass(frozen=True, eq=False)
class TrackNoise:
    """axes: noise across (x) and up (z), common to the session; sigma (R, 2) [m]."""

    axes: tuple[Noise, Noise]
    sigma: np.ndarray

    @property
    def level_sd(self) -> float:
        """sd of ln of the noise power at low frequency, the larger of both axes."""
        return max(axis.log_level_sd for axis in self.axes)


def smooth_columns(tau: np.ndarray, half: float) -> np.ndarray:
    """Legendre polynomials of SMOOTH degrees (n, 5) at τ of one flight."""
    return legendre.legvander(tau / half, DEGREE)[:, SMOOTH.start :]


def estimate_noise(
    session: Session, known: tuple[Noise, Noise] | None = None
) -> TrackNoise:
    """ρ and white share by REML over the longest flights, or `known`; σ of each
    recording."""
    axes, sigma = [], np.empty((len(session.names), 2))
    for axis in (0, 1):
        stretches = [_stretch(session, f, axis) for f in range(len(session.middle))]
        noise = (
            known[axis]
            if known
            else estimate(sorted(stretches, key=lambda s: -len(s.data))[:TELLING])
        )
        sigma[:, axis] = spreads(
            stretches, session.recording, len(session.names), noise
        )
        if noise.log_level_sd >= UNTOLD:  # few short flights: rows err each by itself
            spare = sum(len(s.data) - s.design.shape[1] for s in stretches)
            noise = Noise(0.0, 0.0, float(np.sqrt(2 / max(spare, 1))))
        axes.append(noise)
    return TrackNoise((axes[0], axes[1]), floored(session, sigma))


def floored(session: Session, sigma: np.ndarray) -> np.ndarray:
    """sds (R, 2) that no track stays below; those of a coordinate that was not
    seen."""
    seen = np.ptp(session.places, axis=0) >= EXACT_M
    least = max(EXACT_M, TRACKER_PX * session.view.pixel)
    return np.where(seen, np.maximum(sigma, least), UNSEEN_M)


def _stretch(session: Session, flight: int, axis: int) -> Stretch:
    rows = slice(session.first[flight], session.stop[flight])
    tau, weight, angle, phase = (
        session.tau[rows],
        session.weight[rows],
        session.angle[rows],
        session.view.phase[rows, axis],
    )
    if len(tau) < LEAST_ROWS:  # a line beside known gravity
        fallen = session.places[rows, axis] + axis * G_M_S2 * tau**2 / 2
        return Stretch(
            weight[:, None] * legendre.legvander(tau / session.half[flight], 1),
            weight * (fallen - fallen.mean()),
            frame_lag(session.frame[rows]),
        )
    degree = min(
        DEGREE, max(2, len(tau) // 25)
    )  # a short flight's curve must not take the noise for motion
    columns = [legendre.legvander(tau / session.half[flight], degree)]
    if len(tau) > 60:  # waves of less than a turn are covered by the curve
        waves = [(2 * angle, 2 * np.pi), (phase, 4 * np.pi)]
        columns += [
            np.column_stack([np.cos(wave), np.sin(wave)])
            for wave, least in waves
            if np.ptp(wave) > least
        ]
    left, size, _ = np.linalg.svd(weight[:, None] * np.hstack(columns), False)
    data = session.places[rows, axis]
    return Stretch(
        left[:, size > 1e-3 * size[0]],
        weight * (data - data.mean()),
        frame_lag(session.frame[rows]),
    )
