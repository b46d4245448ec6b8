"""Heaps: what surfaces in photos tell of cohesion, walls, gate, shaking, tilt and
shape."""

from benchtwin.bench.rig import Rig
from benchtwin.rigs.pile.keys import Pile

RIG = Rig(
    name="pile",
    what="a heap",
    plural="heaps",
    keys=Pile,
    order=4,
    main=("repose_angle", "deg"),
    printed=(("repose_angle", "height_over_radius_angle"), ("centroid_angle",)),
    readings={
        "repose_angle_deg": ("repose_angle", "deg"),
        "centroid_angle_deg": ("centroid_angle", "deg"),
    },
    told_by={"photos": "a photo shows what is at rest"},
    corrected_in=(),
    variants={"cylinder": {"pile": {"cylinder_mm": [70.0, 150.0]}}},
    per_recording=("baseline_px", "photo_s", "roi_px"),
    weighed=("filled_mass_g", "retained_mass_g"),
    observe=".observe:observe_pile",
    setup=".simulate:SETUP",
    curve=".read:curve",
    read=".read:read_piles",
    diagnose=".diagnose:diagnose_pile",
    effects=".effects:EFFECTS",
    resimulate=".resimulation:resimulate",
    tells=".tells:TELLS",
)
