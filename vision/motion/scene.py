"""The still scene behind a moving seed: what the picture looks like without it, and how noisy a pixel is.

The background is the median of frames sampled evenly in *motion*, not in time: a seed that rests for most of the film
fills only few of the samples and does not become background.
"""

import itertools
from collections.abc import Callable
from dataclasses import dataclass

import cv2
import numpy as np

from vision.evidence.frames import FrameSource
from vision.measurement import MeasurementError

COARSE_WIDTH = 320  # moving things are looked for on a picture about this wide
MEDIAN_FRAMES = 25
SHADING = 0.05  # of the greatest change between two frames: below it light changes, nothing moves


@dataclass(frozen=True)
class Scene:
    """background: float32 grey (h, w). weights: (3,) that make a colour frame grey, None for grey frames.

    factor: by how much the coarse picture is smaller; coarse: its background; coarse_noise: sd of a coarse pixel.
    noise: sd of a pixel; noise_spread ≥ 1: by how much neighbouring pixels' common noise enlarges the variance of sums.
    """

    background: np.ndarray
    weights: np.ndarray | None
    factor: int
    coarse: np.ndarray
    noise: float
    coarse_noise: float
    noise_spread: float
    white: float
    first: np.ndarray

    @property
    def shape(self) -> tuple[int, int]:
        height, width = self.background.shape
        return height, width

    def grey(self, pixels: np.ndarray) -> np.ndarray:
        return grey(pixels, self.weights)

    def coarse_difference(self, pixels: np.ndarray) -> tuple[np.ndarray, float]:
        """The coarse picture less the background, and the light's gain on it (slow drift, flicker)."""
        height, width = self.coarse.shape
        small = cv2.resize(pixels, (width, height), interpolation=cv2.INTER_AREA)
        small = grey(small, self.weights)
        gain = float(np.median(small[::3, ::3] / self.coarse[::3, ::3]))
        return small - gain * self.coarse, gain


def grey(pixels: np.ndarray, weights: np.ndarray | None) -> np.ndarray:
    """float32 grey; colour by `weights`."""
    if pixels.ndim == 2:
        return pixels.astype(np.float32)
    if weights is None:
        return cv2.cvtColor(pixels, cv2.COLOR_RGB2GRAY).astype(np.float32)
    return cv2.transform(pixels.astype(np.float32), weights.reshape(1, 3).astype(np.float32)).reshape(pixels.shape[:2])


