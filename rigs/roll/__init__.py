"""A seed that rolls down an incline and out on the level."""

from benchtwin.bench.rig import Rig
from benchtwin.rigs.roll.keys import Roll

RIG = Rig(
    name="roll",
    what="a seed rolls and runs out",
    keys=Roll,
    order=3,
    main=("run_out", "mm"),
    printed=(
        ("rolling_resistance", "rolling_friction", "run_out", "acceleration"),
        ("slope",),
    ),
    readings={"run_out_mm": ("run_out", "mm")},
    by_row=("incline_deg", "incline_length_mm"),
    gate_place="x_mm",
    wanted=(
        ("camera", "mm_per_px"),
        ("roll", "incline_deg"),
        ("roll", "incline_length_mm"),
    ),
    asked=(
        (
            "[roll] incline_deg, incline_length_mm",
            "how steep and how long was the incline?",
        ),
    ),
    per_recording=("direction",),
    by_turns=({"direction": "+x"}, {"direction": "-x"}),
    observe=".observe:observe_roll",
    moves=".roll_path:rolls",
    derive=".equation:friction_of_run_out",
    together=".plate_slope:plate_slopes",
    setup=".simulate:SETUP",
    curve=".read:curve",
    read=".read:read_rolls",
    diagnose=".diagnose:diagnose_roll",
    effects=".effects:EFFECTS",
    resimulate=".resimulation:resimulate",
    tells=".tells:TELLS",
)
