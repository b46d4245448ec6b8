"""What a bump tells a calibration: the restitution that drops tell, too."""

from math import radians, sin

from benchtwin.rigs.bump import RIG

from benchtwin.bench.tells import ByCurve


def restitution(back_deg: float, bump: dict) -> float | None:
    """e = sin(β/2) / sin(α/2): speed goes as the root of the height, and that as the
    square of the half angle's sine."""
    start = bump.get("start_deg")
    return sin(radians(back_deg / 2)) / sin(radians(start / 2)) if start else None


TELLS = ByCurve(
    rig=RIG,
    parameter="restitution",
    limits=(0.05, 1.0),
    step=0.1,
    first=0.5,
    assumed=0.5,
    formula=restitution,
)
