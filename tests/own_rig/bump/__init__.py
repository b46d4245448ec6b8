"""A seed on a thread swings against a wall: how far does it swing back?"""

from benchtwin.rigs.bump.keys import Bump

from benchtwin.bench.rig import Rig

RIG = Rig(
    name="bump",
    what="a seed on a thread swings against a wall",
    keys=Bump,
    main=("swing_back", "deg"),
    readings={"swing_back_deg": ("swing_back", "deg")},
    tells=".tells:TELLS",
)
