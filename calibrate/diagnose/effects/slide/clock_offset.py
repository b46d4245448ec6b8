"""Clock offset: the tilt's stamps and the picture's come from clocks that differ."""

from calibrate.diagnose.effects.effect import Effect


def true_time(time_s: float, value: float) -> float:
    """Stamp under which the tilt at picture time `time_s` was recorded: tilt stamp − picture stamp = `value` [s]."""
    return time_s + value


EFFECT = Effect(
    name="clock-offset", sector="measurement", unit="s", meaning="tilt stamp minus picture stamp", prior_sd=0.7, low=-20.0,
    high=20.0, source="offset of the angle ∝ tilt rate", twins=("angle-offset", "adhesion", "partial-rolling", "viscous-sliding"),
    separating="the same slide at three times the tilt rate: a clock's error in angle grows with the rate, a sensor's does not",
)  # fmt: skip
