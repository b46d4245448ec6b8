"""Draws graph paper with known truth: lines every 1, 5 and 10 mm seen by a tilted
pinhole camera.

Independent of `vision/paper/scale.py`, which fits a map.
"""

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import ArrayLike


@dataclass(frozen=True)
class Paper:
    """What is drawn. Lengths in mm on the paper, angles in degrees; `mm_per_px` holds
    at the picture's centre.

    `tilt_deg` turns the grid clockwise in the picture; `lean_deg` tips the camera about
    the picture's x and y axes, at `distance` picture diagonals (1.0 is a phone's field
    of view). `barrel` is the relative displacement of the corner by the lens (positive:
    barrel). `depths` are the ink's darkness (0–1) of the 1, 5 and 10 mm lines,
    `widths_mm` their widths; a depth of 0 leaves the lines out (then they look like the
    next finer ones). `strip_mm` cuts the paper to (x0, y0, x1, y1) on itself, the rest
    is a table of brightness `table`. `cover` is the share of the paper that blots hide.
    """

    mm_per_px: float = 0.1
    tilt_deg: float = 0.0
    lean_deg: tuple[float, float] = (0.0, 0.0)
    distance: float = 1.0
    barrel: float = 0.0
    offset_mm: tuple[float, float] = (0.3, 0.7)
    depths: tuple[float, float, float] = (0.25, 0.4, 0.6)
    widths_mm: tuple[float, float, float] = (0.12, 0.16, 0.25)
    ink: tuple[float, float, float] | None = (
        None  # colour absorbed by the ink per channel (0–1); None: a grey picture
    )
    paper: float = 0.85
    table: float = 0.08
    strip_mm: tuple[float, float, float, float] | None = None
    cover: float = 0.0
    blur_px: float = 0.7
    noise: float = 0.01
    light: float = 0.0  # relative fall of the light from the left to the right edge
    bits: int = 8


def paper_mm(
    paper: Paper, shape: tuple[int, int], x: ArrayLike, y: ArrayLike
) -> tuple[np.ndarray, np.ndarray]:
    """The place on the paper [mm] that picture point x, y [px] shows: the true
    position."""
    height, width = shape
    diagonal = float(np.hypot(width, height))
    X, Y = (
        np.asarray(x, float) - (width - 1) / 2,
        np.asarray(y, float) - (height - 1) / 2,
    )
    bend = 1 + paper.barrel * (X * X + Y * Y) / (diagonal / 2) ** 2
    rays = np.stack(np.broadcast_arrays(X * bend, Y * bend, paper.distance * diagonal))
    ax, ay, az = np.radians([*paper.lean_deg, paper.tilt_deg])
    tip = np.array(
        [[1, 0, 0], [0, np.cos(ax), -np.sin(ax)], [0, np.sin(ax), np.cos(ax)]]
    )
    tip = tip @ np.array(
        [[np.cos(ay), 0, np.sin(ay)], [0, 1, 0], [-np.sin(ay), 0, np.cos(ay)]]
    )
    rays = np.tensordot(tip, rays, 1)
    place = rays[:2] / rays[2] * diagonal * paper.distance
    place = (
        place
        - (tip @ [0, 0, 1])[:2].reshape(2, *[1] * (place.ndim - 1))
        / (tip @ [0, 0, 1])[2]
        * diagonal
        * paper.distance
    )
    back = np.array([[np.cos(az), np.sin(az)], [-np.sin(az), np.cos(az)]])
    return tuple(
        np.tensordot(back, place, 1) * _stretch(paper, tip)
        + np.reshape(paper.offset_mm, (2, *[1] * (place.ndim - 1)))
    )


def _stretch(paper: Paper, tip: np.ndarray) -> float:
    """mm per px such that the geometric mean at the centre is `mm_per_px`: a leaning
    sheet is seen shortened by cos³."""
    return paper.mm_per_px * float(tip[2, 2]) ** 1.5


def true_scale(
    paper: Paper, shape: tuple[int, int], x: float | None = None, y: float | None = None
) -> float:
    """Geometric-mean mm per px at a point (default: the picture's centre), by
    differences of the drawn camera."""
    x, y = (
        (shape[1] - 1) / 2 if x is None else x,
        (shape[0] - 1) / 2 if y is None else y,
    )
    east, west, south, north = (
        np.array(paper_mm(paper, shape, x + i, y + j))
        for i, j in ((1, 0), (-1, 0), (0, 1), (0, -1))
    )
    return float(
        np.sqrt(abs(np.linalg.det(np.stack([(east - west) / 2, (south - north) / 2]))))
    )


def draw_paper(
    paper: Paper, shape: tuple[int, int], rng: np.random.Generator
) -> np.ndarray:
    """The picture, (height, width) or (height, width, 3) where `ink` has a colour;
    uint8 or uint16 by `bits`."""
    height, width = shape
    v, u = np.mgrid[0:height, 0:width].astype(float)
    u, v = paper_mm(paper, shape, u, v)
    ink = 1 - (1 - _lines(paper, u)) * (1 - _lines(paper, v))
    bright = np.full(shape, paper.paper) * (
        1 + 0.01 * cv2.GaussianBlur(rng.normal(size=shape), (0, 0), 3) * 6
    )
    on_paper = np.ones(shape, bool)
    if paper.strip_mm:
        x0, y0, x1, y1 = paper.strip_mm
        on_paper = (u >= x0) & (u <= x1) & (v >= y0) & (v <= y1)
    absorbed = np.ones(1) if paper.ink is None else np.asarray(paper.ink)
    picture = bright[..., None] * (1 - ink[..., None] * absorbed)
    picture = np.where(on_paper[..., None], picture, paper.table)
    _blots(picture, paper.cover, rng)
    picture = picture * (1 - paper.light * np.linspace(-0.5, 0.5, width))[None, :, None]
    if paper.blur_px > 0:
        picture = cv2.GaussianBlur(picture, (0, 0), paper.blur_px).reshape(*shape, -1)
    picture = picture + rng.normal(0, paper.noise, picture.shape)
    top = 2**paper.bits - 1
    picture = np.clip(np.rint(picture * top), 0, top).astype(
        np.uint8 if paper.bits == 8 else np.uint16
    )
    return picture[..., 0] if paper.ink is None else picture


def _lines(paper: Paper, u: np.ndarray) -> np.ndarray:
    """Ink of one family of lines, averaged over each pixel's width on the paper (a box
    against a box)."""
    step = paper.mm_per_px
    ink = np.zeros_like(u)
    for pitch, depth, width in zip((1.0, 5.0, 10.0), paper.depths, paper.widths_mm):
        away = np.abs(u - pitch * np.rint(u / pitch))
        overlap = np.clip((width + step) / 2 - away, 0, min(width, step)) / step
        ink = np.maximum(ink, depth * overlap)
    return ink


def _blots(picture: np.ndarray, cover: float, rng: np.random.Generator) -> None:
    """Dark and bright things lying on the paper until `cover` of the picture is
    hidden."""
    height, width = picture.shape[:2]
    hidden = np.zeros((height, width), np.uint8)
    for _ in range(200):
        if hidden.mean() >= cover:
            return
        centre = (int(rng.integers(width)), int(rng.integers(height)))
        axes = tuple(
            int(a) for a in rng.uniform(0.04, 0.12, 2) * min(height, width) + 1
        )
        blot = np.zeros_like(hidden)
        cv2.ellipse(blot, centre, axes, float(rng.uniform(0, 180)), 0, 360, 1, -1)
        picture[blot > 0] = rng.uniform(0.1, 0.7)
        hidden |= blot
