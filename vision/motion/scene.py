"""The static scene behind a moving seed: background and noise of each pixel.

The background is the median of frames sampled evenly in motion, not in time, so that a
seed that rests for most of the film does not become background."""

import itertools
from dataclasses import dataclass, replace

import cv2
import numpy as np

from benchtwin.bench.language import tr
from benchtwin.bench.robust import robust_sd
from benchtwin.vision.evidence.frames import FrameSource
from benchtwin.vision.measurement import require

COARSE_WIDTH = 320  # px of the picture on which moving things are detected
MEDIAN_FRAMES = 25
# of the greatest change between two frames: less is a change of light, not motion
LEAST_CHANGE = 0.05
# deviation, in units of the median one, above which a pixel has more noise than the
# others
RESTLESS = 2.0
SURROUNDINGS = 0.5  # of the picture's lesser side
COARSER = 4  # coarse pixels over which the light is a mean
LEAST_SHADE = 0.02  # relative change of the illumination; less is noise
# Orthonormal: brightness and two colours; a grey picture has only the first.
AXES = np.array([[1.0, 1.0, 1.0], [1.0, 0.0, -1.0], [1.0, -2.0, 1.0]])
AXES /= np.linalg.norm(AXES, axis=1, keepdims=True)
# of white: video stores colours coarsely, with errors where something moves
HUE_FLOOR = 1.5 / 255


