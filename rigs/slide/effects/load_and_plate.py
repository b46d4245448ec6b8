"""Load of the block, partial rolling; a plate raised in steps, or shaken along its
slope.

A shaken block slips while the mean pull is still below friction, each wave a little
farther; once it reaches friction the block slides on, faster than one that has only
just let go."""

import math

import numpy as np

from benchtwin.infer.effect import Effect
from benchtwin.rigs.slide.session import lets_go

_NOTHING = "nothing in the twin stands for it"

HERTZ = 30.0  # reference of ln-hertz

STEPPED = Effect(
    name="stepped-tilt",
    sector="measurement",
    unit="deg",
    meaning="step",
    prior_sd=0.5,
    low=0.0,
    high=10.0,
    source="ratchets, steppers",
    wording=("the plate is raised in stairs", "°"),
    not_simulated="the twin's plate turns evenly",
    separating=(
        "the same slide with the plate raised without a stop, its angle recorded to a"
        " hundredth of a degree"
    ),
    needs=lambda session: False,  # an alternative of the whole baseline
)
SHAKEN = Effect(
    name="plate-vibration",
    sector="sliding",
    unit="m/s^2",
    meaning="amplitude",
    prior_sd=0.5,
    low=0.0,
    high=20.0,
    source=(
        "stepper drives; the slips of a block on a shaken slope: stick while g sin θ +"
        " a sin ωt < μ g cos θ"
    ),
    nonlinear=True,
    wording=("the plate vibrates", "m/s²"),
    not_simulated="its frequency was not recorded",
    needs=lets_go,
    separating="the same slide with the plate raised by hand, the drive off",
    act=lambda laws, run, value: laws._replace(shake=max(value, 0.0)),
)
EFFECTS = (
    Effect(
        name="adhesion",
        sector="onset",
        unit="mN",
        meaning="pull",
        prior_sd=1.5,
        low=0.0,
        high=30.0,
        source="tan θ_s = μ + μ F/(m g cos θ): the offset goes as 1/load",
        not_simulated=_NOTHING,
        wording=("something pulls the seeds to the plate", "mN"),
        separating=(
            "the same slide with one seed and with eight seeds taped together: a pull"
            " counts for less the heavier the block"
        ),
        act=lambda laws, run, value: laws._replace(
            press=laws.press + value / run.mass_g
        ),
        needs=lambda session: bool(np.isfinite(session.masses).all()),
    ),
    Effect(
        name="partial-rolling",
        sector="sliding",
        unit="1",
        meaning="added inertia over mass",
        prior_sd=0.2,
        low=0.0,
        high=1.0,
        source="a seed that comes loose rolls: I/mr² = 2/5 of a ball",
        not_simulated=_NOTHING,
        wording=("the block rolls in part", "= added inertia over mass"),
        needs=lets_go,
        separating=(
            "the same block filmed from the side with a mark on it, and a ruler in the"
            " picture: turning against scale"
        ),
        act=lambda laws, run, value: laws._replace(inertia=laws.inertia + value),
    ),
    STEPPED,
    SHAKEN,
    Effect(
        name="plate-vibration.ln-hertz",
        sector="sliding",
        unit="1",
        meaning="ln of the frequency over 30 Hz",
        prior_sd=0.7,
        low=-3.0,
        high=3.0,
        source="motors, gears and steppers shake at 10 to 100 Hz",
        group="plate-vibration",
        scaled_prior=False,
        act=lambda laws, run, value: laws._replace(
            omega=2 * math.pi * HERTZ * math.exp(min(max(value, -6.0), 6.0))
        ),
    ),
)
