"""Corner loss: speed is lost at once where the incline ends."""

from calibrate.diagnose.effects.effect import Effect


def kept(value: float) -> float:
    """Share of the speed left behind the corner when `value` of it is lost."""
    return 1 - value


EFFECT = Effect(
    name="corner-loss", sector="onset", unit="1", meaning="lost fraction of speed", prior_sd=0.1, low=0.0, high=1.0,
    source="angular momentum about the new point of touch: (1 − cos β)/(1 + I/(m r²)), 0.024 for a ball at 15°",
    twins=("initial-slip",),
    separating="the same roll over a rounded corner, or on a gentler incline: the loss grows as the square of the angle",
)  # fmt: skip
