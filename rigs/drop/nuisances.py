"""Nuisance parameters of every drop, with priors; a stated key replaces the sd here."""

import numpy as np

from benchtwin.bench.priors import stated_sd, unstated_sd
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

READOUT = "readout"  # of a rolling shutter, beside what is assumed
HEIGHT = "height"  # by how much a session's stated heights are too low
APPROACH = "approach"  # towards the camera, what all flights have in common [m/s]
OFF_CENTRE = 0.3  # of the view's reach, within which a lens has its axis
PRIORS = {  # sds where nothing is stated; what is stated is added or replaces them
    "scale": unstated_sd("gravity"),  # g acts as the scale
    "plumb": unstated_sd("plumb"),
    "keystone": unstated_sd("perspective"),
    "lens": unstated_sd("lens"),
    "lens.x": OFF_CENTRE * unstated_sd("lens"),  # the same about another middle
    "lens.z": OFF_CENTRE * unstated_sd("lens"),
    "wobble": unstated_sd("outline-centre"),
    "wobble.other": unstated_sd("outline-centre"),
    "air": unstated_sd("drag-coefficient"),
    "air-slope": unstated_sd("drag-slope"),
    HEIGHT: stated_sd("release-height"),
    APPROACH: unstated_sd("approach"),
}
DEPTH_SD_M = 2e-3  # of the release beside the plane of the scale
LOCK = "pixel-lock"


def _off_centre(axis: int):
    """r + `value` (2 (r·n) r + r² n)/reach: Brown, Photogrammetric Eng. 32 (1966)
    444."""

    def picture(places: np.ndarray, view: View, value: float) -> np.ndarray:
        off = places - view.middle
        bent = 2 * off[:, axis, None] * off
        bent[:, axis] += (off**2).sum(1)
        return places + value * bent / view.reach

    return picture


def _lock(axis: int, wave: int):
    """Pixel lock: `value` [px] times the sine (0) or cosine (1) of the place in
    pixels."""

    def picture(places: np.ndarray, view: View, value: float) -> np.ndarray:
        shift = value * view.pixel * view.waves[wave][:, axis, None]
        return places + shift * np.eye(2)[axis]

    return picture


def _nuisance(
    name: str, picture=None, needs=None, sd: float | None = None, **laws
) -> Effect:
    sd = sd or PRIORS[name]
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
    _nuisance(READOUT, needs=lambda session: session.readout_sd_s > 0, sd=1e-3),
    _nuisance(APPROACH),
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
        _nuisance(f"{LOCK}.{'xz'[k]}.{name}", _lock(k, w), sd=LOCK_PX)
        for k in (0, 1)
        for w, name in enumerate(("sin", "cos"))
    ),
)
NUISANCES: dict[str, Effect] = {effect.name: effect for effect in _FOUND}
