"""Shape conversion: the seed is much less round than stated, so that spin and translation exchange in every impact.

The contact lies b beside the centre, I Δω = b J_n + h J_t. It has no parameter; it shows in b itself where the spin is seen, and
else in the scatter of the sideways kicks: an alternative of the whole baseline.
"""

from diagnose.effects.effect import Effect

REACH = 0.45  # rms of b over (longest − shortest half axis) of ellipsoids that land anyhow: .37 to .41 in 3-D
ROUGH = 0.02  # of the radius: what roughness does to b of a ball

SHAPE = Effect(
    name="shape-conversion", sector="impact", unit="", meaning="the seed is much less round than stated", prior_sd=1.0, low=0.0,
    high=10.0, source="angular momentum about the point of contact", separating="callipers on the seeds that were dropped",
    says=("the seed's shape turns fall into spin more than allowed for", ""),
    untwinned="shape is the twin's own already: its seeds are not spheres",
)  # fmt: skip
EFFECTS = (SHAPE,)
