"""Seeds that flow in a drum."""

from benchtwin.bench.rig import Rig
from benchtwin.rigs.drum.keys import Drum

RIG = Rig(
    name="drum",
    what="seeds flow in a drum that turns",
    keys=Drum,
    order=5,
    main=("flowing_angle", "deg"),
    printed=(("flowing_angle",),),
    readings={"flowing_angle_deg": ("flowing_angle", "deg")},
    observe=".observe:observe_drum",
    setup=".simulate:SETUP",
    tells=".tells:TELLS",
)
