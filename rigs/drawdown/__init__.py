"""A box of seeds that empties through a slot onto a tray below."""

from benchtwin.bench.rig import Rig
from benchtwin.rigs.drawdown.keys import Drawdown

RIG = Rig(
    name="drawdown",
    what="a box of seeds empties through a slot",
    plural="draw-downs",
    keys=Drawdown,
    order=6,
    main=("shear_angle", "deg"),
    printed=(("shear_angle",), ("heap_angle",), ("flow_time",), ("mass_flow",)),
    readings={
        "shear_angle_deg": ("shear_angle", "deg"),
        "shear_centroid_deg": ("shear_centroid", "deg"),
        "heap_angle_deg": ("heap_angle", "deg"),
        "heap_centroid_deg": ("heap_centroid", "deg"),
        "flow_time_s": ("flow_time", "s"),
    },
    corrected_in=(),
    asked=(
        ("[drawdown] slot_mm", "how far does the shelf end before the end wall?"),
        (
            "[drawdown] pane_friction",
            "which static friction do seeds have on the panes (slides on a piece of"
            " one)?",
        ),
    ),
    per_recording=(
        *("upper_px", "lower_px", "shelf_px", "tray_px", "photo_s", "flow_time_s"),
        *("tray_mass_g", "spilt_mass_g", "jammed"),
    ),
    weighed=("filled_mass_g", "retained_mass_g"),
    observe=".observe:observe_drawdown",
    refuse=".jamming:jammed",
    together=".jamming:jamming",
    setup=".simulate:SETUP",
    tells=".tells:TELLS",
)
