"""Magnus force: spin times speed pushes a seed sideways."""

import numpy as np

from calibrate.diagnose.effects.effect import Effect, Motion


def acceleration(motion: Motion, value: float) -> np.ndarray:
    """a = C (ρ A r/2m) ω × v, C = `value` [-], ω anticlockwise in the picture: ω × v = ω (−v_z, v_x).

    A seed that rolled off towards the camera is lifted as well, by what its speed that way and the usual spin with it say.
    """
    vx, vz = motion.velocity[..., 0], motion.velocity[..., 1]
    unseen = (motion.rolled * motion.aside_square)[..., None] * np.array([0.0, 1.0])
    return value * motion.lift[..., None] * (motion.spin[..., None] * np.stack([-vz, vx], axis=-1) + unseen)


EFFECT = Effect(
    name="magnus", sector="flight", unit="1", meaning="C in a = C (rho A r / 2 m) omega x v", prior_sd=1.0, low=-10.0, high=10.0,
    source="Rubinow, Keller (1961), J. Fluid Mech. 11, 447 (C = 2); Oesterlé, Bui Dinh (1998), Exp. Fluids 25, 16 (0.2 to 1)",
    twins=("draught",), separating="drops that spin the other way: a draught does not turn with the spin", needs="spin",
    acceleration=acceleration,
)  # fmt: skip
