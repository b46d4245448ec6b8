"""What is always a little wrong, and is nobody's news: lens distortion, pixel lock, how C_d changes with the speed."""

import numpy as np

from calibrate.diagnose.air import SLOPE_SD
from calibrate.diagnose.effects.effect import Effect, View
from calibrate.diagnose.noise import LOCK_PX

LENS = 2e-4  # distortion that a good lens has at the edge of the view
LOCK = "pixel-lock"
OFF_CENTRE = 0.3  # how far, in reaches, its middle may lie from the middle of what was seen


def lens(places: np.ndarray, view: View, value: float) -> np.ndarray:
    """r → r (1 + `value` (r/reach)²), reach: from the middle to the top of what was seen."""
    off = places - view.middle
    return view.middle + off * (1 + value * (off**2).sum(1, keepdims=True) / view.reach**2)


def _off_centre(axis: int) -> Effect:
    """The lens's axis does not meet the middle of what was seen: r → r + `value` (2 (r·n) r + r² n)/reach, n along the axis: to
    first order what `lens` does about another middle. Brown, Photogrammetric Engineering 32 (1966) 444."""

    def picture(places: np.ndarray, view: View, value: float) -> np.ndarray:
        off = places - view.middle
        bent = 2 * off[:, axis, None] * off
        bent[:, axis] += (off**2).sum(1)
        return places + value * bent / view.reach

    meaning = f"distortion about another middle, {'xz'[axis]}"
    return Effect(f"lens.{'xz'[axis]}", "nuisance", "1", meaning, OFF_CENTRE * LENS, -0.1, 0.1, "Brown (1966)", picture=picture)


def _lock(axis: int, wave) -> Effect:
    """A place is read too far towards pixel centres: `value` [px] times a sine or cosine of the place in pixels."""

    def picture(places: np.ndarray, view: View, value: float) -> np.ndarray:
        shift = np.zeros_like(places)
        shift[:, axis] = value * view.pixel * wave(view.phase[:, axis])
        return places + shift

    return Effect(
        f"{LOCK}.{'xz'[axis]}.{wave.__name__}", "nuisance", "px", "pixel lock", LOCK_PX, -0.5, 0.5, "", picture=picture
    )


_LENSES = (
    Effect("lens", "nuisance", "1", "distortion at the edge of the view", LENS, -0.1, 0.1, "a good lens's", picture=lens),
    _off_centre(0),
    _off_centre(1),
)
_LOCKS = tuple(_lock(axis, wave) for axis in (0, 1) for wave in (np.sin, np.cos))
_SLOPE = Effect(
    "drag-slope", "nuisance", "1", "d ln C_d/d ln v beside a sphere's", SLOPE_SD, -1.0, 1.0, "Haider & Levenspiel (1989)"
)
NUISANCES: dict[str, Effect] = {effect.name: effect for effect in (*_LENSES, *_LOCKS, _SLOPE)}
