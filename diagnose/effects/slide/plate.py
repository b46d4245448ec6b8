"""How the plate itself moves: it is raised in stairs, or its drive shakes it along its slope.

Stairs: the angle rests at a stair and jumps to the next; a block lets go at the foot of one. Shaken: at the worst phase of the wave
the block lets go while the mean pull is still a below its friction, slips, and sticks again, each wave a little farther, until the
mean pull is up to the friction; from then on it slides without a stop, and is faster than a block that has only just let go.
"""

import math

from diagnose.effects.effect import Effect

HERTZ = 30.0  # about which ln-hertz counts

STEPPED = Effect(
    name="stepped-tilt", sector="measurement", unit="deg", meaning="step", prior_sd=0.5, low=0.0, high=10.0,
    source="ratchets, steppers", says=("the plate is raised in stairs", "°"), untwinned="the twin's plate turns evenly",
    separating="the same slide with the plate raised without a stop, its angle recorded to a hundredth of a degree",
    needs=lambda session: False,  # an alternative of the whole baseline, not a slope about nil
)  # fmt: skip
SHAKEN = Effect(
    name="plate-vibration", sector="sliding", unit="m/s^2", meaning="amplitude", prior_sd=0.5, low=0.0, high=20.0,
    source="stepper drives; the slips of a block on a shaken slope: stick while g sin θ + a sin ωt < μ g cos θ", bent=True,
    says=("the plate vibrates", "m/s²"), untwinned="its frequency was not recorded", needs=lambda session: bool(session.runs),
    separating="the same slide with the plate raised by hand, the drive off",
    act=lambda laws, run, value: laws._replace(shake=max(value, 0.0)),
)  # fmt: skip
EFFECTS = (
    STEPPED, SHAKEN,
    Effect(
        name="plate-vibration.ln-hertz", sector="sliding", unit="1", meaning="ln of the frequency over 30 Hz", prior_sd=0.7,
        low=-3.0, high=3.0, source="motors, gears and steppers shake at 10 to 100 Hz", group="plate-vibration", sized=False,
        act=lambda laws, run, value: laws._replace(omega=2 * math.pi * HERTZ * math.exp(min(max(value, -6.0), 6.0))),
    ),
)  # fmt: skip
