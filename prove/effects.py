"""The vocabulary that solver and proof share: per rig, each effect's sectors, unit, sign, and what it may be confused with."""

from dataclasses import dataclass

RESTITUTION = ("restitution-falls-with-speed", "viscoelastic-restitution", "plastic-restitution", "plate-compliance")


@dataclass(frozen=True)
class Effect:
    """unit None: reported without a parameter. either: the sign is a matter of axes, values are compared in size."""

    sectors: tuple[str, ...]
    unit: str | None
    either: bool = False
    confusable: tuple[str, ...] = ()


EFFECTS: dict[str, dict[str, Effect]] = {
    "drop": {
        "drag": Effect(("flight",), "1"),
        "magnus": Effect(("flight",), "1", True, ("draught",)),
        "draught": Effect(("flight",), "m/s", True, ("camera-roll", "magnus")),
        "restitution-falls-with-speed": Effect(("impact",), "1", False, RESTITUTION),
        "viscoelastic-restitution": Effect(("impact",), "1", False, RESTITUTION),
        "plastic-restitution": Effect(("impact",), "1", False, RESTITUTION),
        "film-adhesion": Effect(("impact",), "m/s", False, ("impact-damage",)),
        "impact-damage": Effect(("impact",), "1", False, ("film-adhesion",)),
        "plate-tilt": Effect(("impact",), "deg", True),
        "plate-compliance": Effect(("impact",), "1", False, RESTITUTION),
        "shape-conversion": Effect(("impact",), None),
        "scale-error": Effect(("measurement",), "1", False, ("clock-error",)),
        "clock-error": Effect(("measurement",), "1", False, ("scale-error",)),
        "camera-roll": Effect(("measurement",), "deg", True, ("draught",)),
        "perspective": Effect(("measurement",), "1/m", True, ("scale-error",)),
        "silhouette-wobble": Effect(("measurement",), "mm", True),
    },
    "slide": {
        "kinetic-friction": Effect(("onset", "sliding"), "1", False, ("stribeck",)),
        "stribeck": Effect(("sliding", "onset"), "1", False, ("kinetic-friction",)),
        "viscous-sliding": Effect(("sliding",), "s/m"),
        "adhesion": Effect(("onset", "sliding"), "mN"),
        "reading-delay": Effect(("measurement", "onset"), "mm", False, ("stepped-tilt",)),
        "clock-offset": Effect(("measurement", "onset"), "s", True, ("angle-offset",)),
        "angle-offset": Effect(("measurement", "onset"), "deg", True, ("clock-offset",)),
        "plate-vibration": Effect(("onset", "sliding"), "m/s^2"),
        "partial-rolling": Effect(("sliding",), "1"),
        "stepped-tilt": Effect(("measurement", "onset"), "deg", False, ("reading-delay",)),
    },
    "roll": {
        "viscous-rolling": Effect(("run-out",), "s/m", False, ("drag",)),
        "slope": Effect(("run-out",), "deg", True),
        "initial-slip": Effect(("onset", "run-out"), "m/s"),
        "corner-loss": Effect(("onset", "run-out"), "1"),
        "shape-barrier": Effect(("run-out",), "mm"),
        "drag": Effect(("run-out",), "1", False, ("viscous-rolling",)),
    },
    "pile": {
        "cohesion": Effect(("crest", "toe"), None),
        "wall-friction": Effect(("middle",), None),
        "gate-speed": Effect(("toe", "crest"), None),
        "base-vibration": Effect(("toe", "crest"), None),
        "base-tilt": Effect(("measurement",), "deg", True, ("camera-roll",)),
        "particle-shape": Effect(("middle",), None),
        "camera-roll": Effect(("measurement",), "deg", True, ("base-tilt",)),
    },
}

OUTSIDE: dict[str, dict[str, tuple[str, ...]]] = {  # what nobody listed, and the sectors where it shows
    "drop": {
        "updraught": ("flight",),  # rising air, faster with height
        "field": ("flight",),  # a sideways pull that grows with the distance
        "oriented-restitution": ("impact",),  # e depends on how the seed lands
        "clock-drift": ("measurement",),  # the frame rate drifts
    },
    "slide": {"worn-track": ("sliding",)},  # friction grows with the travel
    "roll": {"sticky-patch": ("run-out",)},  # a stretch of the plate resists more
    "pile": {"layered": ("middle",)},  # two kinds of grains: the flank breaks half way up
}
