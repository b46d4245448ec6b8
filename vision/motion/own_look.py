"""Places of a block by its own look, in pictures that are turned with its plate, where
the background does not tell it: before it moves, or before a busy wall.

The pictures are laid over each other by the places that are known. What belongs to the
block looks alike in all of them, what lies behind it changes. With each pixel weighed
by one over its variance, the block is where the sum of squared differences is least
(template matching); laid over each other anew by these places it looks sharper."""

from collections.abc import Iterable
from dataclasses import dataclass, replace

import cv2
import numpy as np
from benchtwin.bench.robust import difference_noise
from benchtwin.vision.evidence.frames import Frame, FrameSource
from benchtwin.vision.motion.track import make_track
from benchtwin.vision.motion.track_seed import TrackedSeed

LATE = 8  # frames before the first place, from which on earlier ones are sought
LEARNT_FROM = 40  # pictures, about
ROUNDS = 4  # of laying pictures over each other
WIDE, HIGH = 2.4, 1.6  # of the block's size: the part of a picture that is compared
# of the block's size: how far from where it is expected it is sought: where it was
# found, before that, and to begin with; across the plate a share of that
REACH, EARLIER, AT_FIRST, ACROSS = 1.0, 8.0, 0.4, 0.25
FLOOR = 1.5  # grey levels: least sd of a pixel
MOST_MISFIT = 3.0  # of the typical one: beyond, it is not the block
DISTINCT = 0.4  # of the median misfit elsewhere: the most, where it is looked for
LEAST_SEEN = 0.7  # of the earlier frames, for these to count
LEAST_SD_PX = 0.05


@dataclass(frozen=True)
class Look:
    """mean, weight (h, w, c): what a block looks like, and one over each pixel's sd."""

    mean: np.ndarray
    weight: np.ndarray

    @property
    def size(self) -> tuple[int, int]:
        """Width and height [px]."""
        return self.mean.shape[1], self.mean.shape[0]


def with_earlier_places(tracked: TrackedSeed, source: FrameSource) -> TrackedSeed:
    """The track from the first picture on in which the block can be seen; unchanged
    where it was found from the start, or where it does not lie there before."""
    found = tracked.track.used()
    first = next(source.iterate(), None)
    if first is None or len(found) < 4 or found.frame[0] - first.index < LATE:
        return tracked
    height = tracked.scene.shape[0]
    known = found.frame, found.x, height - 1 - found.y
    between = int(found.frame[0]), int(found.frame[-1])
    pictures = spread(source.picked(LEARNT_FROM, between), known)
    look, typical = learn_look(pictures, known, tracked.size)
    rows = located(source.iterate(), look, known, REACH * tracked.size, tracked.size)
    earlier = rows[:, 0] < found.frame[0]
    # before, another background may have taken the place of the one that was learnt
    lost = np.where(earlier, rows[:, 5] > DISTINCT, rows[:, 4] > MOST_MISFIT * typical)
    if (~lost[earlier]).mean() < LEAST_SEEN:
        return tracked
    frame, t_s, x, y = rows[:, :4].T
    sd = max(LEAST_SD_PX, *(difference_noise(v[~lost], 3) for v in (x, y)))
    note = (
        f"the block was found from frame {between[0]} on as something that moves, and"
        f" from frame {int(frame[~lost][0])} on by its own look"
    )
    track = make_track(
        t_s,
        x,
        height - 1 - y,
        unit="px",
        frame=frame.astype(int),
        sd=sd,
        outlier=lost,
        notes=(*tracked.track.notes, note),
    )
    return replace(tracked, track=track, areas=np.full(len(track), np.nan))


def spread(pictures: list[Frame], known: tuple[np.ndarray, ...]) -> list[Frame]:
    """Those of the pictures that are evenly spaced along the block's way, so that what
    lies behind it differs. known: as of `learn_look`."""
    x = np.interp([p.index for p in pictures], *known[:2])
    way = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(x)))])
    wanted = np.linspace(0.0, way[-1], len(pictures))
    return [pictures[k] for k in sorted({int(np.argmin(abs(way - w))) for w in wanted})]


