"""Single seeds that fall onto a bed of seeds."""

from benchtwin.bench.rig import Rig
from benchtwin.rigs.bed.keys import Bed

RIG = Rig(
    name="bed",
    what="a seed falls onto a bed of seeds",
    plural="drops on beds",
    keys=Bed,
    order=7,
    main=("bed_rebound", "mm"),
    printed=(("bed_rebound",), ("apparent_restitution",)),
    readings={"bed_rebound_mm": ("bed_rebound", "mm")},
    zeros=("bed_rebound_mm",),
    by_row=("height_mm",),
    wanted=(("camera", "mm_per_px"), ("bed", "height_mm")),
    asked=(
        (
            "[bed] height_mm",
            "from which height was it released (lowest point of the seed to the bed's"
            " surface, in mm)?",
        ),
    ),
    observe=".observe:observe_bed",
    derive=".equation:apparent_restitution",
    setup=".simulate:SETUP",
    tells=".tells:TELLS",
)
