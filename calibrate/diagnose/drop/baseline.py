"""Whitened least squares of a session, and the reduced space in which every later question is linear algebra.

Gauss–Newton on the globals within their priors, all flights' starts eliminated (reduction.py).
"""

from dataclasses import dataclass

import numpy as np

from calibrate.diagnose.drop.air import G_M_S2
from calibrate.diagnose.drop.model import LAWS, Model
from calibrate.diagnose.drop.noise_of_track import TrackNoise, estimate_noise
from calibrate.diagnose.drop.reduction import Reduced, reduce
from calibrate.diagnose.drop.session import Session

GRAVITY_SD = 5e-4  # of g at an unknown place on earth, beside 9.80665: a twin of the scale, so part of what is known of it
PERSPECTIVE_SD = 1e-3
TURNS = 5


@dataclass(frozen=True, eq=False)
class Fit:
    """names (G,); prior_sd (G,) with which each was held (0: fixed at nil); values (G,), covariance (G, G); starts (F, 4); χ² and
    its degrees of freedom, prior terms included; reduced: one a recording."""

    model: Model
    noise: TrackNoise
    names: tuple[str, ...]
    prior_sd: np.ndarray
    values: np.ndarray
    covariance: np.ndarray
    starts: np.ndarray
    chi2: float
    freedom: int
    reduced: tuple[Reduced, ...]

    @property
    def by_name(self) -> dict[str, float]:
        return dict(zip(self.names, self.values, strict=True))


def baseline_sd(session: Session) -> dict[str, float]:
    """What a good bench leaves open: sd of every global about 0 in the baseline; what is not named is fixed at nil."""
    known = {
        "scale-error": float(np.hypot(session.scale_sd, GRAVITY_SD)), "camera-roll": session.plumb_sd_deg,
        "perspective": PERSPECTIVE_SD, "lens": LAWS["lens"].prior_sd, "drag": float(np.median([a.sd for a in session.air])),
    }  # fmt: skip
    return known | {n: law.prior_sd for n, law in LAWS.items() if n.startswith("pixel-lock")}


def fit(model: Model, noise: TrackNoise | None = None, *, free: tuple[str, ...] = (), start: Fit | None = None) -> Fit:
    """Gauss–Newton from each flight's own parabola (or from `start`); `free`: candidates with their physical prior."""
    noise = noise or estimate_noise(model.session)
    known = baseline_sd(model.session)
    names = model.names
    wide = {n for n in names if n in free or (LAWS[n].group and LAWS[n].group in free)}
    prior = np.array([np.hypot(LAWS[n].prior_sd, known.get(n, 0.0)) if n in wide else known.get(n, 0.0) for n in names])
    starts, values = (start.starts, start.values * (prior > 0)) if start else (_parabolas(model.session), np.zeros(len(names)))
    before = np.inf
    for _ in range(TURNS):
        reduced, solve_locals = reduce(model, noise, starts, values)
        values_next, covariance, chi2 = ridge(np.vstack([r.a for r in reduced]), np.concatenate([r.b for r in reduced]), prior)
        starts = starts + solve_locals(values_next - values)
        moved, values = np.abs(values_next - values) / np.maximum(prior, 1e-300), values_next
        if np.max(moved, where=prior > 0, initial=0.0) < 0.01 and abs(before - chi2) < 0.1:  # far below one sd, one unit of χ²
            break
        before = chi2
    used = 2 * len(model.session.tau) + int((np.isfinite(model.session.release)).sum()) + len(model.session.joint)
    freedom = used - 4 * len(starts)
    return Fit(model, noise, names, prior, values, covariance, starts, chi2, freedom, reduced)


def ridge(a: np.ndarray, b: np.ndarray, prior_sd: np.ndarray) -> tuple[np.ndarray, np.ndarray, float]:
    """θ (G,) minimising |b − aθ|² + |θ/sd|², its covariance and the minimum; sd 0: fixed at nil."""
    kept = prior_sd > 0
    scaled = a[:, kept] * prior_sd[kept]
    information = scaled.T @ scaled + np.eye(kept.sum())
    values, covariance = np.zeros(len(prior_sd)), np.zeros((len(prior_sd), len(prior_sd)))
    inverse = np.linalg.inv(information)
    u = inverse @ (scaled.T @ b)
    values[kept] = prior_sd[kept] * u
    covariance[np.ix_(kept, kept)] = prior_sd[kept][:, None] * inverse * prior_sd[kept]
    return values, covariance, float(((b - scaled @ u) ** 2).sum() + (u**2).sum())


def _parabolas(session: Session) -> np.ndarray:
    """Starts (F, 4) of a straight line across and a parabola of g upwards."""
    out = np.empty((len(session.middle), 4))
    for f in range(len(out)):
        rows = slice(session.first[f], session.stop[f])
        tau = session.tau[rows]
        up = session.places[rows, 1] + G_M_S2 * tau**2 / 2
        slope, level = np.polynomial.polynomial.polyfit(tau, np.column_stack([session.places[rows, 0], up]), 1)[::-1]
        out[f] = [*level, *slope]
    return out
