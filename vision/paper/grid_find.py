"""Finds candidates for a grid in a picture by the spectra of small windows on several
scales."""

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import ArrayLike
from scipy import fft

WINDOW_PX = 64
PITCH_PX = (2.5, 13.0)  # distance of lines that is sought, in px of a level


@dataclass(frozen=True)
class Level:
    """The picture reduced by `fx`, `fy`: darkness of thin lines, high-pass filtered."""

    lines: np.ndarray
    fx: float
    fy: float

    @property
    def factor(self) -> float:
        return float(np.sqrt(self.fx * self.fy))

    def full(self, x: ArrayLike, y: ArrayLike) -> tuple[np.ndarray, np.ndarray]:
        """Full-resolution coordinates of this level's pixel coordinates."""
        return (np.asarray(x) + 0.5) * self.fx - 0.5, (
            np.asarray(y) + 0.5
        ) * self.fy - 0.5

    def reduced(self, x: ArrayLike, y: ArrayLike) -> tuple[np.ndarray, np.ndarray]:
        """This level's pixel coordinates of full-resolution coordinates."""
        return (np.asarray(x) + 0.5) / self.fx - 0.5, (
            np.asarray(y) + 0.5
        ) / self.fy - 0.5


@dataclass(frozen=True)
class GridCandidate:
    """A window of `level` in which two crossing waves stand out by `contrast` (power
    over the mean of its ring)."""

    level: int
    at: tuple[float, float]
    wave_u: np.ndarray
    wave_v: np.ndarray
    contrast: float


def pyramid(image: np.ndarray) -> list[Level]:
    """Levels reduced by 1, 2, 4, … of a grey float picture (0–1), down to a side of
    `WINDOW_PX`. The logarithm turns uneven illumination into an addend, which the
    high-pass filter removes. Values are clipped, since the step from paper to table is
    much stronger than a line."""
    height, width = image.shape
    levels: list[Level] = []
    while min(image.shape) >= min(WINDOW_PX, min(height, width)) and len(levels) < 7:
        dark = -np.log(image + np.float32(0.02))
        dark -= cv2.GaussianBlur(dark, (0, 0), WINDOW_PX / 8)
        np.clip(dark, -0.7, 0.7, out=dark)
        levels.append(Level(dark, width / image.shape[1], height / image.shape[0]))
        half = (image.shape[1] // 2, image.shape[0] // 2)
        image = cv2.resize(image, half, interpolation=cv2.INTER_AREA)
    return levels


def find_candidates(levels: list[Level]) -> list[GridCandidate]:
    """The windows most like a grid, up to three for each level, best first: two
    perpendicular waves of one length."""
    found = []
    for index, level in enumerate(levels):
        found += _level_candidates(index, level)
    return sorted(found, key=lambda s: -s.contrast)


def _level_candidates(index: int, level: Level) -> list[GridCandidate]:
    height, width = level.lines.shape
    size = min(WINDOW_PX, height, width)
    step = size // 2 if index else size * 3 // 4
    ys, xs = (
        np.unique(
            np.linspace(0, n - size, max(1, -(-(n - size) // step) + 1)).astype(int)
        )
        for n in (height, width)
    )
    windows = np.lib.stride_tricks.sliding_window_view(level.lines, (size, size))[
        np.ix_(ys, xs)
    ].reshape(-1, size, size)
    hann = np.hanning(size + 2)[1:-1].astype(np.float32)
    fy, fx = np.meshgrid(fft.fftfreq(WINDOW_PX), fft.rfftfreq(WINDOW_PX), indexing="ij")
    radius = np.hypot(fy, fx)
    ring = (radius > 1 / PITCH_PX[1]) & (radius < 1 / PITCH_PX[0])
    places = [(y, x) for y in ys for x in xs]
    best: list[tuple[float, int, np.ndarray, np.ndarray]] = []
    for start in range(0, len(windows), 512):  # in portions, to stay small in memory
        cut = windows[start : start + 512] * np.outer(hann, hann)
        spectra = fft.rfft2(cut, s=(WINDOW_PX, WINDOW_PX), workers=2)
        power = spectra.real**2 + spectra.imag**2
        ringed = power * ring
        mean = ringed.sum((1, 2)) / ring.sum() + 1e-12
        contrast = ringed.max((1, 2)) / mean
        contrast[mean < 1e-9] = 0  # a window of one even colour
        for i in np.argsort(-contrast)[:40]:
            if contrast[i] > 8:
                best.append(_pair(power[i], ringed[i], mean[i], start + i))
    best = sorted((b for b in best if b[0] > 5), key=lambda b: -b[0])[:3]
    half = (size - 1) / 2
    found = []
    for score, i, u, v in best:
        x, y = level.full(places[i][1] + half, places[i][0] + half)
        found.append(GridCandidate(index, (float(x), float(y)), u, v, score))
    return found


def _pair(power: np.ndarray, ringed: np.ndarray, mean: float, window: int):
    """The best pair of perpendicular waves in a half-plane spectrum: (contrast of the
    weaker, window, wave_u, wave_v)."""
    blank = np.zeros(2)
    best = (0.0, window, blank, blank)
    rest = ringed.copy()
    # the strongest wave may have no partner (stripes, a harmonic): try the next ones
    for _ in range(4):
        iy, ix = np.unravel_index(int(np.argmax(rest)), power.shape)
        first = _peak(power, int(iy), int(ix))
        turned = np.array([-first[1], first[0]])
        if turned[0] < 0:
            turned = -turned
        jy, jx = round(turned[1] * WINDOW_PX), round(turned[0] * WINDOW_PX)
        near = [
            (y % WINDOW_PX, x)
            for y in range(jy - 2, jy + 3)
            for x in range(max(0, jx - 2), min(power.shape[1], jx + 3))
        ]
        jy, jx = max(near, key=lambda p: ringed[p])
        second = _peak(power, jy, jx)
        score = min(ringed[iy, ix], ringed[jy, jx]) / mean
        if score > best[0]:
            best = (float(score), window, *_upright(first, second))
        rows = np.arange(iy - 2, iy + 3) % WINDOW_PX
        rest[rows, max(0, ix - 2) : ix + 3] = 0
    return best


def _peak(power: np.ndarray, iy: int, ix: int) -> np.ndarray:
    """Wave vector (x, y) [cycles per px] of a spectral peak, between the bins by a
    parabola through the log power."""

    def shift(before, here, after):
        a, b, c = (np.log(p + 1e-20) for p in (before, here, after))
        bend = a - 2 * b + c
        if bend < 0 and min(before, after) > 0:
            return float(np.clip(0.5 * (a - c) / bend, -0.5, 0.5))
        return 0.0

    rows, columns = power.shape
    dy = shift(power[iy - 1, ix], power[iy, ix], power[(iy + 1) % rows, ix])
    left = power[-iy % rows, 1] if ix == 0 else power[iy, ix - 1]
    dx = shift(left, power[iy, ix], power[iy, min(ix + 1, columns - 1)])
    y = iy if iy < rows // 2 else iy - rows
    return np.array([(ix + dx) / WINDOW_PX, (y + dy) / WINDOW_PX])


def _upright(first: np.ndarray, second: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The waves as (u, v): u points right, v down, each within 45° of its axis."""
    u, v = (first, second) if abs(first[0]) >= abs(first[1]) else (second, first)
    u, v = u * (1 if u[0] >= 0 else -1), v * (1 if v[1] >= 0 else -1)
    return u, v
