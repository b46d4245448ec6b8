"""The frames of a film rotated with its tilting plate, so that the plate rests and only
the block on it moves, and all that is behind."""

from collections.abc import Iterator
from dataclasses import replace

import cv2
import numpy as np

from benchtwin.bench.language import tr
from benchtwin.vision.evidence.frames import Frame, FrameSource, limit_to_memory
from benchtwin.vision.motion.edge_line import Line
from benchtwin.vision.motion.scene import MEDIAN_FRAMES, grey
from benchtwin.vision.motion.track import Places, Track

ABOVE, BELOW = 110, 14  # px of a picture 640 px wide, of the plate's edge: the strip
AFTER_SLIDE = 16  # least number of pictures after the block has left its first place
STEADY = 6.0  # grey levels of 255, sd over the film: of rows that are the plate's
COLUMNS = 400  # of a strip that are used for a row's brightness
PICTURES, FARTHEST = 40, 5  # over the film; of them, those whose median is taken
PLATE_PX = 16.0  # of a picture 640 px wide: so near its edge the plate may be seen
ROWS = 16  # at a time
GONE = 0.8  # share of the block that has left its first place


def plate_frames(
    source: FrameSource, lines: dict[int, Line], shape: tuple[int, ...]
) -> "PlateFrames":
    """The frames rotated with the plate, from end to end of its edge."""
    pivot = _pivot(lines)
    ends = np.array(
        [
            [line.along @ (line.at(s) - line.foot(pivot)) for s in line.extent]
            for line in lines.values()
        ]
    )
    reach = (int(ends.min() - 10), int(ends.max() + 10))
    above, below = (round(px * shape[1] / 640) for px in (ABOVE, BELOW))
    return PlateFrames(source, lines, pivot, reach, above=above, below=below)


def _pivot(lines: dict[int, Line]) -> np.ndarray:
    """The pivot P of the plate: n·P − d = c for every line with normal n and offset c;
    d is constant."""
    normals = np.array([line.across for line in lines.values()])
    offsets = np.array([line.offset for line in lines.values()])
    design = np.column_stack([normals, -np.ones(len(normals))])
    # A small rotation hardly separates d from P; hinges lie near their plate: prior of
    # d, 600 times an edge's error.
    rows = np.vstack([design, [0.0, 0.0, 1 / 600]])
    return np.linalg.lstsq(rows, np.concatenate([offsets, [0.0]]), rcond=None)[0][:2]


