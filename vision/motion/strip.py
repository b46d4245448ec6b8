"""The frames as a tilting plate sees them: a strip along its line, the same place on the plate in the same pixel."""

from collections.abc import Iterator
from dataclasses import replace

import cv2
import numpy as np

from vision.evidence.frames import Frame, FrameSource, affordable
from vision.motion.edge_line import Line
from vision.motion.scene import MEDIAN_FRAMES, even_in_motion, grey

CLOSER = 16  # pictures of the end of the film, to see the plate where the block was
COLUMNS = 400  # of a strip from which a row's usual brightness is taken
STAYS, GONE = 0.25, 0.8  # share of what stood out at the block's first place that has left it


class PlateFrames(FrameSource):
    """A view of `source`: the frames with a known line, turned so that the plate rests.

    pivot: where the plate turns [px]. reach: from where to where along the plate, from the pivot's foot [px]; above, below:
    rows on either side of the line.

    What runs along the whole plate and changes as it tilts (its upper face seen more or less edge-on, its light, the ground
    that passes behind it) is no motion on the plate: every row is brought to the brightness it has in the first strip seen.
    """

    def __init__(
        self, source: FrameSource, lines: dict[int, Line], pivot: np.ndarray, reach: tuple[int, int], above: int, below: int
    ):
        super().__init__(path=source.path, count=len(lines), fps=source.fps, notes=source.notes)
        self._source, self._lines, self._pivot = source, lines, pivot
        self._reach, self._above, self._below = reach, above, below
        self._usual: np.ndarray | None = None

    @property
    def height(self) -> int:
        return self._above + self._below

    def iterate(self) -> Iterator[Frame]:
        for frame in self._source.iterate():
            if frame.index in self._lines:
                yield self._seen(frame)

    def picked(self, n: int, between: tuple[int, int] | None = None) -> list[Frame]:
        return [self._seen(frame) for frame in self._source.picked(n, between) if frame.index in self._lines]

    def sample(self, n: int) -> list[np.ndarray]:
        """As elsewhere, and a closer look at the end, from the block's leaving on: it rests for most of a film, and slides for
        an instant.
        """
        first = next(self.iterate(), None)
        n = n if first is None else affordable(n, first.pixels)
        frames = self.picked(n)
        left = _left([frame.pixels for frame in frames])
        gone = 0 if left is None else int(np.argmax(left[1] > GONE))
        if gone > 0 and len(frames) - gone < CLOSER:
            closer = self.picked(CLOSER, (frames[gone - 1].index, frames[-1].index))
            frames = sorted({f.index: f for f in [*frames, *closer]}.values(), key=lambda f: f.index)
        return [frame.pixels for frame in frames]

    def matrix(self, index: int) -> np.ndarray:
        """Strip pixel → picture pixel, (2, 3)."""
        line = self._lines[index]
        foot = line.foot(self._pivot)
        origin = foot + self._reach[0] * line.along - self._above * line.across
        return np.column_stack([line.along, line.across, origin])

    def _seen(self, frame: Frame) -> Frame:
        size = (self._reach[1] - self._reach[0], self.height)
        flags = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
        strip = cv2.warpAffine(frame.pixels, self.matrix(frame.index), size, flags=flags, borderMode=cv2.BORDER_REPLICATE)
        rows = _row_levels(strip)
        if self._usual is None:
            self._usual = rows
        white = np.iinfo(frame.pixels.dtype).max
        steady = np.clip(np.round(strip + (self._usual - rows)[:, None]), 0, white).astype(strip.dtype)
        return replace(frame, pixels=steady)


def _row_levels(strip: np.ndarray) -> np.ndarray:
    """Each row's usual brightness, (rows,) or (rows, 3): the mean of its middle half, which a block does not reach."""
    ordered = np.sort(strip[:, :: max(1, strip.shape[1] // COLUMNS)], axis=1)
    quarter = ordered.shape[1] // 4
    return ordered[:, quarter : ordered.shape[1] - quarter].mean(axis=1, dtype=np.float32)


def without_block(strips: list[np.ndarray]) -> list[np.ndarray]:
    """Pictures of the plate alone: where the block rests at first, from strips after it has left, elsewhere from before.

    Where nothing leaves a place for good, strips spaced evenly in motion, whose median the plate is.
    """
    left = _left(strips)
    if left is None:
        return even_in_motion(strips)
    place, share = left
    before, after = np.flatnonzero(share < STAYS), np.flatnonzero(share > GONE)
    before = before[before < after.min()]
    if not len(before):
        return even_in_motion(strips)
    pictures = []
    for i in range(MEDIAN_FRAMES):
        picture = strips[before[i * len(before) // MEDIAN_FRAMES]].copy()
        picture[:, place] = strips[after[i * len(after) // MEDIAN_FRAMES]][:, place]
        pictures.append(picture)
    return pictures


def _left(strips: list[np.ndarray]) -> tuple[np.ndarray, np.ndarray] | None:
    """Where the block rests at first (bool, columns), and what share of it has left there in each strip.

    The block stands out from the rows it is in, and ceases to where it leaves: what else stands out, stays. None where
    nothing is left by the last strip.
    """
    if len(strips) < 4:
        return None
    factor = max(1, strips[0].shape[1] // COLUMNS)
    outstanding = []
    for strip in strips:
        plain = grey(strip)
        plain = plain[:, : plain.shape[1] // factor * factor]
        small = cv2.resize(plain, (plain.shape[1] // factor, max(1, plain.shape[0] // factor)), interpolation=cv2.INTER_AREA)
        outstanding.append(np.abs(small - np.median(small, axis=1, keepdims=True)).sum(axis=0))
    profile = cv2.GaussianBlur(np.array(outstanding), (5, 1), 1.0)
    first = np.median(profile[:3], axis=0)
    gone = first - profile[-1]
    if gone.max() < 8 * np.median(np.abs(gone)):
        return None
    weight = np.where(gone > 0.3 * gone.max(), gone, 0.0)
    share = (first - profile) @ weight / (gone @ weight)
    place = cv2.dilate((gone > 0.1 * gone.max()).astype(np.uint8)[None], np.ones((1, 7), np.uint8))[0] > 0
    return place[np.minimum(np.arange(strips[0].shape[1]) // factor, len(place) - 1)], share
