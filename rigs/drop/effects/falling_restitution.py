"""Restitution that falls with impact speed: a general law and three specific ones.

e falls by c v^(1/5) for viscous solids and compliant plates, by c v^(−1/4) for yielding
ones, or as ln v. The parameter is e(0.5 m/s) − e(2 m/s); a constant is fitted beside
it."""

from collections.abc import Callable

import numpy as np

from benchtwin.infer.effect import Counterpart, Effect
from benchtwin.rigs.drop.effects.hooks import Hits


def _law(shape: Callable[[np.ndarray], np.ndarray]):
    """e + value · s(v)/(s(0.5 m/s) − s(2 m/s))."""
    fall = float(shape(np.array(0.5)) - shape(np.array(2.0)))

    def restitution(hits: Hits, e: np.ndarray, value: float) -> np.ndarray:
        return e + value * shape(hits.speed) / fall

    return restitution


def _curved(hits: Hits, e: np.ndarray, value: float) -> np.ndarray:
    """e − value ln²(v / 1 m/s), which leaves e(0.5 m/s) − e(2 m/s) unchanged."""
    return e - value * np.log(hits.speed) ** 2


def _effect(name: str, says: str, shape, source: str, **twin) -> Effect:
    return Effect(
        name=name,
        sector="impact",
        unit="1",
        meaning="e(0.5 m/s) - e(2.0 m/s) of the normal restitution of a central impact",
        prior_sd=0.1,
        low=0.0,
        high=0.8,
        source=source,
        wording=(says, "less at 2.0 than at 0.5 m/s"),
        restitution=_law(shape),
        separating=(
            "ten drops of the same seed from each of 20, 100 and 500 mm; a plate that"
            " gives way also moves"
        ),
        **twin,
    )


def _twin(name: str, spheres: str, law: str) -> Counterpart:
    what = (
        f"restitution follows {spheres} spheres, {{value}} less at 2.0 than at 0.5 m/s"
    )
    return Counterpart(what, lambda v: {"laws": {law: {"fall": v[name]}}})


NAME, VISCOUS, YIELDING = (
    "restitution-falls-with-speed",
    "viscoelastic-restitution",
    "plastic-restitution",
)
EFFECTS = (
    _effect(
        NAME,
        "restitution falls with impact speed",
        lambda v: -np.log(v),
        "Biosystems Engineering (2017), 10.1016/j.biosystemseng.2017.06.009",
        counterpart=_twin(NAME, "viscoelastic", "restitution_viscoelastic"),
    ),
    Effect(
        name=f"{NAME}.curvature",
        sector="impact",
        unit="1",
        meaning="coefficient of -ln(v / 1 m/s)^2 beside it",
        prior_sd=0.02,
        low=-1.0,
        high=1.0,
        source="between the powers -1/4 and 1",
        restitution=_curved,
        scaled_prior=False,
        group=NAME,
    ),
    _effect(
        VISCOUS,
        "restitution falls with impact speed, as viscous solids do",
        lambda v: -(v**0.2),
        "Kuwabara, Kono (1987); Ramírez, Pöschel, Brilliantov, Schwager (1999), Phys."
        " Rev. E 60, 4465",
        counterpart=_twin(VISCOUS, "viscoelastic", "restitution_viscoelastic"),
    ),
    _effect(
        YIELDING,
        "restitution falls with impact speed, as yielding solids do",
        lambda v: v**-0.25,
        "Johnson (1985), Contact Mechanics, §11.5; Wu, Li, Thornton (2003), Int. J."
        " Impact Eng. 28, 929",
        counterpart=_twin(YIELDING, "yielding", "restitution_plastic"),
    ),
    _effect(
        "plate-compliance",
        "the plate gives way and carries energy off",
        lambda v: -(v**0.2),
        "Zener (1941), Phys. Rev. 59, 669",
        not_simulated=(
            "the twin's plates are rigid; a restitution that falls with speed stands"
            " for it"
        ),
    ),
)
