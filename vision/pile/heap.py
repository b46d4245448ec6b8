"""Geometry of a pile's profile: walls, crest, toes, flanks.

A profile is the row y_px (down) of the surface in each column x; heights are measured
up from the base line."""

from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
from scipy.ndimage import median_filter, uniform_filter1d

from benchtwin.bench.language import tr

# a plate farther from level than this is taken for a slope
MAX_PLATE_SLOPE = np.tan(np.radians(6.0))
CLIFF = 2.5  # px per px: steeper is a wall, no seed pile stands at 68°
CREST = 0.95  # of the crest's height: what is higher may be the crest
# no flank of seeds falls by so much of the crest's height over so much of it
ABRUPT, ABRUPT_WIDE = 0.5, 0.1
TOE = 0.02  # of the crest's height: where the pile ends
# of the crest's height: a second hump, and where its foot is
SECOND, SECOND_FOOT = 0.4, 0.1
WALL = "a wall or nothing on this side"
STATED_WALL = "a wall, as stated"
# of the height, beside a wall's cliff: what is level so far to LEVEL_PX is a box's top
LEVEL_TOP, LEVEL_PX = 0.15, 1.0
TWO_PILES = "two piles in the picture: name the one to measure by --roi"
NOTHING_RISES = "no pile in the picture: nothing rises above the plate"
LEAST_WIDE = 1.2  # of its own height: the foot of a pile of 45°, of the least such hump


@dataclass(frozen=True)
class BaseLine:
    """The line that the pile stands on: y_px = intercept + slope · x, and how it was
    found (base_line.BASES). sd: of its height below the pile's middle [px]; pitch_deg:
    by how much the camera looks down, where the bow of the pile's foot tells it; doubt:
    what in the picture contradicts it."""

    intercept: float
    slope: float
    slope_sd: float
    source: str
    sd: float
    pitch_deg: float = 0.0
    doubt: str = ""

    def at(self, x: Any) -> Any:
        """y_px at x, a number or an array."""
        return self.intercept + self.slope * np.asarray(x, dtype=float)


@dataclass(frozen=True)
class Flank:
    """One side of the pile: columns from crest to toe, or the reason why it cannot be
    measured."""

    side: str  # "left" | "right"
    crest: int
    toe: int
    problem: str = ""

    @property
    def at_wall(self) -> bool:
        """Whether the pile leans on a wall on this side."""
        return self.problem in (WALL, STATED_WALL)


@dataclass(frozen=True)
class Heap:
    """Crest and flanks; `height_px` above the base line, `walls` as column ranges,
    `crest_width` in columns, `problem` if there is no single pile; `boxed`: the crest
    is level as a box's top is, and falls off at once on one side."""

    crest: int
    height_px: float
    flanks: tuple[Flank, ...]
    walls: tuple[tuple[int, int], ...]
    problem: str = ""
    crest_width: float = 0.0
    boxed: bool = False


