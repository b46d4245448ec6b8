"""Friction in a sideways kick: shares of slip and turn, and contacts that stick."""

from dataclasses import dataclass, replace

import numpy as np

from diagnose.rigs.drop.impact_quantities import ImpactQuantities
from diagnose.rigs.drop.impacts import Impacts

KICK_FLOOR = 0.002  # least scatter of kicks
NEARLY_ROUND = 0.05  # elongation below which the contact is taken to lie below the centre: Δv_x = (I/mh) Δω but for the tilt
STUCK = -1.0  # coefficient of the slip
STUCK_SD = 5.0


@dataclass(frozen=True)
class Friction:
    """Δv_x/Δv_n = stick (v_x + h ω)/Δv_n + turn h Δω/Δv_n on a level plate: means and sds.

    A contact that sticks has −1 and −1; one that slides 0 and 0 on average; a ball touched below
    its centre 0 and I/mh² = 0.4. Where the spin is not seen, a ball gives 0 to −2/7 of the slip,
    and another share (grip) of what a tilt adds to it.
    """

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
    """Friction at an impact of a seed of this elongation, whether or not its spin was seen."""
    if not spun:
        return Friction(-1 / 7, 0.1, 0.0, 0.0, 0.1)
    return Friction(0.0, 0.02, 0.4, 0.02) if elongation < NEARLY_ROUND else Friction(-0.5, 0.5, 0.0, 1.0)


def sticking(
    seen: ImpactQuantities, rows: np.ndarray, push: Friction, impacts: Impacts, long: float
) -> tuple[ImpactQuantities, np.ndarray, Friction]:
    """The impacts that stick, if all but a few do: kick + slip + turn is then the tilt's."""
    if push.turn_sd == 0 or len(rows) < 5:
        return seen, rows, push
    off, spread = _off_and_spread((seen.kick + seen.slip + seen.turn)[rows])
    usual = 0.3 * float(np.std(seen.turn[rows]))
    if push.turn_sd <= 0.05:  # a ball's angular momentum is a law of its own, and better but for what roughness does to it
        usual = 0.4 * _off_and_spread((seen.kick - push.turn * seen.turn)[rows])[1]
    holds = off < STUCK_SD * spread
    if holds.mean() < 0.6 or spread > usual:
        return seen, rows, push
    # −1 up to the radius's variation and the spin's noise
    return stuck(seen, impacts), rows[holds], Friction(STUCK, 0.0, -1 + 0.3 * long, 0.03 + 0.7 * long)


def stuck(seen: ImpactQuantities, impacts: Impacts) -> ImpactQuantities:
    """Slip v_x/Δv_n and turn h ω'/Δv_n of contacts that stick: v_x' + h ω' = α v_z'."""
    slip = impacts.before[:, 0] / (impacts.after[:, 1] - impacts.before[:, 1])
    return replace(seen, slip=slip, turn=seen.turn + seen.slip - slip, kick_error=seen.kick_error + seen.spin_error)


def _off_and_spread(left: np.ndarray) -> tuple[np.ndarray, float]:
    off = np.abs(left - np.median(left))
    return off, max(1.4826 * float(np.median(off)), KICK_FLOOR)
