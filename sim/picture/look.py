"""How the bench looks: light, colours, what hangs behind, and the sensor's noise. All
reproducible: nothing is drawn here."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from scipy.spatial import cKDTree

from benchtwin.sim.material import within
from benchtwin.sim.picture.camera import Camera

Array = np.ndarray

SOYBEAN = (222.0, 196.0, 142.0)  # pale yellow, as ripe seeds under daylight
# levels of 255 of a surface that faces the light
FINISHES = {"steel": (128.0, 131.0, 135.0), "board": (58.0, 52.0, 48.0)}
# whence neighbours shade, in the picture's axes: above, so that outlines stay bright
SKY = np.array([0.0, 0.85, 0.53])
MOST = {"texture": 255, "variation": 0.5, "ambient": 1, "noise": 255, "blur_px": 20}
GOLDEN = 0.5 * (np.sqrt(5.0) - 1.0)


@dataclass(frozen=True)
class Look:
    """Colours in levels of 255 (r, g, b) of a surface that faces the light; the sensor
    is linear and saturates at 255.

    grey: one channel, as a high-speed camera. background: what hangs behind; texture:
    its unevenness [levels, sd]. light: direction towards the light in the picture's
    axes (right, up, towards the camera); ambient: the share of light that comes from
    everywhere (lamps beside the camera: light from above at ambient 0.5 moved measured
    centroids by 0.04 px, this by 0.01). variation: how much seeds differ in brightness,
    ± relative. noise: the sensor's sd [levels]. blur_px: sd of the lens's and pixel's
    softness [px]."""

    grey: bool = False
    background: tuple[float, float, float] = (34.0, 37.0, 44.0)
    texture: float = 0.0
    seed: tuple[float, float, float] = SOYBEAN
    variation: float = 0.08
    light: tuple[float, float, float] = (-0.1, 0.25, 1.0)
    ambient: float = 0.65
    noise: float = 0.0
    blur_px: float = 0.5

    def __post_init__(self):
        for name in ("background", "seed"):
            if np.shape(getattr(self, name)) != (3,) or not all(
                0.0 <= v <= 255.0 for v in getattr(self, name)
            ):
                raise ValueError(
                    f"{name} = {getattr(self, name)}: must be three levels of 0 to 255"
                )
        if (
            np.shape(self.light) != (3,)
            or not 0.0 < np.linalg.norm(self.light) < np.inf
        ):
            raise ValueError(
                f"light = {self.light}: must be a direction, three finite numbers"
            )
        for name, high in MOST.items():
            within(name, getattr(self, name), 0.0, high, "")


def levels(look: Look, colour: ArrayLike) -> Array:
    """A colour as the sensor has it: (3,), or three equal values when it sees grey."""
    colour = np.asarray(colour, dtype=float)
    return np.full(3, colour @ [0.299, 0.587, 0.114]) if look.grey else colour


def seed_colours(look: Look, seeds: int) -> Array:
    """Colours (seeds, 3) [levels]: seed k's brightness and warmth follow the golden
    section of k, so that neighbours differ."""
    k = np.arange(seeds)
    bright = 1.0 + look.variation * (2.0 * np.mod(k * GOLDEN, 1.0) - 1.0)
    warm = 0.3 * look.variation * (2.0 * np.mod(k * GOLDEN**2 + 0.5, 1.0) - 1.0)
    tint = np.stack([bright + warm, bright, bright - 2.0 * warm], axis=1)
    return levels(look, look.seed) * (bright[:, None] if look.grey else tint)


def openness(places_m: Array, reach_m: Array, towards: Array) -> Array:
    """How much light reaches each seed past its neighbours (n,), 0.4 to 1: without it a
    heap looks flat.

    1/(1 + (b/3)²), b = Σ (u·s)⁺ over the neighbours nearer than 2.4 radii: u the
    direction to them, s = SKY in the world."""
    there = np.flatnonzero(np.isfinite(places_m).all(axis=1))
    light = np.ones(len(places_m))
    if there.size < 2:
        return light
    points = places_m[there]
    pairs = cKDTree(points).query_pairs(
        2.4 * float(np.median(reach_m[there])), output_type="ndarray"
    )
    apart = points[pairs[:, 1]] - points[pairs[:, 0]]
    cosine = (apart @ towards) / np.maximum(np.linalg.norm(apart, axis=1), 1e-12)
    blocked = np.bincount(pairs[:, 0], np.maximum(cosine, 0.0), there.size)
    blocked += np.bincount(pairs[:, 1], np.maximum(-cosine, 0.0), there.size)
    light[there] = np.maximum(1.0 / (1.0 + (blocked / 3.0) ** 2), 0.4)
    return light


def part_colour(look: Look, finish: str) -> Array:
    """Colour (3,) [levels] of a part's finish, "seed" the look's own; ValueError for a
    finish that nobody described."""
    if finish == "seed":
        return levels(look, look.seed)
    if finish not in FINISHES:
        raise ValueError(f"finish = {finish!r}: must be one of {', '.join(FINISHES)}")
    return levels(look, FINISHES[finish])


def background(camera: Camera, look: Look, box: tuple[int, int, int, int]) -> Array:
    """What hangs behind, in columns x0…x1 and rows y0…y1 of the picture: float32 (rows,
    columns, channels) [levels]."""
    x0, y0, x1, y1 = box
    channels = 1 if look.grey else 3
    wall = np.empty((y1 - y0, x1 - x0, channels), np.float32)
    wall[:] = levels(look, look.background)[:channels]
    if look.texture:
        y, x = np.mgrid[y0:y1, x0:x1].astype(np.float32) / np.float32(camera.corner_px)
        cloth = np.zeros(y.shape, np.float32)
        # waves of all directions, a tenth of the picture to all of it
        for n in range(1, 13):
            turn, length = np.float32(2.0 * np.pi * n * GOLDEN), np.float32(2.0 / n)
            cloth += np.sin(
                2.0 * np.pi * (x * np.cos(turn) + y * np.sin(turn)) / length + 7.0 * n
            )
        wall += np.float32(look.texture / np.sqrt(6.0)) * cloth[:, :, None]
    return wall
