"""Draws films of rigs with their plate: a block on a tilting plate, a seed that rolls
off an incline."""

from collections.abc import Iterator

import cv2
import numpy as np

from synthetic.film import Look, _digitise, _lay, draw_scene
from synthetic.motion import Motion

FINE = 4  # polygons are drawn this much larger and averaged down


def film_slide(
    motion: Motion,
    look: Look,
    rng: np.random.Generator,
    *,
    fps: float,
    start_s: float = 0.0,
    plate_mm: float = 200.0,
    thick_mm: float = 8.0,
    block_mm: tuple[float, float] = (20.0, 6.0),
    pivot_px: tuple[float, float] = (60.0, 400.0),
    plate_grey: float = 175.0,
    beans: bool = False,
    from_above_deg: float = 0.0,
    fades: float = 0.0,
) -> Iterator[np.ndarray]:
    """A plate hinged at `pivot_px` that tilts upwards to the right; the block slides
    down it, towards the hinge.

    beans: the block shows two of its seeds side by side, ellipses that touch, not a
    box. from_above_deg: the camera looks down on the level plate by so much, and sees
    its upper face (100 mm deep) until it has tilted that far. fades: the share of its
    brightness that the block loses per radian of tilt."""
    if motion.tilt is None:
        raise ValueError("a slide's motion says how its plate tilts")
    scene = draw_scene(look, rng)
    pivot, scale = np.array(pivot_px), 1 / look.mm_per_px
    for time in np.arange(start_s, motion.end_s, 1 / fps):
        tilt = np.radians(float(motion.tilt(np.array([time]))[0]))
        along, up = (
            np.array([np.cos(tilt), -np.sin(tilt)]),
            np.array([-np.sin(tilt), -np.cos(tilt)]),
        )
        travel = float(motion.path(np.array([time]))[0][0])
        image = scene.copy()
        length, thick = plate_mm * scale, thick_mm * scale
        face = 100 * scale * max(np.sin(np.radians(from_above_deg) - tilt), 0.0)
        for side, grey in ((face * up, 1.2 * plate_grey), (-thick * up, plate_grey)):
            _polygon(
                image,
                [
                    pivot,
                    pivot + length * along,
                    pivot + length * along + side,
                    pivot + side,
                ],
                grey,
            )
        foot = pivot + (0.75 * length - travel * scale) * along
        for outline in _block(block_mm[0] * scale, block_mm[1] * scale, beans):
            _polygon(
                image,
                [foot + s * along + h * up for s, h in outline],
                look.seed_grey * (1 - fades * tilt),
            )
        yield _finish(image, look, rng)


def _block(length: float, height: float, beans: bool) -> list[np.ndarray]:
    """Outlines of the block's parts about the middle of its foot: (along, up) px, (n,
    2) each."""
    if not beans:
        half = length / 2
        return [np.array([(-half, 0), (half, 0), (half, height), (-half, height)])]
    turn = np.linspace(0, 2 * np.pi, 48, endpoint=False)
    bean = np.column_stack([length / 4 * np.cos(turn), height / 2 * (1 + np.sin(turn))])
    return [bean - np.array([length / 4, 0]), bean + np.array([length / 4, 0])]


def film_roll(
    motion: Motion,
    look: Look,
    rng: np.random.Generator,
    *,
    fps: float,
    start_s: float = 0.0,
    incline_deg: float = 15.0,
) -> Iterator[np.ndarray]:
    """A seed that rolls down to the right and on along the level; `look.origin_px` is
    the plate's junction.

    motion's travel is that of the centroid, whose way round the corner is shorter than
    the plate's by r tan(β/2) on each leg: the run-out counted from the plate's junction
    is longer than the motion's by that (`corner_mm`)."""
    scene = draw_scene(look, rng)
    beta, radius = np.radians(incline_deg), look.axes_mm[1] / 2
    junction = np.array(look.origin_px)
    level = np.array([1.0, 0.0])
    down = np.array([np.cos(beta), np.sin(beta)])
    corner = junction + np.array([np.tan(beta / 2), -1.0]) * radius / look.mm_per_px
    far = look.width + 50.0
    _polygon(
        scene,
        [junction - 400 * down, junction, [far, junction[1]], [far, far], [-500, far]],
        150.0,
    )
    way = motion.truth["incline_mm"]
    for time in np.arange(start_s, motion.end_s, 1 / fps):
        image = scene.copy()
        x, _, angle = motion.path(np.array([time]))
        beyond = (float(x[0]) - way) / look.mm_per_px
        place = corner + beyond * (down if beyond < 0 else level)
        _lay(image, look, place[:1], place[1:], angle, None)
        yield _finish(image, look, rng)


def corner_mm(look: Look, incline_deg: float = 15.0) -> float:
    """By how much the run-out on the plate exceeds the centroid's: r tan(β/2)."""
    return float(look.axes_mm[1] / 2 * np.tan(np.radians(incline_deg) / 2))


def _polygon(image: np.ndarray, corners, value: float) -> None:
    """Fill a polygon (picture coordinates, pixel centres whole) with sub-pixel
    coverage."""
    points = (np.asarray(corners, dtype=float) + 0.5) * FINE - 0.5
    height, width = image.shape
    mask = np.zeros((height * FINE, width * FINE), np.uint8)
    cv2.fillPoly(mask, [np.round(points * 256).astype(np.int32)], 255, cv2.LINE_AA, 8)
    cover = (
        cv2.resize(mask, (width, height), interpolation=cv2.INTER_AREA).astype(
            np.float32
        )
        / 255
    )
    image += cover * (value - image)


def _finish(image: np.ndarray, look: Look, rng: np.random.Generator) -> np.ndarray:
    image = cv2.GaussianBlur(image, (0, 0), max(look.blur_px, 0.3))
    if look.noise:
        image = image + look.noise * rng.standard_normal(image.shape, dtype=np.float32)
    return _digitise(image, look, rng)
