"""Air drag where the recording states no air: against the motion, with the drag coefficient of a ball of the seed's size."""

import numpy as np

from calibrate.diagnose.air import drag_shape
from calibrate.diagnose.effects.effect import Effect

REFERENCE_SPEED_M_S = 0.5


def resistance(speed: np.ndarray, value: float, reynolds_per_speed: float, exponent: float = 0.0) -> np.ndarray:
    """Over weight: `value` at 0.5 m/s, as C_d(Re) v² elsewhere, times (v/0.5 m/s)^`exponent`; speed [m/s].

    A plate beside it and its own shape bend a seed's C_d(Re) away from a ball's.
    """
    over = speed / REFERENCE_SPEED_M_S
    at_half = drag_shape(REFERENCE_SPEED_M_S, reynolds_per_speed)
    return value * drag_shape(speed, reynolds_per_speed) * over / at_half * np.maximum(over, 1e-6) ** exponent


EFFECT = Effect(
    name="drag", sector="run-out", unit="1", meaning="drag force over weight at 0.5 m/s", prior_sd=0.015, low=0.0, high=0.5,
    source="Clift, Gauvin (1971); a soybean has 0.002, a wheat grain 0.004 at 0.5 m/s", twins=("viscous-rolling",),
    separating="the same roll from a longer incline: drag grows as the square of speed, viscous rolling as speed",
)  # fmt: skip
EXPONENT = Effect(
    name="drag.exponent", sector="run-out", unit="1", meaning="power of speed beside that of a ball's drag", prior_sd=0.25,
    low=-1.0, high=1.0, source="a ball's C_d(Re) v² grows as v^1.5 at Re 100, as v^2 from 1000 on", group="drag",
)  # fmt: skip
