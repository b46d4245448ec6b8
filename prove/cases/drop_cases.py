"""The cases of drops."""

from benchtwin.prove.cases.bench import Scene
from benchtwin.prove.cases.drop import EFFECTS, IN_CAMERA, draw, record
from benchtwin.prove.cases.drop_snr import visibility
from benchtwin.prove.cases.record import Cases, field_of


def scored(scene: Scene, name: str) -> bool:
    """Not where a camera's effect is in one of two sessions only."""
    return not (field_of(name) in IN_CAMERA and scene.request.separated)


CASES = Cases(
    rig="drop",
    share=0.55,
    colour="#1f5fa8",
    effects=EFFECTS,
    draw=draw,
    visibility=visibility,
    record=record,
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
