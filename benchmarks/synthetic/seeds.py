"""Draws photos of spread seeds: ellipses of known length and width, single or touching,
with shading, shadows and noise."""

from dataclasses import dataclass

import cv2
import numpy as np
import pandas as pd


@dataclass(frozen=True)
class Spread:
    """What is drawn. Lengths in px, brightness 0–1. `groups` are the numbers of
    touching seeds, one entry a cluster.

    `texture` is the relative sd of blotches on the seeds, `limb` how much darker their
    rim is, `shadow` how dark the shadow beside each (0: none), `light` the relative
    fall of the light across the picture, `dust` the number of specks. `border`: seeds
    that the picture's border cuts."""

    groups: tuple[int, ...] = (1,) * 12
    length_px: tuple[float, float] = (60.0, 4.0)  # mean, sd
    width_px: tuple[float, float] = (48.0, 3.0)
    seed: float = 0.65
    ground: float = 0.15
    colour: tuple[float, float, float] | None = (
        None  # of the seeds relative to `seed`; None: a grey picture
    )
    texture: float = 0.05
    limb: float = 0.1
    shadow: float = 0.0
    light: float = 0.0
    dust: int = 0
    border: int = 0
    blur_px: float = 0.9
    noise: float = 0.01
    bits: int = 8


@dataclass(frozen=True)
class DrawnSeed:
    """A drawn seed: centre, length and width [px], direction, and the group of seeds
    that touch it."""

    x: float
    y: float
    length: float
    width: float
    angle_deg: float
    group: int


def draw_seeds(
    spread: Spread, shape: tuple[int, int], rng: np.random.Generator
) -> tuple[np.ndarray, pd.DataFrame]:
    """The picture and its truth: x_px, y_px, length_px, width_px, angle_deg, group, cut
    (by the border).

    Raises ValueError where there is no room for the seeds.
    """
    seeds = _place(spread, shape, rng)
    height, width = shape
    picture = np.repeat(np.full(shape, spread.ground)[..., None], 3, 2)
    for seed in seeds if spread.shadow else ():
        away = 0.06 * seed.length
        shade = cv2.GaussianBlur(
            _coverage(_moved(seed, away, away), shape)[0], (0, 0), away
        )
        picture *= (1 - spread.shadow * shade)[..., None]
    colour = np.ones(3) if spread.colour is None else np.asarray(spread.colour)
    for seed in seeds:
        cover, depth = _coverage(seed, shape)
        blotch = (
            cv2.GaussianBlur(
                rng.normal(size=shape).astype(np.float32), (0, 0), seed.width / 12
            )
            * seed.width
            / 3.5
        )
        bright = (
            spread.seed * (1 - spread.limb * depth**4) * (1 + spread.texture * blotch)
        )
        picture = (
            picture * (1 - cover[..., None]) + (bright * cover)[..., None] * colour
        )
    for _ in range(spread.dust):
        centre = (int(rng.integers(width)), int(rng.integers(height)))
        cv2.circle(picture, centre, int(rng.integers(1, 4)), [spread.seed] * 3, -1)
    picture *= (1 - spread.light * np.linspace(-0.5, 0.5, width))[None, :, None]
    if spread.blur_px:
        picture = cv2.GaussianBlur(picture, (0, 0), spread.blur_px)
    if spread.colour is None:
        picture = picture[..., 0]
    picture = picture + rng.normal(0, spread.noise, picture.shape)
    top = 2**spread.bits - 1
    image = np.clip(np.rint(picture * top), 0, top).astype(
        np.uint8 if spread.bits == 8 else np.uint16
    )
    rows = [
        (s.x, s.y, s.length, s.width, s.angle_deg, s.group, _cut(s, shape))
        for s in seeds
    ]
    return image, pd.DataFrame(
        rows,
        columns=["x_px", "y_px", "length_px", "width_px", "angle_deg", "group", "cut"],
    )


def outline(seed: DrawnSeed, points: int = 360) -> np.ndarray:
    """The drawn ellipse's edge [px], (points, 2). `angle_deg` is its long axis,
    clockwise from the picture's x axis."""
    t, turn = (
        np.linspace(0, 2 * np.pi, points, endpoint=False),
        np.radians(seed.angle_deg),
    )
    along, across = seed.length / 2 * np.cos(t), seed.width / 2 * np.sin(t)
    x, y = (
        along * np.cos(turn) - across * np.sin(turn),
        along * np.sin(turn) + across * np.cos(turn),
    )
    return np.stack([seed.x + x, seed.y + y], -1)


