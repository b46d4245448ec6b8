"""Drops: how a seed falls, and how it bounces."""

from benchtwin.rigs.rig import Rig

RIG = Rig(
    name="drop",
    measure="benchtwin.vision.motion.rebound:measure_rebound",
    read="benchtwin.twin.tracks:read_drops",
    diagnose=f"{__name__}.diagnose:diagnose_drop",
    effects=f"{__name__}.effects:EFFECTS",
    resimulate=f"{__name__}.resimulation:resimulate",
)
