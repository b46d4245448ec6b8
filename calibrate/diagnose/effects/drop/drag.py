"""Air drag beyond what the recording states: quadratic, with the stated seed's C_d(Re)."""

import numpy as np

from calibrate.diagnose.air import drag_shape, speed_through_air
from calibrate.diagnose.effects.effect import Effect, Motion


def acceleration(motion: Motion, value: float | np.ndarray) -> np.ndarray:
    """a = −value g s(|v|) v: `value`, one or (f, 1, 1), is drag over weight at 2 m/s [-], s of air.drag_shape [s/m]."""
    speed = speed_through_air(motion.velocity, motion.aside_square)
    return -value * motion.g * drag_shape(speed, motion.reynolds[..., None], motion.slope) * motion.velocity


EFFECT = Effect(
    name="drag", sector="flight", unit="1", meaning="drag force over weight at 2 m/s", prior_sd=0.04, low=0.0, high=0.5,
    source="Clift, Gauvin (1971); a soybean has 0.018, a wheat grain 0.03, a table-tennis ball 0.16",
    separating="a drop from twice the height: drag grows with speed, a wrong scale or clock does not",
    acceleration=acceleration,
)  # fmt: skip
