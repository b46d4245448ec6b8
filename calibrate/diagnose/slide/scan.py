"""What must be looked for before it can be fitted: a vibration of the plate, whose frequency nobody knows."""

from dataclasses import dataclass

import numpy as np
from scipy import stats

from calibrate.diagnose.noise import whiten
from calibrate.diagnose.slide.problem import Prepared, motion_of

SEEN_P = 1e-4  # over all frequencies
SLOWEST = 6.0  # waves to a slide; slower ones the flexible curve takes up
SPACING, FINE = 0.4, 0.05  # of the inverse of the longest slide


@dataclass(frozen=True)
class Vibration:
    """omega [rad/s]; phases of the acceleration in t − origin of each run's tilt [rad]; p over all frequencies."""

    omega: float
    phases: tuple[float, ...]
    p: float


def vibration(prepared: Prepared) -> Vibration | None:
    """The frequency at which all runs together ripple most about flexible curves; None where none stands out."""
    runs = prepared.session.runs
    if not runs:
        return None
    last = max(float(r.time[-1] - r.time[r.rest]) for r in runs)
    frame = float(np.median(np.concatenate([np.diff(r.time) for r in runs])))
    grid = np.arange(SLOWEST / last, 0.45 / frame, SPACING / last)
    if len(grid) < 2:
        return None
    falls = sum(_falls(prepared, r, grid)[0] for r in range(len(runs)))
    best = int(np.argmax(falls))
    p = float(min(1.0, 2.5 * len(grid) * stats.chi2.sf(falls[best], 2 * len(runs))))
    if p >= SEEN_P:
        return None
    near = grid[best] + np.arange(-1, 1 + FINE, FINE) * SPACING / last
    each = [_falls(prepared, r, near) for r in range(len(runs))]
    at = int(np.argmax(sum(fall for fall, _ in each)))
    # travel a cos ωt + b sin ωt is an acceleration −ω² of that: A cos(ωt + φ) with A cos φ = −ω² a, A sin φ = ω² b
    phases = tuple(float(np.arctan2(waves[1, at], -waves[0, at])) for _, waves in each)
    return Vibration(2 * np.pi * float(near[at]), phases, p)


def _falls(prepared: Prepared, r: int, hertz: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Fall of χ² (f,) that a wave of each frequency takes from run r's slide, and its cosine and sine (2, f) [mm]."""
    run, curve = prepared.session.runs[r], motion_of(prepared.session.runs[r])
    angle = 2 * np.pi * (run.time[run.rest :] - run.tilt.origin)[:, None] * hertz
    rows = np.column_stack([curve.design, np.cos(angle), np.sin(angle), curve.data]) / prepared.sigma[r][run.rest :, None]
    white = whiten(rows[:, None, :], curve.lag[:, None], prepared.noise.rho, prepared.noise.white)[0][:, 0]
    count = curve.design.shape[1]
    basis = np.linalg.qr(white[:, :count])[0]
    white = white[:, count:] - basis @ (basis.T @ white[:, count:])
    cosine, sine, data = white[:, : len(hertz)], white[:, len(hertz) : -1], white[:, -1]
    cc, ss, cs = (cosine**2).sum(0), (sine**2).sum(0), (cosine * sine).sum(0)
    right = np.stack([cosine.T @ data, sine.T @ data])
    waves = np.stack([ss * right[0] - cs * right[1], cc * right[1] - cs * right[0]]) / np.maximum(cc * ss - cs**2, 1e-30)
    return (waves * right).sum(0), waves
