"""Clock error: the frame rate is wrong."""

from calibrate.diagnose.effects.effect import Effect


def clock(value: float) -> float:
    """True over stated frame rate, 1 + `value`: a stated second lasts 1/(1 + value) s."""
    return 1 + value


EFFECT = Effect(
    name="clock-error", sector="measurement", unit="1", meaning="true fps / stated fps - 1", prior_sd=0.02, low=-0.2, high=0.2,
    source="t² of free fall", twins=("scale-error",), separating="a film of a stop watch, or a fall from a measured height",
    clock=clock,
)  # fmt: skip
