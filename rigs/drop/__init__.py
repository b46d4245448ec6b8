"""Drops: how a seed falls, and how it bounces."""

from benchtwin.bench.rig import Rig
from benchtwin.rigs.drop.keys import Drop

ON_SEEDS = "seed-drop"  # the variant on a plate of seeds

RIG = Rig(
    name="drop",
    what="a seed falls on a plate",
    keys=Drop,
    order=1,
    main=("restitution", "1"),
    printed=(
        ("restitution", "restitution_normal", "rebound_height", "fall_acceleration"),
    ),
    readings={"rebound_height_mm": ("rebound_height", "mm")},
    by_row=("height_mm",),
    in_turn=("bounce", "height_mm"),
    per_recording=(
        "height_sd_mm",
        "impacts_added_s",
        "impacts_struck_s",
        "hold_s",
        "plate_photo",
    ),
    told_by={
        "sound": "a sound tells the impacts of a drop",
        "impacts.csv": "times of impacts belong to a drop",
    },
    gate_place="y_mm",
    wanted=(("camera", "mm_per_px"), ("drop", "height_mm")),
    asked=(
        (
            "[drop] height_mm",
            "from which height was it released (lowest point of the seed to plate, in"
            " mm)?",
        ),
    ),
    variants={ON_SEEDS: {"drop": {"plate": "seeds"}}},
    not_diagnosed={
        ON_SEEDS: "a diagnosis does not judge plates of seeds yet; a calibration does"
    },
    own_parameters=True,
    observe=".observe:observe_drop",
    heard=".with_sound:sound_observation",
    moves=".read:falls",
    refuse=".on_seeds:height_unknown",
    derive=".equation:restitution",
    setup=".simulate:SETUP",
    curve=".read:curve",
    read=".read:read_drops",
    diagnose=".diagnose:diagnose_drop",
    effects=".effects:EFFECTS",
    resimulate=".resimulation:resimulate",
    tells=".tells:TELLS",
)
