"""Frames of a falling seed, 8 bit: a light ellipse with soft edges before a bench that
is not evenly lit."""

import numpy as np

from benchtwin.prove.cases.camera import Camera, project

MARGIN_PX = 14
SEED, PLATE, GROUND = 205.0, 95.0, 42.0
# of a pixel; more makes the files large and tells the tracker nothing new
GREY_SD = 0.8
FINE = 4


def film(
    places: np.ndarray,
    shapes: np.ndarray,
    camera: Camera,
    mm_per_px: float,
    rng: np.random.Generator,
) -> tuple[np.ndarray, ...]:
    """Frames (h, w) of a seed at `places` (n, 2) [px from the picture's middle, y up]
    with outlines `shapes` (n, 2, 2) [px²]."""
    reach = np.sqrt(shapes[:, [0, 1], [0, 1]].max(axis=0))
    low = np.floor(places.min(axis=0) - reach - MARGIN_PX)
    high = np.ceil(places.max(axis=0) + reach + MARGIN_PX)
    low[0], high[0] = min(low[0], -45), max(high[0], 45)
    plate = project(camera, np.zeros(1), np.zeros(1), np.zeros(1))[1]
    ground = _bench(low, high, plate[0] / mm_per_px, camera, rng)
    t = camera.turn()
    turn = np.array([[np.cos(t), np.sin(t)], [-np.sin(t), np.cos(t)]])
    return tuple(
        _frame(ground, p, turn @ s @ turn.T, low, high, rng)
        for p, s in zip(places, shapes)
    )


def _bench(low, high, plate_px: float, camera: Camera, rng) -> np.ndarray:
    """The picture without a seed: dark cloth, lit from a side, and a steel plate
    below."""
    x, y = np.meshgrid(np.arange(low[0], high[0]), np.arange(high[1], low[1], -1))
    light = (
        1
        + 0.12 * rng.uniform(-1, 1) * x / np.ptp(x)
        + 0.12 * rng.uniform(-1, 1) * y / np.ptp(y)
    )
    slope = np.tan(camera.turn())
    cover = np.clip(plate_px - slope * x - y + 0.5, 0, 1)
    grain = np.cumsum(rng.normal(0, 0.15, y.shape[1]))[None, :]
    return light * (GROUND + cover * (PLATE - GROUND + grain - grain.mean()))


def _frame(
    ground: np.ndarray, place: np.ndarray, shape: np.ndarray, low, high, rng
) -> np.ndarray:
    picture = ground.copy()
    reach = int(np.ceil(np.sqrt(max(shape[0, 0], shape[1, 1])))) + 2
    # of the centre; pixel centres are whole
    column = place[0] - low[0]
    row = high[1] - place[1]
    c0, r0 = int(np.floor(column)) - reach, int(np.floor(row)) - reach
    sub = (np.arange((2 * reach + 2) * FINE) + 0.5) / FINE - 0.5
    dx, dy = c0 + sub - column, row - r0 - sub
    inverse = np.linalg.inv(shape)
    level = (
        inverse[0, 0] * dx[None, :] ** 2
        + 2 * inverse[0, 1] * dx[None, :] * dy[:, None]
        + inverse[1, 1] * dy[:, None] ** 2
    )
    # about the distance to the edge, px
    depth = (1 - np.sqrt(level)) * np.sqrt(np.sqrt(np.linalg.det(shape)))
    fine = np.clip(depth * FINE + 0.5, 0, 1)
    cover = fine.reshape(2 * reach + 2, FINE, 2 * reach + 2, FINE).mean(axis=(1, 3))
    rows = slice(max(r0, 0), min(r0 + len(cover), len(picture)))
    columns = slice(max(c0, 0), min(c0 + len(cover), picture.shape[1]))
    cover = cover[
        rows.start - r0 : rows.stop - r0, columns.start - c0 : columns.stop - c0
    ]
    picture[rows, columns] += cover * (SEED - picture[rows, columns])
    return np.clip(
        np.round(
            picture + GREY_SD * rng.standard_normal(picture.shape, dtype=np.float32)
        ),
        0,
        255,
    ).astype(np.uint8)
