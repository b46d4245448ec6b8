"""Shape barrier: the centre rises and falls twice a turn, which slows and speeds the seed, and stops it in a trough.

    h = ½ (c cos φ + s sin φ),  φ = 2 (turning);  rise √(c² + s²)

Each recording has a phase of its own, so that c and s are two further globals a recording.
"""

from calibrate.diagnose.effects.effect import Effect

PRIOR_SD_MM = 0.1

EFFECT = Effect(
    name="shape-barrier", sector="run-out", unit="mm", meaning="rise", prior_sd=PRIOR_SD_MM, low=0.0, high=5.0,
    source="potential energy of an ellipse that rolls: its centre rises by the difference of its half axes",
    separating="the seed's turning in the picture (angle_deg), and its sizes",
)  # fmt: skip


def quadrature(kind: str, number: int) -> Effect:
    """c ("cos") or s ("sin") [mm] of recording `number`."""
    return Effect(
        name=f"shape-barrier.{kind}.{number}", sector="run-out", unit="mm", meaning=f"{kind} of the rise", prior_sd=PRIOR_SD_MM,
        low=-5.0, high=5.0, source="see shape-barrier", group="shape-barrier",
    )  # fmt: skip
