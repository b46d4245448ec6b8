"""A seed much less round than stated exchanges spin and translation: an alternative baseline."""

from diagnose.effects.effect import Effect

REACH = 0.45  # rms of b over (a − c) of ellipsoids in any attitude: 0.37 to 0.41 in 3-D
ROUGH = 0.02  # of the radius: b of a rough ball

SHAPE = Effect(
    name="shape-conversion", sector="impact", unit="", meaning="the seed is much less round than stated", prior_sd=1.0, low=0.0,
    high=10.0, source="angular momentum about the point of contact", separating="callipers on the seeds that were dropped",
    wording=("the seed's shape turns fall into spin more than allowed for", ""),
    not_simulated="shape is the twin's own already: its seeds are not spheres",
)  # fmt: skip
EFFECTS = (SHAPE,)
