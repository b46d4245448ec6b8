"""Quantities of impacts: restitution at the point of contact, its offset, kick and
friction.

A seed of radius h that is touched b beside its centre turns by  I Δω = m (b Δv_n + h
Δv_x).  The point of contact closes with u = v_n + b ω, and  e = −u'/u  is what a
central impact would have. Where the spin is not seen, e = −v_n'/v_n."""

import math
from dataclasses import dataclass, replace

import numpy as np

from benchtwin.bench import distributions as stats
from benchtwin.bench.constants import G_M_S2
from benchtwin.bench.robust import robust_sd
from benchtwin.rigs.drop.effects.impacts import REACH, ROUGH
from benchtwin.rigs.drop.flight_model import ROUND
from benchtwin.rigs.drop.impacts import Impacts

SLOWEST_M_S = 0.15  # closing speed below which restitution is not used
CAP = 4.0  # sds at which one impact's offset is clipped
KICK_PER_ELONGATION, KICK_ROUGH = (
    0.7,
    0.05,
)  # sd of Δv_x/Δv_n where no spin is seen; 3-D ellipsoids have .55 of (a − c)/(a + c)
KICK_FLOOR = 0.002  # least scatter of kicks
# elongation below which the contact is taken to lie below the centre: Δv_x = (I/mh) Δω
# but for the tilt
NEARLY_ROUND = 0.05
STUCK = -1.0  # coefficient of the slip
STUCK_SD = 5.0


@dataclass(frozen=True, eq=False)
class ImpactQuantities:
    """Of n impacts, (n,) each unless stated."""

    speed: np.ndarray  # closing speed of the point of contact [m/s]
    e: np.ndarray
    e_usable: np.ndarray
    offset: np.ndarray  # b [m], NaN if unseen
    kick: np.ndarray  # Δv_x/Δv_n
    slip: np.ndarray  # (v_x + h ω)/Δv_n before
    turn: np.ndarray  # h Δω/Δv_n, 0 if unseen
    share: np.ndarray  # v_n/Δv_n before
    drift: np.ndarray  # (2, n): v_x/v_n before and after, plus h ω if b is allowed for
    e_error: np.ndarray  # this and kick_error (n, n): covariances
    kick_error: np.ndarray
    spin_error: np.ndarray  # (n, n): of h ω'/Δv_n
    offset_sd: np.ndarray  # [m]


def impact_quantities(impacts: Impacts, elongation: float) -> ImpactQuantities:
    """For seeds of this elongation; balls are touched below their centre."""
    radius, gyration = (
        getattr(impacts.seeds, key)[impacts.recording] for key in ("radius", "gyration")
    )
    (vx, vz, w), (vx2, vz2, w2) = impacts.before.T, impacts.after.T
    gain, spun = vz2 - vz, impacts.spin_seen & np.isfinite(radius)
    with np.errstate(invalid="ignore"):
        turn = np.where(spun, radius * (w2 - w) / gain, 0.0)
        offset = np.where(
            spun, (gyration * (w2 - w) - radius * (vx2 - vx)) / gain, np.nan
        )
        arm, reach = (
            np.where(spun & (elongation >= ROUND), length, 0.0)
            for length in (offset, radius)
        )
        closing = -(vz + np.where(spun, arm * w, 0.0))
        leaving = vz2 + np.where(spun, arm * w2, 0.0)
        slip = (vx + np.where(spun, radius * w, 0.0)) / gain
    usable = (closing > SLOWEST_M_S) & (leaving > 0)
    safe = np.where(usable, closing, 1.0)
    e, kick = leaving / safe, (vx2 - vx) / gain
    across = [
        v + np.where(spun, reach * np.nan_to_num(turning), 0.0)
        for v, turning in ((vx, w), (vx2, w2))
    ]
    e_error = _error(impacts, 1, -e / safe, 1 / safe) + np.diag(
        (G_M_S2 * impacts.time_sd * (1 + e) / safe) ** 2
    )
    if elongation >= ROUND:  # spins enter both speeds, directly and through the offset
        swing = np.where(
            spun, gyration * (np.nan_to_num(w2) + e * np.nan_to_num(w)) / gain, 0.0
        )
        e_error += _error(
            impacts,
            2,
            np.nan_to_num((e * arm - swing) / safe),
            np.nan_to_num((arm + swing) / safe),
        )
    kick_error = _error(impacts, 0, -1 / gain, 1 / gain) + _error(
        impacts, 1, kick / gain, -kick / gain
    )
    offset_error = _error(impacts, 2, -gyration / gain, gyration / gain) + _error(
        impacts, 0, radius / gain, -radius / gain
    )
    spin_error = np.nan_to_num(
        _error(impacts, 2, 0 * gain, np.nan_to_num(radius / gain))
    )
    offset_sd = np.sqrt(np.diag(offset_error))
    drift = np.nan_to_num(np.array(across) / safe)
    return ImpactQuantities(
        safe,
        e,
        usable,
        offset,
        kick,
        slip,
        turn,
        vz / gain,
        drift,
        e_error,
        kick_error,
        spin_error,
        offset_sd,
    )


