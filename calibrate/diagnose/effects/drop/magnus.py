"""Magnus force: spin times speed pushes a seed sideways."""

import numpy as np

from calibrate.diagnose.effects.effect import Effect, Motion


def acceleration(motion: Motion, value: float) -> np.ndarray:
    """a = C (ρ A r/2m) ω × v, C = `value` [-], ω anticlockwise in the picture: ω × v = ω (−v_z, v_x)."""
    vx, vz = motion.velocity[..., 0], motion.velocity[..., 1]
    return value * (motion.lift * motion.spin)[..., None] * np.stack([-vz, vx], axis=-1)


EFFECT = Effect(
    name="magnus", sector="flight", unit="1", meaning="C in a = C (rho A r / 2 m) omega x v", prior_sd=1.0, low=-5.0, high=5.0,
    source="Rubinow, Keller (1961), J. Fluid Mech. 11, 447 (C = 2); Oesterlé, Bui Dinh (1998), Exp. Fluids 25, 16 (0.2 to 1)",
    twins=("draught",), separating="drops that spin the other way: a draught does not turn with the spin", needs="spin",
    acceleration=acceleration,
)  # fmt: skip
