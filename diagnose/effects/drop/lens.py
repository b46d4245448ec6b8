"""A lens whose distortion no good lens has: on nobody's list of names, for it says how the picture is bent and not by what."""

from diagnose.effects.effect import Effect


def _bent(places, view, value):
    off = places - view.middle
    return view.middle + off * (1 + value * (off**2).sum(1, keepdims=True) / view.reach**2)


EFFECTS = (
    Effect(
        name="(unlisted) measurement: lens", sector="measurement", unit="1", meaning="distortion at the edge of the view",
        prior_sd=0.01, low=-0.3, high=0.3, source="wide angles bend by 1 to 10 %", picture=_bent, unlisted=True,
        untwinned="the twin's camera has no lens",
    ),
)  # fmt: skip
