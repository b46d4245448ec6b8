"""Photos and films: the stage drawn, the exposure averaged, the lens's bend, the
background and the sensor's noise."""

from collections.abc import Iterator

import cv2
import numpy as np

from benchtwin.sim.motion import Motion
from benchtwin.sim.picture import look as looks
from benchtwin.sim.picture.camera import Camera, undistort
from benchtwin.sim.picture.look import Look
from benchtwin.sim.picture.render import Stage

Array = np.ndarray
Box = tuple[int, int, int, int]  # columns x0…x1 and rows y0…y1, ends excluded

# rendered pixels at once, samples included: 4 multisamples of colour and depth are 64
# MB
TILE_PX = 2_000_000
# sub-frames farther apart than this would show as steps; a blur of less than this needs
# one only
STEP_PX = 0.5
FINE = 2  # samples a pixel along each axis, besides 4 multisamples in each
MARGIN = 4  # pixels round what moves: softness of the lens reaches that far


def photo(
    motion: Motion,
    camera: Camera,
    look: Look | None = None,
    *,
    frame: int = -1,
    rng: np.random.Generator | None = None,
) -> Array:
    """One picture of `motion` at a frame: uint8 (rows, columns, 3), or (rows, columns)
    with look.grey.

    Seeds are drawn as the union of their balls: what the simulation knows. rng: needed
    for look.noise. Raises ValueError where the camera sees no seed,
    RenderingUnavailable without EGL."""
    look = look or Look()
    with Stage(motion, camera, look) as stage:
        _check(stage, [frame])
        whole = (0, 0, camera.width_px, camera.height_px)
        image = _expose(stage, look, frame, _subframe_times(stage, frame), whole)
    return _digitise(image, look, rng)


def film(
    motion: Motion,
    camera: Camera,
    look: Look | None = None,
    *,
    rng: np.random.Generator | None = None,
) -> Iterator[Array]:
    """The pictures of `motion`, one a frame, each like `photo`; what stands still is
    drawn once, a box round the rest anew."""
    look = look or Look()
    with Stage(motion, camera, look) as stage:
        _check(stage, range(motion.frames))
        moving = _ever_moving(motion)
        stage.place(0, only=~moving)
        whole = (0, 0, camera.width_px, camera.height_px)
        scene = _develop(stage, look, whole)
        still = _digitise(scene, look, None) if not look.noise else None
        for frame in range(motion.frames):
            moments = _subframe_times(stage, frame)
            box = _box(stage, frame, moments, moving)
            if box is None:
                yield still.copy() if still is not None else _digitise(scene, look, rng)
                continue
            part = _expose(stage, look, frame, moments, box)
            image = scene.copy() if still is None else still.copy()
            image[box[1] : box[3], box[0] : box[2]] = (
                part if still is None else _digitise(part, look, None)
            )
            yield _digitise(image, look, rng) if still is None else image


def coverage(
    motion: Motion,
    camera: Camera,
    *,
    frame: int = -1,
    of: str = "union",
    fine: int = FINE,
) -> Array:
    """How much of each pixel seeds and parts cover at a frame, without blur or
    exposure: float32 (rows, columns), 0 to 1. of: seeds drawn as the "union" of their
    balls or the "ellipsoid" they stand for; fine: samples a pixel along each axis."""
    with Stage(motion, camera, Look(), of=of) as stage:
        stage.place(frame)
        whole = (0, 0, camera.width_px, camera.height_px)
        bands = [_layer(stage, tile, fine)[:, :, 3] for tile in _tiles(whole, fine)]
        return np.vstack(bands) / 255.0


def _check(stage: Stage, frames) -> None:
    """ValueError when no seed is in the picture at any of the frames."""
    camera = stage.camera
    for frame in frames:
        stage.place(frame)
        box = stage.boxes()[: stage.motion.seeds]
        inside = (
            (box[:, 0] < camera.width_px)
            & (box[:, 2] > 0)
            & (box[:, 1] < camera.height_px)
            & (box[:, 3] > 0)
        )
        if inside.any():
            return
    where = "all have left the rig"
    if np.isfinite(box).any():
        middle = np.nanmean(box, axis=0).reshape(2, 2).mean(axis=0)
        where = f"their middle is at column {middle[0]:.0f}, row {middle[1]:.0f}"
    raise ValueError(
        f"the camera does not see any of the {len(box)} seeds: {where}, the picture is"
        f" {camera.width_px} × {camera.height_px} px; change target_m, mm_per_px or the"
        " picture's size"
    )


def _ever_moving(motion: Motion) -> Array:
    """Which of seeds and parts (seeds + parts,) are ever elsewhere than at the first
    frame."""
    same = (motion.positions_m == motion.positions_m[:1]).all(axis=(0, 2))
    same &= (motion.orientations == motion.orientations[:1]).all(axis=(0, 2))
    return ~np.r_[same, [bool((p.poses == p.poses[:1]).all()) for p in motion.parts]]


def _subframe_times(stage: Stage, frame: int) -> Array:
    """Middles of the sub-frames, from the frame's moment [s]: one a STEP_PX that
    anything moves, camera.subframes at most."""
    camera, motion = stage.camera, stage.motion
    if not camera.exposure_s:
        return np.zeros(1)
    stage.place(frame, -camera.exposure_s / 2)
    first, there = stage.boxes(), stage.there
    stage.place(frame, camera.exposure_s / 2)
    way = float(np.abs(stage.boxes() - first)[there & stage.there].max(initial=0.0))
    spin = np.linalg.norm(np.nan_to_num(motion.spins_rad_s[frame]), axis=1)
    turn = camera.exposure_s * spin * stage.reach_m[: motion.seeds]
    way = max(way, float(turn.max(initial=0.0)) * 1e3 / camera.mm_per_px)
    count = int(np.clip(np.ceil(way / STEP_PX), 1, camera.subframes))
    return camera.exposure_s * ((np.arange(count) + 0.5) / count - 0.5)


