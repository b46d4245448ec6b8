"""Slides: when a seed begins to move, and how it goes on."""

from benchtwin.rigs.rig import Rig

RIG = Rig(
    name="slide",
    measure=f"{__name__}.measure:measure_slide",
    read="benchtwin.twin.slides:read_slides",
    diagnose=f"{__name__}.diagnose:diagnose_slide",
    effects=f"{__name__}.effects:EFFECTS",
    resimulate=f"{__name__}.resimulation:resimulate",
)
