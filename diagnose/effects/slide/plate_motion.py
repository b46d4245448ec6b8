"""Motion of the plate: raised in steps, or shaken along its slope.

A shaken block slips while the mean pull is still below friction, each wave a little farther; once
it reaches friction the block slides on, faster than one that has only just let go.
"""

import math

from diagnose.effects.effect import Effect

HERTZ = 30.0  # reference of ln-hertz

STEPPED = Effect(
    name="stepped-tilt", sector="measurement", unit="deg", meaning="step", prior_sd=0.5, low=0.0, high=10.0,
    source="ratchets, steppers", wording=("the plate is raised in stairs", "°"), not_simulated="the twin's plate turns evenly",
    separating="the same slide with the plate raised without a stop, its angle recorded to a hundredth of a degree",
    needs=lambda session: False,  # an alternative of the whole baseline
)  # fmt: skip
SHAKEN = Effect(
    name="plate-vibration", sector="sliding", unit="m/s^2", meaning="amplitude", prior_sd=0.5, low=0.0, high=20.0,
    source="stepper drives; the slips of a block on a shaken slope: stick while g sin θ + a sin ωt < μ g cos θ", nonlinear=True,
    wording=("the plate vibrates", "m/s²"), not_simulated="its frequency was not recorded", needs=lambda session: bool(session.runs),
    separating="the same slide with the plate raised by hand, the drive off",
    act=lambda laws, run, value: laws._replace(shake=max(value, 0.0)),
)  # fmt: skip
EFFECTS = (
    STEPPED, SHAKEN,
    Effect(
        name="plate-vibration.ln-hertz", sector="sliding", unit="1", meaning="ln of the frequency over 30 Hz", prior_sd=0.7,
        low=-3.0, high=3.0, source="motors, gears and steppers shake at 10 to 100 Hz", group="plate-vibration", scaled_prior=False,
        act=lambda laws, run, value: laws._replace(omega=2 * math.pi * HERTZ * math.exp(min(max(value, -6.0), 6.0))),
    ),
)  # fmt: skip