@dataclass(frozen=True)
class Scene:
    """background: the picture without the seed, float32 (h, w, c), c = 1 (grey) or 3
    colours.

    factor: full px per coarse px; coarse: the coarse picture's background; restless (h,
    w) ≥ 1: relative noise of each coarse pixel. matrix, coarse_matrix: colours → sds of
    the noise (in_sds). noise_spread ≥ 1: factor by which correlation of neighbouring
    pixels enlarges the variance of sums. white: the greatest grey level. first: the
    first frame."""

    background: np.ndarray
    factor: int
    coarse: np.ndarray
    matrix: np.ndarray
    coarse_matrix: np.ndarray
    restless: np.ndarray
    noise_spread: float
    white: float
    first: np.ndarray

    @property
    def shape(self) -> tuple[int, int]:
        height, width = self.background.shape[:2]
        return height, width

    @property
    def grey_background(self) -> np.ndarray:
        """The background in grey, float32 (h, w)."""
        return grey(self.background)

    def coarse_difference(
        self, pixels: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """The coarse picture less the background, the background, both in sds of the
        noise (h, w, c), and the light (h, w) relative to the background's."""
        height, width = self.coarse.shape[:2]
        small = colours(
            cv2.resize(pixels, (width, height), interpolation=cv2.INTER_AREA)
        )
        light = light_of(small, self.coarse)
        background = in_sds(light[..., None] * self.coarse, self.coarse_matrix)
        difference = in_sds(small, self.coarse_matrix) - background
        return ((difference) / self.restless[..., None], background, light)


def light_of(small: np.ndarray, coarse: np.ndarray) -> np.ndarray:
    """The light (h, w) of a coarse picture relative to its background's: that of the
    whole, for slow drift and flicker; where something beside the scene shades a part of
    it, that of the surroundings (their median), which are wider than any seed."""
    ratio = small.sum(axis=2) / coarse.sum(axis=2)
    whole = float(np.median(ratio[::3, ::3]))
    size = [max(n // COARSER, 1) for n in ratio.shape[::-1]]
    wide = int(SURROUNDINGS * min(size)) // 2 * 2 + 1
    steps = np.clip(128 * ratio / whole, 0, 255).astype(np.uint8)
    steps = cv2.medianBlur(cv2.resize(steps, size, interpolation=cv2.INTER_AREA), wide)
    near = cv2.GaussianBlur(steps.astype(np.float32) / 128, (0, 0), wide / 6)
    near = cv2.resize(near, ratio.shape[::-1])
    return whole * np.where(np.abs(near - 1) > LEAST_SHADE, near, 1.0)


def colours(pixels: np.ndarray) -> np.ndarray:
    """float32 (h, w, c)."""
    return np.atleast_3d(pixels).astype(np.float32)


def grey(pixels: np.ndarray) -> np.ndarray:
    """float32 (h, w)."""
    if pixels.ndim == 2 or pixels.shape[2] == 1:
        return pixels.reshape(pixels.shape[:2]).astype(np.float32)
    return cv2.cvtColor(pixels, cv2.COLOR_RGB2GRAY).astype(np.float32)


def learn_scene(source: FrameSource) -> Scene:
    """Estimate background and noise."""
    frames = source.sample(61)
    require(
        len(frames) >= 3,
        tr(
            "{}: {} frames can be read; tracking needs at least 3",
            source.path,
            len(frames),
        ),
    )
    first = frames[0]
    chosen = even_in_motion(frames)
    background = np.atleast_3d(_median(chosen))
    height, width = background.shape[:2]
    factor = max(1, round(width / COARSE_WIDTH))
    small = (max(1, width // factor), max(1, height // factor))
    coarse = np.maximum(
        np.atleast_3d(cv2.resize(background, small, interpolation=cv2.INTER_AREA)), 1.0
    )
    sd, spread, coarse_sd = _noise(
        frames[:: max(1, len(frames) // 7)], background, coarse
    )
    white = float(np.iinfo(first.dtype).max)
    steady = np.ones(coarse.shape[:2], np.float32)
    matrices = noise_matrix(sd, white), noise_matrix(coarse_sd, white)
    plain = Scene(background, factor, coarse, *matrices, steady, spread, white, first)
    return replace(plain, restless=_restless(chosen, plain))


def even_in_motion(frames: list[np.ndarray]) -> list[np.ndarray]:
    """MEDIAN_FRAMES of the frames, evenly spaced in the amount of motion."""
    if len(frames) <= 5:
        return frames
    height, width = frames[0].shape[:2]
    size = (min(width, 160), max(1, round(height * min(width, 160) / width)))
    small = [cv2.resize(grey(f), size, interpolation=cv2.INTER_AREA) for f in frames]
    even = [s / max(float(np.median(s)), 1e-6) for s in small]
    change = np.array([np.abs(b - a) for a, b in itertools.pairwise(even)])
    # In a picture without noise the median is 0, and the changing shading of a turning
    # thing would count as motion.
    level = max(8 * float(np.median(change)) + 0.01, LEAST_CHANGE * float(change.max()))
    moved = (change > level).mean(axis=(1, 2))
    # a little for time, so that nothing is skipped
    moved = np.maximum(moved, 0.02 * moved.max() + 1e-12)
    path = np.concatenate([[0.0], np.cumsum(moved)])
    wanted = np.linspace(0, path[-1], min(MEDIAN_FRAMES, len(frames)))
    # A frame may be taken several times, so that the few frames of a short motion
    # outvote the rest.
    return [
        frames[i]
        for i in np.searchsorted(path, wanted - 1e-12).clip(0, len(frames) - 1)
    ]


def _median(frames: list[np.ndarray]) -> np.ndarray:
    """Median of each pixel, of frames scaled to one brightness; in bands of rows to
    keep memory small."""
    level = [float(np.median(f[::7, ::7])) for f in frames]
    typical = float(np.median(level))
    gain = [typical / v if v > 0 else 1.0 for v in level]
    steady = max(gain) / min(gain) < 1.003
    out: np.ndarray = np.empty(frames[0].shape, dtype=np.float32)
    for top in range(0, out.shape[0], 64):
        band = np.stack([f[top : top + 64] for f in frames])
        if not steady:
            band = band * np.array(gain, dtype=np.float32).reshape(
                -1, *[1] * (band.ndim - 1)
            )
        half = len(frames) // 2
        out[top : top + 64] = np.partition(band, half, axis=0)[half]
    return out


def _noise(
    frames: list[np.ndarray], background: np.ndarray, coarse: np.ndarray
) -> tuple[np.ndarray, float, np.ndarray]:
    """sd of a pixel for each colour axis, variance factor of correlated neighbouring
    pixels, sds of a coarse pixel."""
    sds, spreads, coarse_sds = [], [], []
    for frame in frames:
        plain, size = colours(frame), coarse.shape[1::-1]
        small = cv2.resize(plain, size, interpolation=cv2.INTER_AREA)
        light = light_of(colours(small), coarse)
        whole = cv2.resize(light, plain.shape[1::-1])[..., None]
        off = colour_axes(plain - whole * background)
        sds.append([max(_spread(o), 0.3) for o in np.moveaxis(off, 2, 0)])
        clear = np.clip(off[..., 0], -4 * sds[-1][0], 4 * sds[-1][0])
        power = float((clear**2).mean())
        near = 0.0
        if power > 0:
            beside, below = clear[:, 1:] * clear[:, :-1], clear[1:] * clear[:-1]
            near = float(beside.mean() + below.mean()) / power
        spreads.append(min(max(1.0, 1 + 2 * near), 6.0))
        rest = colour_axes(colours(small) - light[..., None] * coarse)
        coarse_sds.append([_spread(o) for o in np.moveaxis(rest, 2, 0)])
    coarse_sd = np.maximum(np.median(coarse_sds, axis=0), 0.15)
    return (np.median(sds, axis=0), float(np.median(spreads)), coarse_sd)


def _restless(frames: list[np.ndarray], scene: Scene) -> np.ndarray:
    """Relative noise of each coarse pixel, float32 (h, w) ≥ 1: more at leaves, a lamp,
    a shaking edge."""
    off = np.array(
        [np.linalg.norm(scene.coarse_difference(frame)[0], axis=2) for frame in frames]
    )
    middle = np.median(off, axis=0)
    typical = max(float(np.median(middle)), 1.0)
    share = cv2.GaussianBlur((middle / typical).astype(np.float32), (0, 0), 1.0)
    return np.where(share > RESTLESS, share, 1.0).astype(np.float32)


def _spread(off: np.ndarray) -> float:
    """Robust sd: from the median or the 95th percentile of the deviations, whichever is
    larger. A video codec repeats most of the picture unchanged and has errors in the
    rest, which the median alone does not show."""
    size = np.abs(off - np.median(off))
    return max(robust_sd(size), float(np.percentile(size[::2, ::2], 95)) / 1.96)


def noise_matrix(sd: np.ndarray, white: float) -> np.ndarray:
    """(c, c): transforms colours to sds of the noise; sd (c,): of brightness and, for
    three colours, of the two other axes."""
    if len(sd) == 1:
        return np.array([[1 / sd[0]]], np.float32)
    hue = max(sd[0], HUE_FLOOR * white)
    return (AXES / np.maximum(sd, [0.0, hue, hue])[:, None]).astype(np.float32)


def colour_axes(colours: np.ndarray) -> np.ndarray:
    """(h, w, c): brightness and the two other axes."""
    if colours.shape[2] == 1:
        return colours
    return cv2.transform(colours, AXES.astype(np.float32))


def in_sds(colours: np.ndarray, matrix: np.ndarray) -> np.ndarray:
    """(h, w, c) float32 in sds of the noise."""
    if matrix.shape == (1, 1):
        return colours * matrix[0, 0]
    return cv2.transform(colours, matrix)


def weighted_product(
    a: np.ndarray, b: np.ndarray, background_sds: np.ndarray, shade: float
) -> np.ndarray:
    """Scalar product of two differences (…, c) where shadows of relative sd `shade`
    count as noise; all in sds of the noise. Of grey pictures, in which a shadow is a
    change like any other, the plain product."""
    plain = dot(a, b)
    if background_sds.shape[-1] == 1 or shade == 0:
        return plain
    return plain - dot(a, background_sds) * dot(b, background_sds) / (
        shade**-2 + dot(background_sds, background_sds)
    )


def dot(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Scalar product over the last axis."""
    product = a * b
    if product.ndim != 3:
        return product.sum(axis=-1)
    # a picture: some times as fast as einsum
    return cv2.transform(product, np.ones((1, product.shape[2]), product.dtype))
