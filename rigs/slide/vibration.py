"""Audible vibration of the plate: a ripple of one frequency in all runs."""

from dataclasses import dataclass

import numpy as np

from benchtwin.bench import distributions as stats
from benchtwin.rigs.slide.problem import Prepared, stretches

SEEN_P = 1e-4  # over all frequencies
SLOWEST = 6.0  # waves in a slide; the flexible curve absorbs slower ones
SPACING, FINE = 0.4, 0.05  # of the inverse of the longest slide
LATE = 0.4  # share of a slide by whose end a shaken block no longer sticks
# fall of χ² in a run that shows it; share of the runs that must
SEEN_CHI2 = 9.0
SAME_SHARE = 0.8


@dataclass(frozen=True)
class Vibration:
    """hertz; amplitude of the acceleration [m/s²] and its sd; p over all
    frequencies."""

    hertz: float
    amplitude: float
    sd: float
    p: float


def vibration(prepared: Prepared) -> Vibration | None:
    """The frequency at which all runs ripple most, None if not significant."""
    runs = prepared.session.runs
    if not runs or any(run.in_motion for run in runs):
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
    hertz = float(
        near[np.argmax(sum(_falls(prepared, r, near)[0] for r in range(len(runs))))]
    )
    # without the part in which it sticks and slips
    late = [_falls(prepared, r, np.array([hertz]), LATE) for r in range(len(runs))]
    if np.mean([fall[0] > SEEN_CHI2 for fall, _, _ in late]) < SAME_SHARE:
        return None
    omega = 2 * np.pi * hertz
    sizes = np.array([1e-3 * np.hypot(*waves[:, 0]) * omega**2 for _, waves, _ in late])
    sds = np.array([1e-3 * sd[0] * omega**2 for _, _, sd in late])
    weight = sds**-2 / (sds**-2).sum()
    spread = float(
        np.sqrt((weight * (sizes - weight @ sizes) ** 2).sum() / max(len(runs) - 1, 1))
    )
    return Vibration(
        hertz, float(weight @ sizes), max(float((sds**-2).sum() ** -0.5), spread), p
    )


def _falls(prepared: Prepared, r: int, hertz: np.ndarray, skip: float = 0.0):
    """Fall of χ² (f,) by a wave of each frequency, its waves (2, f) [mm], their sd
    (f,)."""
    run, curve = prepared.session.runs[r], stretches(prepared.session.runs[r])[-1]
    kept = slice(int(skip * len(curve.data)), None)
    angle = 2 * np.pi * (run.time[run.rest :] - run.tilt.origin)[:, None] * hertz
    rows = (
        np.column_stack([curve.design, np.cos(angle), np.sin(angle), curve.data])
        / prepared.sigma[r][run.rest :, None]
    )
    white = prepared.noise.whiten(rows[kept], curve.lag[kept])
    count = curve.design.shape[1]
    basis = np.linalg.qr(white[:, :count])[0]
    white = white[:, count:] - basis @ (basis.T @ white[:, count:])
    cosine, sine, data = white[:, : len(hertz)], white[:, len(hertz) : -1], white[:, -1]
    cc, ss, cs = (cosine**2).sum(0), (sine**2).sum(0), (cosine * sine).sum(0)
    right = np.stack([cosine.T @ data, sine.T @ data])
    area = np.maximum(cc * ss - cs**2, 1e-30)
    waves = (
        np.stack([ss * right[0] - cs * right[1], cc * right[1] - cs * right[0]]) / area
    )
    return (waves * right).sum(0), waves, np.sqrt((cc + ss) / 2 / area)
