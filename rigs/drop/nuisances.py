"""Nuisance parameters of every drop, with priors; a stated key replaces the sd here."""

import numpy as np
from benchtwin.bench.air import SLOPE_SD
from benchtwin.infer.effect import Effect
from benchtwin.infer.noise import LOCK_PX
from benchtwin.rigs.drop.effects.hooks import (
    View,
    distorted,
    fallen_deeper,
    keystone,
    lower,
    scaled,
    turned,
    wobbled,
)

HEIGHT = "height"  # by how much a session's stated heights are too low
PRIORS = {  # sds
    # of g over the earth, which acts as the scale; plus what is stated (or 1 %)
    "scale": 5e-4,
    "plumb": 0.0,  # deg: as stated (or 0.5°)
    # 1/m: change of the scale with height of a camera that looks straight on
    "keystone": 1e-3,
    "lens": 2e-4,  # distortion at the edge of the view of a good lens
    # the same about another middle: its axis lies within 0.3 of the view's reach
    "lens.x": 6e-5,
    "lens.z": 6e-5,  # the same, upwards
    "wobble": 0.01,  # px: of an outline's centre as it turns, which uneven light moves
    "wobble.other": 0.01,  # the same, the other phase
    "air": 0.15,  # of a seed's drag beside a sphere's; 1 where no sizes are stated
    # d ln C_d/d ln v beside a sphere's: Haider & Levenspiel (1989)
    "air-slope": SLOPE_SD,
    HEIGHT: 1.0,  # mm: as stated (or 5 mm)
}
DISTANCES_M = (
    0.45,
    1.2,
    3.3,
    9.0,
)  # of a camera whose distance is not stated: log-uniform .3 to 20 m, as alternatives
DEPTH_SD_M = 2e-3  # of the release beside the plane of the scale
LOCK = "pixel-lock"
OFF_CENTRE = 0.3  # of the view's reach


def _off_centre(axis: int):
    """r + `value` (2 (r·n) r + r² n)/reach: Brown, Photogrammetric Eng. 32 (1966)
    444."""

    def picture(places: np.ndarray, view: View, value: float) -> np.ndarray:
        off = places - view.middle
        bent = 2 * off[:, axis, None] * off
        bent[:, axis] += (off**2).sum(1)
        return places + value * bent / view.reach

    return picture


def _lock(axis: int, wave):
    """Pixel lock: `value` [px] times a sine or cosine of the place in pixels."""

    def picture(places: np.ndarray, view: View, value: float) -> np.ndarray:
        shift = np.zeros_like(places)
        shift[:, axis] = value * view.pixel * wave(view.phase[:, axis])
        return places + shift

    return picture


def _nuisance(
    name: str, picture=None, needs=None, sd: float | None = None, **laws
) -> Effect:
    sd = sd or PRIORS[name] or 1.0
    return Effect(
        name,
        "nuisance",
        "",
        "",
        sd,
        -np.inf,
        np.inf,
        "",
        picture=picture,
        needs=needs,
        **laws,
    )


_FOUND = (
    _nuisance("scale", scaled),
    _nuisance("plumb", turned),
    _nuisance("keystone", keystone),
    _nuisance("lens", distorted),
    _nuisance("lens.x", _off_centre(0)),
    _nuisance("lens.z", _off_centre(1)),
    _nuisance("wobble", wobbled(0), lambda session: session.spins),
    _nuisance("wobble.other", wobbled(1), lambda session: session.spins),
    _nuisance("air"),
    _nuisance("air-slope"),
    _nuisance(
        HEIGHT,
        None,
        lambda seen: seen.of_stated_height,
        release=lower,
        restitution=fallen_deeper,
    ),
    *(
        _nuisance(f"{LOCK}.{'xz'[k]}.{w.__name__}", _lock(k, w), sd=LOCK_PX)
        for k in (0, 1)
        for w in (np.sin, np.cos)
    ),
)
NUISANCES: dict[str, Effect] = {effect.name: effect for effect in _FOUND}
