"""What each impact shows: the restitution of a central impact, the place of the contact beside the centre, the sideways kick.

A seed of radius h that is touched b beside its centre turns by  I Δω = m (b Δv_n + h Δv_x),  which gives b; the point of contact
closes with u = v_n + b ω, and  e = −u'/u  is what a central impact would have. Where the spin is not seen, e = −v_n'/v_n.
"""

from dataclasses import dataclass

import numpy as np

from diagnose.air import G_M_S2
from diagnose.rigs.drop.impacts import Impacts
from diagnose.rigs.drop.model import ROUND

SPREAD_M_S = 0.15  # below this closing speed of the point of contact its restitution is not looked at


@dataclass(frozen=True, eq=False)
class Bounces:
    """(n,) each: speed [m/s] closing of the point of contact, e, e_usable, offset b [m] (NaN unseen); kick Δv_x/Δv_n, slip
    (v_x + h ω)/Δv_n before, turn h Δω/Δv_n (0 where unseen), share v_n/Δv_n before; drift (2, n): v_x/v_n and v_x'/v_n
    (0 where unseen), with h ω and h ω' where the offset was allowed for, which takes a tilt for itself;
    e_error, kick_error (n, n): covariances; spin_error (n, n): of h ω'/Δv_n; offset_sd [m], of its measuring."""

    speed: np.ndarray
    e: np.ndarray
    e_usable: np.ndarray
    offset: np.ndarray
    kick: np.ndarray
    slip: np.ndarray
    turn: np.ndarray
    share: np.ndarray
    drift: np.ndarray
    e_error: np.ndarray
    kick_error: np.ndarray
    spin_error: np.ndarray
    offset_sd: np.ndarray


def bounces_of(impacts: Impacts, elongation: float) -> Bounces:
    """All of them; `elongation` of the seeds: balls are touched below their centre whatever noise says."""
    radius, gyration = (getattr(impacts.seeds, key)[impacts.recording] for key in ("radius", "gyration"))
    (vx, vz, w), (vx2, vz2, w2) = impacts.before.T, impacts.after.T
    gain, spun = vz2 - vz, impacts.spin_seen & np.isfinite(radius)
    with np.errstate(invalid="ignore"):
        turn = np.where(spun, radius * (w2 - w) / gain, 0.0)
        offset = np.where(spun, (gyration * (w2 - w) - radius * (vx2 - vx)) / gain, np.nan)
        arm, reach = (np.where(spun & (elongation >= ROUND), length, 0.0) for length in (offset, radius))
        closing = -(vz + np.where(spun, arm * w, 0.0))
        leaving = vz2 + np.where(spun, arm * w2, 0.0)
        slip = (vx + np.where(spun, radius * w, 0.0)) / gain
    usable = (closing > SPREAD_M_S) & (leaving > 0)
    safe = np.where(usable, closing, 1.0)
    e, kick = leaving / safe, (vx2 - vx) / gain
    across = [v + np.where(spun, reach * np.nan_to_num(turning), 0.0) for v, turning in ((vx, w), (vx2, w2))]
    e_error = _error(impacts, 1, -e / safe, 1 / safe) + np.diag((G_M_S2 * impacts.time_sd * (1 + e) / safe) ** 2)
    if elongation >= ROUND:  # both speeds of the point of contact hold the spins, and the offset, which comes from them
        swing = np.where(spun, gyration * (np.nan_to_num(w2) + e * np.nan_to_num(w)) / gain, 0.0)
        e_error += _error(impacts, 2, np.nan_to_num((e * arm - swing) / safe), np.nan_to_num((arm + swing) / safe))
    kick_error = _error(impacts, 0, -1 / gain, 1 / gain) + _error(impacts, 1, kick / gain, -kick / gain)
    offset_error = _error(impacts, 2, -gyration / gain, gyration / gain) + _error(impacts, 0, radius / gain, -radius / gain)
    spin_error = np.nan_to_num(_error(impacts, 2, 0 * gain, np.nan_to_num(radius / gain)))
    offset_sd = np.sqrt(np.diag(offset_error))
    drift = np.nan_to_num(np.array(across) / safe)
    return Bounces(safe, e, usable, offset, kick, slip, turn, vz / gain, drift, e_error, kick_error, spin_error, offset_sd)


def _error(impacts: Impacts, axis: int, before: np.ndarray, after: np.ndarray) -> np.ndarray:
    """Covariance (n, n): a flight's speed is read a little wrong at both its ends alike."""
    slopes, row = np.zeros((len(impacts), len(impacts.flight_sd))), np.arange(len(impacts))
    slopes[row, impacts.flights[:, 0]] = before
    slopes[row, impacts.flights[:, 1]] += after
    slopes = slopes * np.nan_to_num(impacts.flight_sd[:, axis])
    return slopes @ slopes.T