def learn_look(
    pictures: list[Frame], known: tuple[np.ndarray, ...], size_px: float
) -> tuple[Look, float]:
    """What the block looks like in pictures in which its place is about known, and the
    median of their misfits. known: frames, columns and rows [px, down]."""
    size = (2 * round(WIDE * size_px / 2) + 1, 2 * round(HIGH * size_px / 2) + 1)
    frames = np.array([p.index for p in pictures])
    x, y = (np.interp(frames, known[0], v) for v in known[1:])
    look, misfit = _laid_over(pictures, x, y, size), np.zeros(0)
    for _ in range(ROUNDS):
        rows = located(pictures, look, (frames, x, y), AT_FIRST * size_px)
        x, y, misfit = rows[:, 2], rows[:, 3], rows[:, 4]
        look = _laid_over(pictures, x, y, size)
    return look, float(np.median(misfit))


def located(
    pictures: Iterable[Frame],
    look: Look,
    known: tuple[np.ndarray, ...],
    reach_px: float,
    earlier_px: float = 0.0,
) -> np.ndarray:
    """A row a picture up to the last of the known frames: frame, time [s], column, row
    [px, down], mean squared difference [variances], the same over the median of other
    columns. The block is sought within reach_px
    of where the known places, the nearest or between two, put it; before the first of
    them within EARLIER × earlier_px along the plate."""
    rows = []
    for picture in pictures:
        if picture.index > known[0][-1]:
            break
        at = [float(np.interp(picture.index, known[0], v)) for v in known[1:]]
        along = EARLIER * earlier_px if picture.index < known[0][0] else reach_px
        reach = max(2, round(along)), max(2, round(ACROSS * reach_px))
        here = _best(picture.pixels, look, at, reach)
        rows.append((picture.index, picture.t_s, *here))
    return np.array(rows)


def _laid_over(
    pictures: list[Frame], x: np.ndarray, y: np.ndarray, size: tuple[int, int]
) -> Look:
    cut = np.array(
        [
            np.atleast_3d(cv2.getRectSubPix(p.pixels, size, (float(a), float(b))))
            for p, a, b in zip(pictures, x, y, strict=True)
        ],
        np.float32,
    )
    mean = np.median(cut, axis=0)
    sd = 1.4826 * np.median(np.abs(cut - mean), axis=0)
    return Look(mean, (1 / np.hypot(sd, FLOOR)).astype(np.float32))


def _best(
    picture: np.ndarray, look: Look, at: list[float], reach: tuple[int, int]
) -> tuple[float, float, float, float]:
    """Column, row and misfit of the best place about `at`, and that misfit over the
    median of all columns'."""
    size = look.size[0] + 2 * reach[0], look.size[1] + 2 * reach[1]
    middle = round(at[0]), round(at[1])
    window = np.atleast_3d(cv2.getRectSubPix(picture, size, middle)).astype(np.float32)
    off = cv2.matchTemplate(window, look.mean, cv2.TM_SQDIFF, mask=look.weight)
    row, column = np.unravel_index(int(np.argmin(off)), off.shape)
    misfit = float(off[row, column]) / look.weight.size
    dx = _lowest(off[row], column)
    dy = _lowest(off[:, column], row)
    share = float(off[row, column] / np.median(off[row]))
    return middle[0] - reach[0] + dx, middle[1] - reach[1] + dy, misfit, share


def _lowest(values: np.ndarray, at: int) -> float:
    """Place of the lowest value, by a parabola through its neighbours."""
    if not 0 < at < len(values) - 1:
        return float(at)
    a, b, c = values[at - 1 : at + 2]
    return float(at + 0.5 * (a - c) / max(a - 2 * b + c, 1e-12))
