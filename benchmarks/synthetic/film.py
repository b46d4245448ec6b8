"""Draws films of a seed with a given motion: an ellipse with sub-pixel coverage, noise,
clutter, mirror image and other options."""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import cast

import cv2
import numpy as np
from numpy.typing import ArrayLike
from PIL import Image

from benchtwin.vision.recording import Recording, write_recording
from synthetic.motion import Motion

# samples a pixel along each axis; the centroid of an ellipse of 20 px is then right to
# 0.002 px
SUB = 8


@dataclass(frozen=True)
class Look:
    """How the film looks. Grey levels of 255; lengths in pixels of the picture."""

    width: int = 640
    height: int = 480
    mm_per_px: float = 0.5
    axes_mm: tuple[float, float] = (
        8.7,
        6.8,
    )  # the seed's silhouette, full length and width
    seed_grey: float = 205.0
    ground_grey: float = 80.0
    shading: float = (
        0.0  # relative change of brightness from one side of the seed to the other, ±
    )
    highlight: float = 0.0  # grey levels of a small spot on the seed
    noise: float = 0.0  # grey levels, sd
    blur_px: float = 0.6  # of lens and pixel, Gaussian sd
    exposure_s: float = 0.0  # motion blur
    clutter: float = 0.0  # grey levels of background texture and objects
    graph_paper: bool = False
    plate_row: float | None = (
        None  # picture row of the plate's surface (the seed's lowest point at contact)
    )
    mirror: float = 0.0  # brightness of the mirror image in the plate, relative
    shadow: float = 0.0  # grey levels of a shadow beside the seed on the wall
    clamp: bool = False  # jaws that open at the release
    hand: bool = False  # a large thing that leaves the picture at the release
    drift: float = 0.0  # relative change of the light over the film
    bits: int = 8
    colour: bool = False
    origin_px: tuple[float, float] = (
        320.0,
        440.0,
    )  # picture column and row of x = 0, y = 0 mm


def to_picture(
    look: Look, x_mm: ArrayLike, y_mm: ArrayLike
) -> tuple[np.ndarray, np.ndarray]:
    """Picture column and row of a place in mm (y up)."""
    return look.origin_px[0] + np.asarray(x_mm) / look.mm_per_px, look.origin_px[
        1
    ] - np.asarray(y_mm) / look.mm_per_px


def film(
    motion: Motion,
    look: Look,
    rng: np.random.Generator,
    *,
    fps: float,
    times: ArrayLike | None = None,
    start_s: float = 0.0,
) -> Iterator[np.ndarray]:
    """The frames of `motion`, one at a time: uint8 or uint16, grey or RGB."""
    times = (
        np.arange(start_s, motion.end_s, 1 / fps)
        if times is None
        else np.asarray(times)
    )
    scene = draw_scene(look, rng)
    for n, time in enumerate(times):
        yield draw_frame(
            motion, look, rng, scene, float(time), n / max(len(times) - 1, 1)
        )


