"""What is always a little wrong with a picture, and is nobody's news: lens distortion and pixel lock."""

import numpy as np

from calibrate.diagnose.effects.effect import Effect, View


def lens(places: np.ndarray, view: View, value: float) -> np.ndarray:
    """r → r (1 + `value` (r/reach)²), reach: the corner of what was seen."""
    off = places - view.middle
    return view.middle + off * (1 + value * (off**2).sum(1, keepdims=True) / view.reach**2)


def _lock(axis: int, wave) -> Effect:
    """A place is read too far towards pixel centres: `value` [px] times a sine or cosine of the place in pixels."""

    def picture(places: np.ndarray, view: View, value: float) -> np.ndarray:
        shift = np.zeros_like(places)
        shift[:, axis] = value * view.pixel * wave(view.phase[:, axis])
        return places + shift

    return Effect(
        f"pixel-lock.{'xz'[axis]}.{wave.__name__}", "nuisance", "px", "pixel lock", 0.03, -0.5, 0.5, "", picture=picture
    )


_LENS = Effect(
    "lens", "nuisance", "1", "distortion at the edge of the view", 2e-4, -0.1, 0.1, "missing-physics.md §3", picture=lens
)
_LOCKS = tuple(_lock(axis, wave) for axis in (0, 1) for wave in (np.sin, np.cos))
NUISANCES: dict[str, Effect] = {effect.name: effect for effect in (_LENS, *_LOCKS)}
