"""The effects that solver and proof both know: of each its sectors, unit and sign, rig
by rig."""

from dataclasses import dataclass

RESTITUTION = (
    "restitution-falls-with-speed",
    "viscoelastic-restitution",
    "plastic-restitution",
    "plate-compliance",
)


@dataclass(frozen=True)
class Effect:
    """One effect. unit None: reported without a parameter. either: its sign depends on
    the choice of axes; sizes are compared."""

    sectors: tuple[str, ...]
    unit: str | None
    either: bool = False


EFFECTS: dict[str, dict[str, Effect]] = {
    "drop": {
        "drag": Effect(("flight",), "1"),
        "magnus": Effect(("flight",), "1", True),
        "draught": Effect(("flight",), "m/s", True),
        "restitution-falls-with-speed": Effect(("impact",), "1"),
        "viscoelastic-restitution": Effect(("impact",), "1"),
        "plastic-restitution": Effect(("impact",), "1"),
        "film-adhesion": Effect(("impact",), "m/s"),
        "impact-damage": Effect(("impact",), "1"),
        "plate-tilt": Effect(("impact",), "deg", True),
        "plate-compliance": Effect(("impact",), "1"),
        "shape-conversion": Effect(("impact",), None),
        "scale-error": Effect(("measurement",), "1"),
        "clock-error": Effect(("measurement",), "1"),
        "camera-roll": Effect(("measurement",), "deg", True),
        "perspective": Effect(("measurement",), "1/m", True),
        "silhouette-wobble": Effect(("measurement",), "mm", True),
    },
    "slide": {
        "kinetic-friction": Effect(("onset", "sliding"), "1"),
        "stribeck": Effect(("sliding", "onset"), "1"),
        "viscous-sliding": Effect(("sliding",), "s/m"),
        "adhesion": Effect(("onset", "sliding"), "mN"),
        "reading-delay": Effect(("measurement", "onset"), "mm"),
        "clock-offset": Effect(("measurement", "onset"), "s", True),
        "angle-offset": Effect(("measurement", "onset"), "deg", True),
        "plate-vibration": Effect(("onset", "sliding"), "m/s^2"),
        "partial-rolling": Effect(("sliding",), "1"),
        "stepped-tilt": Effect(("measurement", "onset", "sliding"), "deg"),
    },
    "roll": {
        "viscous-rolling": Effect(("run-out",), "s/m"),
        "slope": Effect(("run-out",), "deg", True),
        "initial-slip": Effect(("onset", "run-out"), "m/s"),
        "corner-loss": Effect(("onset", "run-out"), "1"),
        "shape-barrier": Effect(("run-out",), "mm"),
        "drag": Effect(("run-out",), "1"),
    },
    "pile": {
        "cohesion": Effect(("crest", "toe"), None),
        "wall-friction": Effect(("middle",), None),
        "gate-speed": Effect(("toe", "crest"), None),
        "base-vibration": Effect(("toe", "crest"), None),
        "base-tilt": Effect(("measurement",), "deg", True),
        "particle-shape": Effect(("middle",), None),
        "camera-roll": Effect(("measurement",), "deg", True),
    },
}

# the parameter of a rig that may follow a condition, and where that shows
FOLLOWING = {
    "drop": ("restitution", ("impact",)),
    "slide": ("static_friction", ("onset", "sliding")),
    "roll": ("rolling_friction", ("run-out",)),
}

# what nobody listed, and the sectors where it shows
OUTSIDE: dict[str, dict[str, tuple[str, ...]]] = {
    "drop": {
        "updraught": ("flight",),  # rising air, faster with height
        "field": ("flight",),  # a sideways pull that grows with the distance
        "oriented-restitution": ("impact",),  # e depends on how the seed lands
        "clock-drift": ("measurement",),  # the frame rate drifts
        # restitution goes with the order of the recordings
        "order-drift": FOLLOWING["drop"][1],
    },
    # friction grows with the travel
    "slide": {"worn-track": ("sliding",), "order-drift": FOLLOWING["slide"][1]},
    # a stretch of the plate resists more
    "roll": {"sticky-patch": ("run-out",), "order-drift": FOLLOWING["roll"][1]},
    # two kinds of grains: the flank breaks half way up
    "pile": {"layered": ("middle",)},
}