def learn_scene(source: FrameSource, still: Callable[[list[np.ndarray]], list[np.ndarray]] | None = None) -> Scene:
    """Background, noise and colour weights from frames sampled over the whole recording.

    still(pictures) → pictures whose median is the background; without it, those spaced evenly in motion.
    """
    frames = source.sample(61)
    if len(frames) < 3:
        raise MeasurementError(f"{source.path}: {len(frames)} frames can be read; tracking needs at least 3")
    first = frames[0]
    chosen = even_in_motion(frames)
    middle = _median(chosen if still is None else still(frames))
    weights = _telling_colour(chosen, middle) if middle.ndim == 3 else None
    background = grey(middle, weights)
    height, width = background.shape
    factor = max(1, round(width / COARSE_WIDTH))
    small = (max(1, width // factor), max(1, height // factor))
    coarse = np.maximum(cv2.resize(background, small, interpolation=cv2.INTER_AREA), 1.0)
    noise, spread, coarse_noise = _noise(frames[:: max(1, len(frames) // 7)], background, weights, coarse)
    return Scene(background, weights, factor, coarse, noise, coarse_noise, spread, float(np.iinfo(first.dtype).max), first)


def even_in_motion(frames: list[np.ndarray]) -> list[np.ndarray]:
    """MEDIAN_FRAMES of the frames, evenly spaced in how much has moved up to each."""
    if len(frames) <= 5:
        return frames
    moved = _motion_between(frames)
    moved = np.maximum(moved, 0.02 * moved.max() + 1e-12)  # a little for time, so that nothing is skipped
    path = np.concatenate([[0.0], np.cumsum(moved)])
    wanted = np.linspace(0, path[-1], min(MEDIAN_FRAMES, len(frames)))
    # A frame may be taken several times: of a seed that moves for an instant only, those few frames have to outvote its rest.
    return [frames[i] for i in np.searchsorted(path, wanted - 1e-12).clip(0, len(frames) - 1)]


def _motion_between(frames: list[np.ndarray]) -> np.ndarray:
    """Share of the picture that changes from each frame to the next, (n − 1,); light that changes slowly is not motion."""
    height, width = frames[0].shape[:2]
    size = (min(width, 160), max(1, round(height * min(width, 160) / width)))
    small = [cv2.resize(grey(f, None), size, interpolation=cv2.INTER_AREA) for f in frames]
    even = [s / max(float(np.median(s)), 1e-6) for s in small]
    change = np.array([np.abs(b - a) for a, b in itertools.pairwise(even)])
    # In a picture without noise the median is 0, and a thing that shades itself as it turns would pass for one that moves.
    level = max(8 * float(np.median(change)) + 0.01, SHADING * float(change.max()))
    return (change > level).mean(axis=(1, 2))


def _median(frames: list[np.ndarray]) -> np.ndarray:
    """Pixel by pixel, in bands of rows to keep memory small. Frames of another brightness are scaled to the first's."""
    level = [float(np.median(f[::7, ::7])) for f in frames]
    usual = float(np.median(level))
    gain = [usual / v if v > 0 else 1.0 for v in level]
    steady = max(gain) / min(gain) < 1.003
    out: np.ndarray = np.empty(frames[0].shape, dtype=np.float32)
    for top in range(0, out.shape[0], 64):
        band = np.stack([f[top : top + 64] for f in frames])
        if not steady:
            band = band * np.array(gain, dtype=np.float32).reshape(-1, *[1] * (band.ndim - 1))
        half = len(frames) // 2
        out[top : top + 64] = np.partition(band, half, axis=0)[half]
    return out


def _telling_colour(frames: list[np.ndarray], background: np.ndarray) -> np.ndarray:
    """The direction in colour along which what moves differs most from what is behind it; as weights that sum to 1."""
    differences = []
    for frame in frames[::3]:
        change = frame[::2, ::2].astype(np.float32) - background[::2, ::2]
        strength = np.abs(change).sum(axis=2)
        differences.append(change[strength > max(12 * float(np.median(strength)), 1e-6)][:20_000])
    moved = np.concatenate(differences)
    plain = np.array([0.299, 0.587, 0.114])
    if len(moved) < 50:
        return plain
    _, vectors = np.linalg.eigh(moved.T @ moved)
    telling = np.abs(vectors[:, -1])
    # Of mixed signs it would make the background dark, where a gain (drifting light) can no longer be told.
    one_sign = (vectors[:, -1] >= -0.1).all() or (vectors[:, -1] <= 0.1).all()
    return telling / telling.sum() if one_sign else plain


def _noise(frames, background, weights, coarse) -> tuple[float, float, float]:
    """sd of a pixel, variance factor of neighbouring pixels' common noise, sd of a coarse pixel."""
    sds, spreads, coarse_sds = [], [], []
    for frame in frames:
        plain = grey(frame, weights)
        gain = float(np.median(plain[::5, ::5] / np.maximum(background[::5, ::5], 1.0)))
        off = plain - gain * background
        sds.append(max(_spread(off), 0.3))
        clear = np.clip(off, -4 * sds[-1], 4 * sds[-1])
        own = float((clear**2).mean())
        near = float((clear[:, 1:] * clear[:, :-1]).mean() + (clear[1:] * clear[:-1]).mean()) / own if own > 0 else 0.0
        spreads.append(min(max(1.0, 1 + 2 * near), 6.0))
        small = cv2.resize(plain, coarse.shape[::-1], interpolation=cv2.INTER_AREA) - gain * coarse
        coarse_sds.append(_spread(small))
    return float(np.median(sds)), float(np.median(spreads)), max(float(np.median(coarse_sds)), 0.15)


def _spread(off: np.ndarray) -> float:
    """sd of the still part: from the median and from the 95th percentile of the deviation, the larger.

    A video's codec repeats most of the picture unchanged and errs in the rest, which the median alone does not see.
    """
    size = np.abs(off - np.median(off))
    return max(1.4826 * float(np.median(size)), float(np.percentile(size[::2, ::2], 95)) / 1.96)
