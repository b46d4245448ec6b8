"""The cases of drops."""

from benchtwin.prove.cases.drop import Scene, draw
from benchtwin.prove.cases.drop_bench import bench
from benchtwin.prove.cases.drop_effects import EFFECTS, IN_CAMERA
from benchtwin.prove.cases.drop_snr import visibility
from benchtwin.prove.cases.record import Cases


def scored(scene: Scene, name: str) -> bool:
    """Not where a camera's effect is in one of two sessions only."""
    several = scene.one_session and len(scene.cameras) > 1
    return not (name in IN_CAMERA and several)


CASES = Cases(
    rig="drop",
    share=0.55,
    colour="#1f5fa8",
    effects=EFFECTS,
    draw=draw,
    visibility=visibility,
    bench=bench,
    scored=scored,
    design=("stated_mm", "session"),
    follows="restitution",
    singles=(
        "drag",
        "magnus",
        "draught",
        "viscoelastic-restitution",
        "plastic-restitution",
        "plate-compliance",
        "film-adhesion",
        "impact-damage",
        "plate-tilt",
        "shape-conversion",
        "camera-roll",
        "perspective",
        "silhouette-wobble",
    ),
    need_separation=("film-adhesion", "impact-damage"),
    confounded=("scale-error", "clock-error", "film-adhesion", "impact-damage"),
    separable=("film-adhesion", "impact-damage", "draught", "camera-roll"),
    pairs=(
        ("drag", "plate-tilt"),
        ("drag", "camera-roll"),
        ("drag", "silhouette-wobble"),
        ("plate-tilt", "perspective"),
        ("camera-roll", "viscoelastic-restitution"),
        ("draught", "viscoelastic-restitution"),
        ("perspective", "impact-damage"),
    ),
)