def find_heap(
    profile: np.ndarray,
    base: BaseLine,
    window: tuple[float, float],
    walled: bool = True,
) -> Heap:
    """Crest and flanks of the tallest part of the profile (n,), without box walls where
    it may have some; window: shares of the height to be spanned."""
    x = np.arange(profile.size)
    height = base.at(x) - profile
    walls = _walls(height) if walled else ()
    free = np.isfinite(height)
    for low, high in walls:
        free[low:high] = False
    gap = max(2, profile.size // 100)
    pieces = [p for p in _true_ranges(free, gap=gap) if p[1] - p[0] >= 8]
    if not pieces:
        return Heap(0, 0.0, (), walls, tr("no pile in the picture"))
    smooth = _smooth(height, free)
    span = [np.nanmax(smooth[a:b]) for a, b in pieces]
    low, high = pieces[int(np.argmax(span))]
    crest = low + int(np.nanargmax(smooth[low:high]))
    reach = max(3, height.size // 50)
    near = np.flatnonzero(free & np.isfinite(height))
    near = near[np.abs(near - crest) <= reach]
    top = float(median_filter(height[near], 5, mode="nearest").max())
    if top < 8 or top < 0.02 * profile.size:
        return Heap(crest, top, (), walls, tr(NOTHING_RISES))
    if profile[crest] <= 1:
        return Heap(
            crest, top, (), walls, tr("the pile is cut by the picture's top border")
        )
    sharp = median_filter(np.where(np.isfinite(height), height, 0.0), 5, mode="nearest")
    flanks = tuple(
        _flank(side, smooth, sharp, crest, top, low, high, window, walled)
        for side in ("left", "right")
    )
    flat = float(np.sum(smooth[low:high] > CREST * smooth[crest]))
    problem = _second_pile(sharp, free, top, flanks)
    boxed = walled and any(
        f.problem == WALL and _level_columns(height, crest, f.side) > LEVEL_TOP * top
        for f in flanks
    )
    return Heap(crest, top, flanks, walls, problem, flat, boxed)


def _level_columns(height: np.ndarray, crest: int, side: str) -> int:
    """How many columns from the crest on, away from that side, are as high as it is."""
    inward = height[crest:] if side == "left" else height[crest::-1]
    other = np.flatnonzero(~(np.abs(inward - height[crest]) <= LEVEL_PX))
    return int(other[0]) if other.size else inward.size


def _smooth(height: np.ndarray, free: np.ndarray) -> np.ndarray:
    """Running mean over 2 % of the columns, gaps bridged, NaN outside."""
    have = free & np.isfinite(height)
    x = np.arange(height.size)
    bridged = np.interp(x, x[have], height[have])
    smooth = uniform_filter1d(bridged, max(3, height.size // 50) | 1, mode="nearest")
    return np.where(free, smooth, np.nan)


def _walls(height: np.ndarray) -> tuple[tuple[int, int], ...]:
    """Column ranges of box walls: flat-topped, high, and cut off by a cliff on at least
    one side."""
    filled = np.where(np.isfinite(height), height, 0.0)
    top = float(np.percentile(filled, 99.5))
    cliffs = _cliffs(filled, least=max(0.12 * top, 6.0))
    marks = sorted({0, height.size, *cliffs})
    walls = []
    for low, high in pairwise(marks):
        if high - low < 3 or (low not in cliffs and high not in cliffs):
            continue
        inner = filled[low + 1 : high - 1]
        beside = [filled[e] for e in (low - 4, high + 3) if 0 <= e < height.size]
        if len(beside) == 2 and np.median(inner) - min(beside) < high - low:
            continue  # a seed on top of others: no farther down than it is wide
        low_q, high_q = np.percentile(inner, [5, 95])
        flat = high_q - low_q <= max(3.0, 0.03 * top, 0.12 * inner.size)
        if flat and np.median(inner) > 0.3 * top and inner.size < 0.4 * height.size:
            walls.append((max(0, low - 2), min(height.size, high + 2)))
    return tuple(walls)


def _cliffs(height: np.ndarray, least: float) -> list[int]:
    """Columns in the middle of every drop or rise steeper than CLIFF that amounts to
    `least` px."""
    step = np.diff(height)
    runs = [*_true_ranges(step >= CLIFF, 0), *_true_ranges(step <= -CLIFF, 0)]
    return [(i + j) // 2 + 1 for i, j in runs if abs(step[i:j].sum()) >= least]


def _true_ranges(flags: np.ndarray, gap: int) -> list[tuple[int, int]]:
    """Ranges where `flags` holds, bridging holes of up to `gap` columns."""
    where = np.flatnonzero(flags)
    pieces = np.split(where, np.flatnonzero(np.diff(where) > gap + 1) + 1)
    return [(int(p[0]), int(p[-1]) + 1) for p in pieces if p.size]


def _flank(
    side: str,
    smooth: np.ndarray,
    sharp: np.ndarray,
    crest: int,
    top: float,
    low: int,
    high: int,
    window: tuple[float, float],
    walled: bool,
) -> Flank:
    """From the crest outwards to the first column lower than TOE of the height, or to
    where the surface ends."""
    at = np.arange(crest, low - 1, -1) if side == "left" else np.arange(crest, high)
    outward = smooth[at]
    ends = np.flatnonzero(outward < TOE * top)
    length = int(ends[0]) if ends.size else outward.size - 1
    # the running mean has rounded the toe: look for it in the unsmoothed surface nearby
    if ends.size:
        reach = max(3, smooth.size // 50)
        near = np.arange(max(length - reach, 1), min(length + reach, at.size))
        above = near[sharp[at][near] >= TOE * top]
        length = int(above[-1]) + 1 if above.size else length
        length = min(length, outward.size - 1)
    toe = int(at[length])
    lowest = float(np.nanmin(outward[: length + 1])) / top
    cut = toe <= 1 or toe >= smooth.size - 2
    ended = tr("the pile is cut by the picture's {} border", side) * cut
    beyond = sharp[crest::-1] if side == "left" else sharp[crest:]
    some = min(length + round(ABRUPT_WIDE * top) + 1, outward.size)
    upwards = outward[: length + 1][::-1]
    upwards = upwards[np.isfinite(upwards)]  # a gap would make NaN of all above it
    again = np.max(np.maximum.accumulate(upwards) - upwards, initial=0.0)
    told = (
        (length < 8 or length < 0.25 * top, WALL),
        # what is not known to be of seeds alone may be a wall itself
        (
            _falls_at_once(beyond[:some], top),
            tr("the surface falls at once: a wall?") if walled else WALL,
        ),
        (
            not ends.size and lowest > window[0] * 0.9,
            tr(
                "{} at {:.0f} % of its height",
                ended or "the surface ends",
                100 * lowest,
            ),
        ),
        (
            again > 0.2 * top,
            tr(
                "the surface falls and rises again: two piles, or something in front of"
                " it"
            ),
        ),
    )
    return Flank(side, crest, toe, next((why for holds, why in told if holds), ""))


def _falls_at_once(outward: np.ndarray, top: float) -> bool:
    """Whether the surface falls, going outward, by ABRUPT of the height within
    ABRUPT_WIDE of it: seeds stay so on a wall only."""
    wide = max(round(ABRUPT_WIDE * top), 2)
    falls = outward[:-wide] - outward[wide:]
    return bool(falls.size and falls.max() > ABRUPT * top)


def _second_pile(
    sharp: np.ndarray, free: np.ndarray, top: float, flanks: tuple[Flank, ...]
) -> str:
    """The problem that another hump of more than SECOND of the height lies beyond the
    toes; "" where none does. A single seed is as wide as high, which no pile is."""
    low, high = min(f.toe for f in flanks), max(f.toe for f in flanks)
    outside = np.where(free, sharp, 0.0)
    outside[low : high + 1] = 0.0
    for a, b in _true_ranges(outside > SECOND_FOOT * top, gap=1):
        tall = float(outside[a:b].max())
        inside = a > 2 and b < sharp.size - 2
        if inside and tall > SECOND * top and b - a >= LEAST_WIDE * tall:
            return tr(TWO_PILES)
    return ""