class PlateFrames(FrameSource):
    """The frames of `source` with a known line, rotated so that the plate rests.

    pivot [px]; reach: first and last place along the plate, from the pivot's foot [px];
    above, below: rows on either side of the line; background: what is subtracted above
    the plate's own rows, or None. Changes along the whole plate as it tilts (its upper
    face, its illumination, the background behind it) are no motion: every row is
    brought to the brightness that it has in the first strip."""

    def __init__(
        self,
        source: FrameSource,
        lines: dict[int, Line],
        pivot: np.ndarray,
        reach: tuple[int, int],
        above: int,
        below: int,
        background: np.ndarray | None = None,
        plate_rows: int = 0,
    ):
        super().__init__(
            path=source.path, count=len(lines), fps=source.fps, notes=source.notes
        )
        self._source, self._lines, self._pivot = source, lines, pivot
        self._reach, self._above, self._below = reach, above, below
        self._first_levels: np.ndarray | None = None
        self._background, self._plate_rows = background, plate_rows

    @property
    def height(self) -> int:
        return self._above + self._below

    def without_background(self) -> "PlateFrames":
        """The same before an even grey, in the rows above the plate's own: those from
        its edge up that hardly change."""
        frames = self.picked(MEDIAN_FRAMES)
        levels = 255 / np.iinfo(frames[0].pixels.dtype).max
        sd = levels * np.array([grey(f.pixels) for f in frames]).std(axis=0)
        changes = np.median(sd, axis=1)[: self._above][::-1]
        plate_rows = max(int(np.argmax(changes > STEADY)), 1)
        cut = self._reach, self._above, self._below
        behind = background_of(self._source, self._lines, plate_rows), plate_rows
        return PlateFrames(self._source, self._lines, self._pivot, *cut, *behind)

    def iterate(self) -> Iterator[Frame]:
        frames = (f for f in self._source.iterate() if self._usable(f))
        return self._holding(map(self._warped, frames))

    def picked(self, n: int, between: tuple[int, int] | None = None) -> list[Frame]:
        near = self._source.picked(n, between)
        return [self._warped(frame) for frame in near if self._usable(frame)]

    def _usable(self, frame: Frame) -> bool:
        """Whether the plate is seen in a frame, and it has the background's size."""
        if frame.index not in self._lines:
            return False
        if self._background is None:
            return True
        alike = frame.pixels.shape == self._background.shape
        if not alike:
            self.note(
                tr("frame {} skipped: its size is not that of the others", frame.index)
            )
        return alike

    def sample(self, n: int) -> list[np.ndarray]:
        """About n strips spread over the film, and at least AFTER_SLIDE from after the
        slide, which may last an instant only."""
        first = next(self.iterate(), None)
        n = n if first is None else limit_to_memory(n, first.pixels)
        frames = self.picked(n)
        left = _block_departure([frame.pixels for frame in frames])
        gone = 0 if left is None else int(np.argmax(left > GONE))
        if gone > 0 and len(frames) - gone < AFTER_SLIDE:
            closer = self.picked(
                AFTER_SLIDE, (frames[gone - 1].index, frames[-1].index)
            )
            frames = sorted(
                {f.index: f for f in [*frames, *closer]}.values(), key=lambda f: f.index
            )
        return [frame.pixels for frame in frames]

    @property
    def downhill(self) -> float:
        """Sign of x along the plate, downwards."""
        return float(np.sign(np.median([line.angle for line in self._lines.values()])))

    def matrix(self, index: int) -> np.ndarray:
        """Affine map (2, 3) from px of the strip to px of the picture."""
        line = self._lines[index]
        foot = line.foot(self._pivot)
        origin = foot + self._reach[0] * line.along - self._above * line.across
        return np.column_stack([line.along, line.across, origin])

    def in_picture(self, track: Track) -> tuple[np.ndarray, np.ndarray]:
        """A track in the strip as columns and rows (n,) of the picture."""
        rows = self.height - 1 - track.y
        places = np.column_stack([track.x, rows, np.ones(len(track))])
        found = [self.matrix(int(f)) @ p for f, p in zip(track.frame, places)]
        columns, rows = np.array(found).T
        return columns, rows

    def places(self, places: Places) -> Places:
        """Places in the picture as places in the strip; those in frames without a line
        are left out, with a note."""
        if lost := sorted(places.keys() - self._lines.keys()):
            self.note(tr("[track] places_px: no plate is seen in frame {}", lost[0]))
        return {
            f: tuple(np.linalg.solve((m := self.matrix(f))[:, :2], places[f] - m[:, 2]))
            for f in places.keys() & self._lines.keys()
        }

    def follow(
        self, at: tuple[float, float, float] | None
    ) -> tuple[float, float, float] | None:
        """Frame, x, y in the picture as the same in the strip; None without a line
        there."""
        if at is None or not (found := self.places({int(at[0]): at[1:]})):
            return None
        ((frame, (x, y)),) = found.items()
        return frame, x, y

    def _warped(self, frame: Frame) -> Frame:
        strip = self._turned(frame.pixels, frame.index)
        # the mean of each row's middle half, which the block does not change
        some = strip[:, :: max(1, strip.shape[1] // COLUMNS)]
        quarter, count = some.shape[1] // 4, some.shape[1]
        middle = np.partition(some, (quarter, count - quarter - 1), axis=1)
        rows = middle[:, quarter : count - quarter].mean(axis=1, dtype=np.float32)
        if self._first_levels is None:
            self._first_levels = rows
        white = np.iinfo(frame.pixels.dtype).max
        levels = strip + (self._first_levels - rows)[:, None]
        if self._background is not None:
            difference = frame.pixels - self._background
            rows = slice(0, self._above - self._plate_rows)
            levels[rows] = white / 2 + self._turned(difference, frame.index)[rows]
        steady = np.clip(np.round(levels), 0, white).astype(strip.dtype)
        return replace(frame, pixels=steady)

    def _turned(self, pixels: np.ndarray, index: int) -> np.ndarray:
        size = (self._reach[1] - self._reach[0], self.height)
        flags = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
        return cv2.warpAffine(
            pixels,
            self.matrix(index),
            size,
            flags=flags,
            borderMode=cv2.BORDER_REPLICATE,
        )


def _block_departure(strips: list[np.ndarray]) -> np.ndarray | None:
    """The share of the block that has left its first place in each strip. The block
    differs from the median of its rows; where that difference vanishes it has left.
    None where nothing has left by the last strip."""
    if len(strips) < 4:
        return None
    factor = max(1, strips[0].shape[1] // COLUMNS)
    outstanding = []
    for strip in strips:
        plain = grey(strip)
        plain = plain[:, : plain.shape[1] // factor * factor]
        size = (plain.shape[1] // factor, max(1, plain.shape[0] // factor))
        small = cv2.resize(plain, size, interpolation=cv2.INTER_AREA)
        outstanding.append(
            np.abs(small - np.median(small, axis=1, keepdims=True)).sum(axis=0)
        )
    profile = cv2.GaussianBlur(np.array(outstanding), (5, 1), 1.0)
    first = np.median(profile[:3], axis=0)
    gone = first - profile[-1]
    if gone.max() < 8 * np.median(np.abs(gone)):
        return None
    weight = np.where(gone > 0.3 * gone.max(), gone, 0.0)
    return (first - profile) @ weight / (gone @ weight)


def background_of(
    source: FrameSource, lines: dict[int, Line], plate_rows: int
) -> np.ndarray:
    """The background, float32, of the shape and levels of frames in which the plate's
    edge is known; lines: by frame; plate_rows: how far above its edge the plate itself
    reaches [px].

    The camera stands still: each pixel is the median over the FARTHEST frames in which
    the edge is farthest from it, and plate and block are elsewhere. Near the hinge,
    where the plate hardly moves, they may be part of it."""
    first = next(source.iterate()).pixels
    number = limit_to_memory(PICTURES, first)
    frames = [f for f in source.picked(number) if f.index in lines]
    frames = [f for f in frames if f.pixels.shape == first.shape]
    pixels = np.array([np.atleast_3d(f.pixels) for f in frames])
    edges = [lines[f.index] for f in frames]
    across = np.array([edge.across for edge in edges], np.float32)[..., None, None]
    offset = np.array([edge.offset for edge in edges], np.float32)[:, None, None]
    height, width = first.shape[:2]
    near = max(PLATE_PX * width / 640, plate_rows + 2)
    columns, found = np.arange(width, dtype=np.float32), []
    for top in range(0, height, ROWS):
        rows = np.arange(top, min(top + ROWS, height), dtype=np.float32)[:, None]
        off = np.abs(across[:, 0] * columns + across[:, 1] * rows - offset)
        off[off < near] = 0.0
        best = np.argsort(-off, axis=0, kind="stable")[:FARTHEST]
        part = pixels[:, top : top + ROWS]
        found.append(np.median(np.take_along_axis(part, best[..., None], 0), axis=0))
    return np.concatenate(found).astype(np.float32).reshape(first.shape)
