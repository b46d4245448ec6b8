"""A flank that breaks half way, as where two kinds of grains lie over each other: on nobody's list, a rival of every bow."""

import numpy as np

from calibrate.diagnose.effects.effect import Effect
from calibrate.diagnose.effects.pile.shapes import Law, in_seeds

PLACES = (0.35, 0.5, 0.65)


def broken(at: float):
    """Surface of two straight pieces that meet at u = `at`, 1 above or below the line there, 0 at both ends."""

    def surface(u: np.ndarray) -> np.ndarray:
        return np.interp(u, [0.0, at, 1.0], [0.0, 1.0, 0.0])

    return surface


EFFECTS = {
    f"kink-{at:g}": Effect(
        f"kink-{at:g}", "middle", "1", "break of the flank over the heap's height", 0.06, -0.5, 0.5, "two straight pieces"
    )
    for at in PLACES
}
LAWS = {name: Law(surface=broken(at)) for name, at in zip(EFFECTS, PLACES, strict=True)}
for _name, _at in zip(tuple(EFFECTS), PLACES, strict=True):
    _more, _laws = in_seeds(_name, "middle", 0.06, "two straight pieces", broken(_at))
    EFFECTS |= _more
    LAWS |= _laws
