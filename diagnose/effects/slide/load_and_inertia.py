"""Load and inertia of the block: a pull towards the plate, partial rolling."""

import numpy as np

from diagnose.effects.effect import Effect

_NOTHING = "nothing in the twin stands for it"

EFFECTS = (
    Effect(
        name="adhesion", sector="onset", unit="mN", meaning="pull", prior_sd=1.5, low=0.0, high=30.0,
        source="tan θ_s = μ + μ F/(m g cos θ): the offset goes as 1/load", not_simulated=_NOTHING,
        wording=("something pulls the seeds to the plate", "mN"),
        separating="the same slide with one seed and with eight seeds taped together: a pull counts for less the heavier the block",
        act=lambda laws, run, value: laws._replace(press=laws.press + value / run.mass_g),
        needs=lambda session: bool(np.isfinite(session.masses).all()),
    ),
    Effect(
        name="partial-rolling", sector="sliding", unit="1", meaning="added inertia over mass", prior_sd=0.2, low=0.0, high=1.0,
        source="a seed that comes loose rolls: I/mr² = 2/5 of a ball", not_simulated=_NOTHING,
        wording=("the block rolls in part", "= added inertia over mass"), needs=lambda session: bool(session.runs),
        separating="the same block filmed from the side with a mark on it, and a ruler in the picture: turning against scale",
        act=lambda laws, run, value: laws._replace(inertia=laws.inertia + value),
    ),
)  # fmt: skip