def _box(stage: Stage, frame: int, moments: Array, moving: Array) -> Box | None:
    """The part of the picture that what moves touches during a frame's exposure."""
    camera, seen = stage.camera, []
    for later in moments[[0, -1]]:
        stage.place(frame, later)
        seen.append(stage.boxes()[moving])
    boxes = np.vstack(seen)
    boxes = boxes[np.isfinite(boxes).all(axis=1)]
    if not boxes.size:
        return None
    low, high = boxes[:, :2].min(axis=0), boxes[:, 2:].max(axis=0)
    bend = abs(camera.distortion) * camera.corner_px * 1.5
    low = np.floor(low - MARGIN - bend).astype(int)
    high = np.ceil(high + MARGIN + bend).astype(int) + 1
    x0, y0 = np.maximum(low, 0)
    x1, y1 = np.minimum(high, [camera.width_px, camera.height_px])
    return (int(x0), int(y0), int(x1), int(y1)) if x1 > x0 and y1 > y0 else None


def _expose(stage: Stage, look: Look, frame: int, moments: Array, box: Box) -> Array:
    """The mean of the sub-frames' pictures: float32 (rows, columns, channels)
    [levels]."""
    stage.place(frame, moments[0])
    total = _develop(stage, look, box)
    for later in moments[1:]:
        stage.place(frame, later)
        image = _develop(stage, look, box)
        total = cv2.add(total, image, dst=total).reshape(image.shape)
    return total / np.float32(len(moments)) if len(moments) > 1 else total


def _develop(stage: Stage, look: Look, box: Box) -> Array:
    """What stands there now before the background: float32 (rows, columns, channels)
    [levels]."""
    return np.vstack([_develop_tile(stage, look, tile) for tile in _tiles(box, FINE)])


def _develop_tile(stage: Stage, look: Look, box: Box) -> Array:
    x0, y0, x1, y1 = box
    pad = int(np.ceil(4 * look.blur_px))
    wide = (x0 - pad, y0 - pad, x1 + pad, y1 + pad)
    layer = _layer(stage, wide, FINE).astype(np.float32)
    wall = looks.background(stage.camera, look, wide)
    image = (
        layer[:, :, : wall.shape[2]]
        + (1.0 - layer[:, :, 3:] / np.float32(255.0)) * wall
    )
    if look.blur_px:
        image = cv2.GaussianBlur(image, (0, 0), look.blur_px).reshape(image.shape)
    return image[pad : image.shape[0] - pad or None, pad : image.shape[1] - pad or None]


def _layer(stage: Stage, box: Box, fine: int) -> Array:
    """Seeds and parts alone, averaged over the samples of a pixel: uint8 (rows,
    columns, 4), colour times alpha, and alpha."""
    x0, y0, x1, y1 = box
    if stage.camera.distortion:
        samples = _distort(stage, box, fine)
    else:
        samples = stage.draw(box, fine)
    if fine == 1:
        return samples
    return cv2.resize(samples, (x1 - x0, y1 - y0), interpolation=cv2.INTER_AREA)


def _distort(stage: Stage, box: Box, fine: int) -> Array:
    """The samples of `box` as the lens bends them, from a straight picture of where
    they come from."""
    x0, y0, x1, y1 = box
    grid = np.meshgrid(
        np.arange(x0 - 1, x1 + 1, dtype=np.float32),
        np.arange(y0 - 1, y1 + 1, dtype=np.float32),
    )
    centre = stage.camera.centre_px.astype(np.float32)
    coarse = (
        undistort(stage.camera, np.stack(grid, axis=-1) - centre) + centre
    ).astype(np.float32)
    # Worked out a pixel, interpolated to the samples; the rim of one pixel keeps the
    # interpolation off the ends.
    source = cv2.resize(coarse, None, fx=fine, fy=fine, interpolation=cv2.INTER_LINEAR)[
        fine:-fine, fine:-fine
    ]
    low = np.floor(source.min(axis=(0, 1))).astype(int) - 1
    high = np.ceil(source.max(axis=(0, 1))).astype(int) + 2
    straight = stage.draw((*low, *high), fine)
    at = (source - low.astype(np.float32) + np.float32(0.5)) * np.float32(
        fine
    ) - np.float32(0.5)
    return cv2.remap(
        np.ascontiguousarray(straight), at[:, :, 0], at[:, :, 1], cv2.INTER_LINEAR
    )


def _tiles(box: Box, fine: int) -> list[Box]:
    """Bands of `box`, each small enough to be rendered at once."""
    x0, y0, x1, y1 = box
    rows = max(1, TILE_PX // (fine * fine * (x1 - x0)))
    return [(x0, y, x1, min(y + rows, y1)) for y in range(y0, y1, rows)]


def _digitise(image: Array, look: Look, rng: np.random.Generator | None) -> Array:
    """Noise added, rounded, cut off at 0 and 255: uint8."""
    if look.noise:
        if rng is None:
            raise ValueError(
                f"noise = {look.noise:g} levels needs rng, a numpy.random.Generator"
            )
        image = image + np.float32(look.noise) * rng.standard_normal(
            image.shape, dtype=np.float32
        )
    out = np.clip(np.rint(image), 0, 255).astype(np.uint8)
    return out[:, :, 0] if look.grey else out