def _moved(seed: DrawnSeed, dx: float, dy: float) -> DrawnSeed:
    return DrawnSeed(
        seed.x + dx, seed.y + dy, seed.length, seed.width, seed.angle_deg, seed.group
    )


def _depth(seed: DrawnSeed, x, y) -> np.ndarray:
    """0 at the ellipse's centre, 1 on its edge."""
    turn = np.radians(seed.angle_deg)
    along = (x - seed.x) * np.cos(turn) + (y - seed.y) * np.sin(turn)
    across = -(x - seed.x) * np.sin(turn) + (y - seed.y) * np.cos(turn)
    return np.hypot(2 * along / seed.length, 2 * across / seed.width)


def _coverage(seed: DrawnSeed, shape: tuple[int, int]) -> tuple[np.ndarray, np.ndarray]:
    """Share of each pixel that the seed covers (5 × 5 samples), and the depth at its
    centre clipped to 1."""
    y, x = np.mgrid[0 : shape[0], 0 : shape[1]].astype(np.float32)
    depth = _depth(seed, x, y)
    cover = (depth < 1).astype(np.float32)
    edge = np.abs(depth - 1) < 3 / min(seed.length, seed.width)
    steps = (np.arange(5) - 2) / 5
    cover[edge] = np.mean(
        [_depth(seed, x[edge] + a, y[edge] + b) < 1 for a in steps for b in steps], 0
    )
    return cover, np.minimum(depth, 1)


def _place(
    spread: Spread, shape: tuple[int, int], rng: np.random.Generator
) -> list[DrawnSeed]:
    placed: list[DrawnSeed] = []
    for group, count in enumerate((*spread.groups, *(1,) * spread.border)):
        for _ in range(400):
            cluster = _cluster(
                spread, shape, group, count, group >= len(spread.groups), rng
            )
            if cluster and all(_gap(a, b) > 6 for a in cluster for b in placed):
                placed += cluster
                break
        else:
            raise ValueError(
                f"no room for {sum(spread.groups)} seeds in {shape[1]} × {shape[0]} px"
            )
    return placed


def _cluster(
    spread: Spread, shape, group: int, count: int, at_border: bool, rng
) -> list[DrawnSeed] | None:
    """Seeds that touch in a chain; None when one of them leaves the picture or runs
    into another."""
    cluster: list[DrawnSeed] = []
    for i in range(count):
        length, width = (
            max(m + s * float(rng.normal()), 4.0)
            for m, s in (spread.length_px, spread.width_px)
        )
        length, width = max(length, width), min(length, width)
        x, y = (float(rng.uniform(0, n)) for n in (shape[1], shape[0]))
        if at_border:
            x = float(rng.choice([0.1 * length, shape[1] - 0.1 * length]))
        seed = DrawnSeed(x, y, length, width, float(rng.uniform(-90, 90)), group)
        if i:
            seed = _beside(
                cluster[int(rng.integers(i))], seed, float(rng.uniform(0, 2 * np.pi))
            )
            if any(_gap(seed, other) < -0.7 for other in cluster):
                return None
        if not at_border and _cut(seed, shape):
            return None
        cluster.append(seed)
    return cluster


def _beside(first: DrawnSeed, second: DrawnSeed, direction: float) -> DrawnSeed:
    """`second`, pushed along `direction` until it just touches `first` (overlapping by
    half a pixel)."""
    near, far = 0.0, first.length + second.length
    for _ in range(25):
        middle = (near + far) / 2
        tried = DrawnSeed(
            first.x + middle * np.cos(direction),
            first.y + middle * np.sin(direction),
            *(second.length, second.width, second.angle_deg, second.group),
        )
        near, far = (middle, far) if _gap(first, tried) < -0.5 else (near, middle)
    return tried


def _gap(a: DrawnSeed, b: DrawnSeed) -> float:
    """About the distance between two seeds' edges [px]; negative where they overlap."""
    if np.hypot(a.x - b.x, a.y - b.y) > (a.length + b.length) / 2 + 10:
        return 10.0
    return min(
        float((_depth(p, *outline(q, 120).T).min() - 1) * p.width / 2)
        for p, q in ((a, b), (b, a))
    )


def _cut(seed: DrawnSeed, shape: tuple[int, int]) -> bool:
    edge = outline(seed, 90)
    return bool(
        (edge < 3).any()
        or (edge[:, 0] > shape[1] - 4).any()
        or (edge[:, 1] > shape[0] - 4).any()
    )