def _error(
    impacts: Impacts, axis: int, before: np.ndarray, after: np.ndarray
) -> np.ndarray:
    """Covariance (n, n): a flight's speed has the same error at both its ends."""
    slopes, row = (
        np.zeros((len(impacts), len(impacts.flight_sd))),
        np.arange(len(impacts)),
    )
    slopes[row, impacts.flights[:, 0]] = before
    slopes[row, impacts.flights[:, 1]] += after
    slopes = slopes * np.nan_to_num(impacts.flight_sd[:, axis])
    return slopes @ slopes.T


@dataclass(frozen=True)
class ElongationTest:
    """p: that chance puts contacts so far from the centre; elongation: as the contacts
    show it."""

    p: float
    elongation: float


def elongation_test(
    impacts: Impacts, seen: ImpactQuantities, elongation: float
) -> ElongationTest:
    """From offsets where the spin is seen, else from kicks; p = 1 below 3 impacts."""
    radius, reach = (
        impacts.seeds.radius[impacts.recording],
        impacts.seeds.reach[impacts.recording],
    )
    known = np.isfinite(seen.offset) & np.isfinite(radius)
    if known.sum() >= 3:
        part = (seen.offset / np.hypot(REACH * reach + ROUGH * radius, seen.offset_sd))[
            known
        ]
        part, freedom = part - np.median(part), int(known.sum()) - 1
    else:
        kicks = seen.kick[np.isfinite(seen.kick)]
        if len(kicks) < 3 or not np.isfinite(radius).all():
            return ElongationTest(1.0, elongation)
        part, freedom = (
            (kicks - np.median(kicks))
            / (KICK_PER_ELONGATION * elongation + KICK_ROUGH),
            len(kicks) - 1,
        )
    ratio = float((np.minimum(np.abs(part), CAP) ** 2).sum()) / freedom
    return ElongationTest(
        float(stats.chi2.sf(freedom * ratio, freedom)),
        elongation * math.sqrt(max(ratio, 1.0)),
    )


@dataclass(frozen=True)
class Friction:
    """Δv_x/Δv_n = stick (v_x + h ω)/Δv_n + turn h Δω/Δv_n on a level plate: means and
    sds.

    A contact that sticks has −1 and −1; one that slides 0 and 0 on average; a ball
    touched below its centre 0 and I/mh² = 0.4. Where the spin is not seen, a ball gives
    0 to −2/7 of the slip, and another share (grip) of what a tilt adds to it."""

    stick: float
    stick_sd: float
    turn: float
    turn_sd: float
    grip_sd: float = 0.0

    @property
    def sticks(self) -> bool:
        """Whether slip and turn determine the kick, whatever the shape."""
        return self.stick == STUCK


def friction_of(elongation: float, spun: bool) -> Friction:
    """Friction at an impact of a seed of this elongation, whether or not its spin was
    seen."""
    if not spun:
        return Friction(-1 / 7, 0.1, 0.0, 0.0, 0.1)
    return (
        Friction(0.0, 0.02, 0.4, 0.02)
        if elongation < NEARLY_ROUND
        else Friction(-0.5, 0.5, 0.0, 1.0)
    )


def sticking(
    seen: ImpactQuantities,
    rows: np.ndarray,
    push: Friction,
    impacts: Impacts,
    long: float,
) -> tuple[ImpactQuantities, np.ndarray, Friction]:
    """The impacts that stick, if all but a few do: kick + slip + turn is then the
    tilt's."""
    if push.turn_sd == 0 or len(rows) < 5:
        return seen, rows, push
    off, spread = _off_and_spread((seen.kick + seen.slip + seen.turn)[rows])
    usual = 0.3 * float(np.std(seen.turn[rows]))
    # a ball's angular momentum is a law of its own, and better but for what roughness
    # does to it
    if push.turn_sd <= 0.05:
        usual = 0.4 * _off_and_spread((seen.kick - push.turn * seen.turn)[rows])[1]
    holds = off < STUCK_SD * spread
    if holds.mean() < 0.6 or spread > usual:
        return seen, rows, push
    # −1 up to the radius's variation and the spin's noise
    holding = Friction(STUCK, 0.0, -1 + 0.3 * long, 0.03 + 0.7 * long)
    return stuck(seen, impacts), rows[holds], holding


def stuck(seen: ImpactQuantities, impacts: Impacts) -> ImpactQuantities:
    """Slip v_x/Δv_n and turn h ω'/Δv_n of contacts that stick: v_x' + h ω' = α v_z'."""
    slip = impacts.before[:, 0] / (impacts.after[:, 1] - impacts.before[:, 1])
    return replace(
        seen,
        slip=slip,
        turn=seen.turn + seen.slip - slip,
        kick_error=seen.kick_error + seen.spin_error,
    )


def _off_and_spread(left: np.ndarray) -> tuple[np.ndarray, float]:
    off = np.abs(left - np.median(left))
    return off, max(robust_sd(off), KICK_FLOOR)
