"""Draught: the air moves along x, the same in every recording."""

import numpy as np

from calibrate.diagnose.air import drag_shape, speed_through_air
from calibrate.diagnose.effects.effect import Effect, Motion


def acceleration(motion: Motion, value: float) -> np.ndarray:
    """a = −k(|v − u|)(v − u) + k(|v|) v with the drag of the stated seed in room air, u = (`value`, 0) [m/s]."""
    wind = np.array([value, 0.0])

    def drag(velocity):
        speed = speed_through_air(velocity, motion.aside_square)
        return -(motion.room * motion.g)[..., None] * drag_shape(speed, motion.reynolds[..., None], motion.slope) * velocity

    return drag(motion.velocity - wind) - drag(motion.velocity)


EFFECT = Effect(
    name="draught", sector="flight", unit="m/s", meaning="wind along x", prior_sd=0.3, low=-6.0, high=6.0,
    source="drag with v − u; ventilated rooms have 0.1 to 0.5 m/s (ISO 7730)",
    twins=("camera-roll", "magnus"), separating="a plumb line in the picture; a drop behind a screen",
    acceleration=acceleration,
)  # fmt: skip
