"""Slides: when a seed begins to move, and how it goes on."""

from benchtwin.bench.rig import Rig
from benchtwin.rigs.slide.keys import Slide

ON_SEEDS = "seed-slide"  # the variant on a plate of seeds

RIG = Rig(
    name="slide",
    what="a plate is raised",
    keys=Slide,
    order=2,
    main=("slide_angle", "deg"),
    printed=(("static_friction", "slide_angle"),),
    readings={"slide_angle_deg": ("slide_angle", "deg")},
    gate_place="x_mm",
    wanted=(("camera", "plumb_deg"),),
    asked=(
        (
            "[slide] tilt_rate_deg_s, start_deg",
            "how fast was the plate raised, and at what angle did it start?",
        ),
    ),
    corrected_in=("reading", "track"),
    per_recording=("start_deg", "plate_photo"),
    variants={ON_SEEDS: {"slide": {"plate": "seeds"}}},
    not_diagnosed={
        ON_SEEDS: "a diagnosis does not judge plates of seeds yet; a calibration does"
    },
    own_parameters=True,
    observe=".observe:observe_slide",
    refuse=".on_seeds:card_unknown",
    derive=".equation:static_friction",
    setup=".simulate:SETUP",
    curve=".read:curve",
    read=".read:read_slides",
    diagnose=".diagnose:diagnose_slide",
    effects=".effects:EFFECTS",
    resimulate=".resimulation:resimulate",
    tells=".tells:TELLS",
)
