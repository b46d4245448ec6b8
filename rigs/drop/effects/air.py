"""Forces of the air on a seed in flight: drag beyond what is stated, a draught, Magnus
lift."""

import numpy as np

from benchtwin.bench.air import (
    REFERENCE_SPEED_M_S,
    drag_over_mass,
    drag_shape,
    speed_through_air,
)
from benchtwin.infer.effect import Counterpart, Effect
from benchtwin.rigs.drop.effects.hooks import Motion, slowed


def draught_acceleration(motion: Motion, value: float) -> np.ndarray:
    """Drag of the stated seed in room air with v − u less that with v, u = (`value`, 0)
    [m/s]."""
    wind = np.array([value, 0.0])

    def drag(velocity):
        speed = speed_through_air(velocity, motion.aside_square)
        return (
            -(motion.room * motion.g)[..., None]
            * drag_shape(speed, motion.reynolds[..., None], motion.slope)
            * velocity
        )

    return drag(motion.velocity - wind) - drag(motion.velocity)


def magnus_acceleration(motion: Motion, value: float) -> np.ndarray:
    """a = C (ρ A r/2m) ω × v, C = `value` [-], with the usual spin about the line of
    sight."""
    vx, vz = motion.velocity[..., 0], motion.velocity[..., 1]
    unseen = (motion.rolled * motion.aside_square)[..., None] * np.array([0.0, 1.0])
    return (
        value
        * motion.lift[..., None]
        * (motion.spin[..., None] * np.stack([-vz, vx], axis=-1) + unseen)
    )


EFFECTS = (
    Effect(
        name="drag",
        sector="flight",
        unit="1",
        meaning="drag force over weight at 2 m/s",
        prior_sd=0.04,
        low=0.0,
        high=0.5,
        source=(
            "Clift, Gauvin (1971); a soybean has 0.018, a wheat grain 0.03, a"
            " table-tennis ball 0.16"
        ),
        wording=("air drag is missing", "of the weight at 2 m/s"),
        acceleration=drag_over_mass,
        restitution=slowed,
        nonlinear=True,
        separating=(
            "a drop from twice the height: drag grows with speed, a wrong scale or"
            " clock does not"
        ),
        counterpart=Counterpart(
            "the air's drag law is on, with drag over weight at 2 m/s {value} more than"
            " stated",
            lambda v: {"air": {"share": v["drag"], "at_m_s": REFERENCE_SPEED_M_S}},
        ),
    ),
    Effect(
        name="draught",
        sector="flight",
        unit="m/s",
        meaning="wind along x",
        prior_sd=0.3,
        low=-6.0,
        high=6.0,
        source="drag with v − u; ventilated rooms have 0.1 to 0.5 m/s (ISO 7730)",
        wording=("a draught is missing", "m/s along x"),
        acceleration=draught_acceleration,
        nonlinear=True,  # faster than the seed it blows as its square
        separating="a plumb line in the picture; a drop behind a screen",
        counterpart=Counterpart(
            "the air moves at {value} m/s along x",
            lambda v: {"air": {"wind_x": v["draught"]}},
        ),
    ),
    Effect(
        name="magnus",
        sector="flight",
        unit="1",
        meaning="C in a = C (rho A r / 2 m) omega x v",
        prior_sd=1.0,
        low=-10.0,
        high=10.0,
        source=(
            "Rubinow, Keller (1961), J. Fluid Mech. 11, 447 (C = 2); Oesterlé, Bui Dinh"
            " (1998), Exp. Fluids 25, 16 (0.2 to 1)"
        ),
        wording=(
            "a side force from the spin (Magnus) is missing",
            "= C in C (ρ A r/2m) ω × v",
        ),
        acceleration=magnus_acceleration,
        needs=lambda session: session.spins,
        separating=(
            "drops that spin the other way: a draught does not turn with the spin"
        ),
        counterpart=Counterpart(
            "the Magnus law is on with C = {value}",
            lambda v: {"air": {"lift": v["magnus"]}},
        ),
    ),
)