def draw_scene(look: Look, rng: np.random.Generator) -> np.ndarray:
    """The still background, float32."""
    scene = np.full((look.height, look.width), look.ground_grey, np.float32)
    if look.clutter:
        texture = cv2.GaussianBlur(
            rng.standard_normal(scene.shape).astype(np.float32), (0, 0), 3
        )
        scene += look.clutter * texture / texture.std()
        for _ in range(12):
            x, y = int(rng.integers(look.width)), int(rng.integers(look.height))
            size = int(rng.integers(8, 60))
            cv2.rectangle(
                scene,
                (x, y),
                (x + size, y + size // 2),
                look.ground_grey + float(rng.normal()) * 2 * look.clutter,
                -1,
            )
    if look.graph_paper:
        for spacing, depth in ((1.0, 18.0), (10.0, 40.0)):
            for lines, extent in ((0, look.width), (1, look.height)):
                places = np.arange(0, extent, spacing / look.mm_per_px)
                profile = np.zeros(extent, np.float32)
                for place in places:
                    profile += np.exp(-0.5 * ((np.arange(extent) - place) / 0.6) ** 2)
                scene -= depth * (profile[None, :] if lines == 0 else profile[:, None])
    if look.plate_row is not None:
        scene[round(look.plate_row) :] = 0.6 * look.ground_grey + 20
    return np.clip(cv2.GaussianBlur(scene, (0, 0), 0.6), 2, 250)


def draw_frame(
    motion: Motion,
    look: Look,
    rng: np.random.Generator,
    scene: np.ndarray,
    time: float,
    share: float,
) -> np.ndarray:
    """One frame at `time`; `share` of the film has gone by (light drift)."""
    image = scene.copy()
    moments = (
        time + look.exposure_s * (np.arange(12) / 12 - 11 / 24)
        if look.exposure_s
        else np.array([time])
    )
    x, y, angle = motion.path(moments)
    columns, rows = to_picture(look, x, y)
    release = motion.truth.get("release_s", 0.02)
    _props(image, look, columns, rows, time - release, motion)
    if look.shadow:
        _lay(
            image,
            look,
            columns + 14,
            rows + 5,
            angle,
            lambda c, s: (s - look.shadow, c),
        )
    if look.mirror and look.plate_row is not None:
        below = 2 * look.plate_row - rows
        _lay(
            image,
            look,
            columns,
            below,
            -angle,
            lambda c, s: (s * 0 + look.mirror * look.seed_grey, c),
            clip_above=look.plate_row,
        )
    _lay(image, look, columns, rows, angle, None)
    image = image * (1 + look.drift * share)
    if look.noise:
        image = image + look.noise * rng.standard_normal(image.shape, dtype=np.float32)
    return _digitise(image, look, rng)


def _props(image, look: Look, columns, rows, since: float, motion) -> None:
    """Clamp jaws and hand, which move at the release."""
    start_x, start_y, _ = motion.path(np.array([-1.0]))
    cx, cy = (float(v[0]) for v in to_picture(look, start_x, start_y))
    half = look.axes_mm[0] / look.mm_per_px / 2
    if look.clamp:
        gap = half * (0.95 + min(max(since, 0) / 0.01, 1.5))
        for side in (-1, 1):
            edge = cx + side * gap
            corner = (edge, edge + side * 2.2 * half)
            cv2.rectangle(
                image,
                (int(min(corner)), int(cy - half)),
                (int(max(corner)), int(cy)),
                150.0,
                -1,
            )
    if look.hand:
        left = cx + 1.4 * half + 900 * max(since, 0) / look.mm_per_px
        cv2.ellipse(image, (int(left + 60), int(cy)), (60, 30), 0, 0, 360, 170.0, -1)


def _lay(image, look: Look, columns, rows, angles, paint, clip_above=None) -> None:
    """Draw the ellipse with its coverage, averaged over the exposure."""
    a, b = (s / 2 / look.mm_per_px for s in look.axes_mm)
    pad = a + 5 * look.blur_px + 4
    x0, x1 = int(np.floor(columns.min() - pad)), int(np.ceil(columns.max() + pad)) + 1
    y0, y1 = int(np.floor(rows.min() - pad)), int(np.ceil(rows.max() + pad)) + 1
    fine_x = np.arange((x1 - x0) * SUB) / SUB + x0 - 0.5 + 0.5 / SUB
    fine_y = np.arange((y1 - y0) * SUB) / SUB + y0 - 0.5 + 0.5 / SUB
    coverage: np.ndarray = np.zeros((y1 - y0, x1 - x0))
    light: np.ndarray = np.zeros_like(coverage)
    for cx, cy, angle in zip(columns, rows, angles):
        c, s = np.cos(np.radians(angle)), np.sin(np.radians(angle))
        du, dv = fine_x[None, :] - cx, cy - fine_y[:, None]
        inside = ((c * du + s * dv) / a) ** 2 + ((-s * du + c * dv) / b) ** 2 <= 1
        if clip_above is not None:
            inside &= fine_y[:, None] >= clip_above - 0.5
        part = inside.reshape(y1 - y0, SUB, x1 - x0, SUB).mean(axis=(1, 3))
        coverage += part / len(columns)
        coarse_u, coarse_v = (
            np.arange(x0, x1)[None, :] - cx,
            cy - np.arange(y0, y1)[:, None],
        )
        grey = look.seed_grey * (
            1 + look.shading * (0.6 * coarse_u + 0.8 * coarse_v) / a
        )
        grey = grey + look.highlight * np.exp(
            -((coarse_u - 0.3 * a) ** 2 + (coarse_v - 0.35 * b) ** 2)
            / (2 * (0.15 * a) ** 2)
        )
        light += part * grey / len(columns)
    coverage, light = (
        cv2.GaussianBlur(v, (0, 0), look.blur_px) if look.blur_px else v
        for v in (coverage, light)
    )
    ys, xs = (
        slice(max(y0, 0), min(y1, look.height)),
        slice(max(x0, 0), min(x1, look.width)),
    )
    if ys.start >= ys.stop or xs.start >= xs.stop:
        return
    cov = coverage[ys.start - y0 : ys.stop - y0, xs.start - x0 : xs.stop - x0]
    lit = light[ys.start - y0 : ys.stop - y0, xs.start - x0 : xs.stop - x0]
    behind = image[ys, xs]
    if paint is None:
        image[ys, xs] = behind * (1 - cov) + lit
    else:
        value, cov = paint(cov, behind)
        image[ys, xs] = behind * (1 - cov) + value * cov


def _digitise(image: np.ndarray, look: Look, rng: np.random.Generator) -> np.ndarray:
    if look.bits == 16:
        return np.clip(np.round(image * 200), 0, 65535).astype(np.uint16)
    grey = np.clip(np.round(image), 0, 255).astype(np.uint8)
    if not look.colour:
        return grey
    return np.stack(
        [
            grey,
            np.clip(grey * 0.92, 0, 255).astype(np.uint8),
            np.clip(grey * 0.6, 0, 255).astype(np.uint8),
        ],
        axis=2,
    )


def write_frames(
    recording: Recording, frames: Iterable[np.ndarray], *, suffix: str = ".png"
) -> Recording:
    """Write recording.toml and numbered frames; returns the recording with its
    files."""
    folder = recording.path / "frames"
    folder.mkdir(parents=True, exist_ok=True)
    files = []
    for n, frame in enumerate(frames):
        files.append(folder / f"{n:06d}{suffix}")
        Image.fromarray(frame).save(
            files[-1], compress_level=1
        ) if suffix == ".png" else Image.fromarray(frame).save(files[-1])
    recording = replace(recording, evidence="frames", files=tuple(files))
    write_recording(recording)
    return recording


def write_video(
    recording: Recording,
    frames: Iterable[np.ndarray],
    *,
    fps: float = 30.0,
    times: Sequence[float] | np.ndarray | None = None,
    codec: str = "libx264",
    name: str = "video.mp4",
    quality: str = "18",
) -> Recording:
    """Write recording.toml and a video (H.264 by default); `times` [s] gives uneven
    time stamps, as phones have them."""
    from fractions import Fraction

    import av

    recording.path.mkdir(parents=True, exist_ok=True)
    file: Path = recording.path / name
    with av.open(str(file), "w") as container:
        stream = None
        for n, frame in enumerate(frames):
            if stream is None:
                stream = cast(
                    av.VideoStream,
                    container.add_stream(
                        codec, rate=Fraction(fps).limit_denominator(1000)
                    ),
                )
                stream.width, stream.height, stream.pix_fmt = (
                    frame.shape[1],
                    frame.shape[0],
                    "yuv420p",
                )
                stream.codec_context.time_base = Fraction(1, 90000)
                if codec == "libx264":
                    stream.options = {"crf": quality, "preset": "veryfast"}
            picture = av.VideoFrame.from_ndarray(
                frame, format="gray" if frame.ndim == 2 else "rgb24"
            )
            picture.time_base = Fraction(1, 90000)
            picture.pts = round((times[n] if times is not None else n / fps) * 90000)
            for packet in stream.encode(picture):
                container.mux(packet)
        for packet in stream.encode(None) if stream else ():
            container.mux(packet)
    recording = replace(recording, evidence="video", files=(file,))
    write_recording(recording)
    return recording
