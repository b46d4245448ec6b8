"""Rolls: down an incline, over a corner, along a level plate until the seed stops."""

from benchtwin.rigs.rig import Rig

RIG = Rig(
    name="roll",
    measure=f"{__name__}.measure:measure_roll",
    read="benchtwin.twin.roll_tracks:read_rolls",
    diagnose=f"{__name__}.diagnose:diagnose_roll",
    effects=f"{__name__}.effects:EFFECTS",
    resimulate=f"{__name__}.resimulation:resimulate",
)
