"""Places of a seed or block by a template of it, where the background tells it badly:
before it moves, before a wall as pale as it is, or before a busy one.

The pictures are laid over each other by the places that are known. What belongs to the
seed looks alike in all of them, what lies behind it changes. With each pixel weighed by
one over its variance, the seed is where the sum of squared differences is least
(template matching); laid over each other anew by these places it looks sharper. A seed
that tumbles does not look alike: then its silhouettes are kept."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace

import cv2
import numpy as np
import pandas as pd

from benchtwin.bench.language import tr
from benchtwin.bench.robust import difference_noise
from benchtwin.vision.evidence.frames import Frame, FrameSource
from benchtwin.vision.motion.track import Track, make_track
from benchtwin.vision.motion.track_seed import TrackedSeed, moving, scatter_px

LATE = 8  # frames before the first place, from which on earlier ones are sought
# share of rows that are marked, and scatter [px], from which on a track is doubted;
# scatter of another, over its own, from which on that is better, and beyond which worse
HIDDEN, ROUGH, SMOOTHER, NO_ROUGHER = 0.1, 0.3, 0.7, 1.1
LEARNT_FROM = 40  # pictures, about
STEP_PX = 0.3  # of way, for which a picture counts in which the seed rests
ROUNDS = 4  # of laying pictures over each other
WIDE, HIGH = 2.2, 1.7  # of the seed's size: the part of a picture that is compared
# of the seed's size: how far from where it is expected it is sought: where it was
# found, before and after that, and to begin with; across a plate a share of that
REACH, OUTSIDE, AT_FIRST, ACROSS = 1.0, 8.0, 0.4, 0.25
FLOOR = 1.5  # grey levels: least sd of a pixel
MOST_MISFIT = 3.0  # of the typical one: beyond, it is not the seed
DISTINCT = 0.4  # of the median misfit elsewhere: the most, where it is looked for
LEAST_ROWS = 6
LEAST_SD_PX = 0.05


# of the known places: frames, columns and rows [px, down]
Known = tuple[np.ndarray, np.ndarray, np.ndarray]


@dataclass(frozen=True)
class Template:
    """mean, weight (h, w, c): what a seed looks like, and one over each pixel's sd."""

    mean: np.ndarray
    weight: np.ndarray

    @property
    def size(self) -> tuple[int, int]:
        """Width and height [px]."""
        return self.mean.shape[1], self.mean.shape[0]


def by_template(
    tracked: TrackedSeed,
    source: FrameSource,
    *,
    along: bool = False,
    outside: bool = True,
) -> TrackedSeed:
    """The track by a template of the seed, where what moves was seen late, often partly
    or roughly, and the template shows it earlier or more smoothly; else unchanged.
    along:
    it moves along the rows, in pictures turned with its plate. outside: whether it is
    sought before and after the frames in which it was found."""
    first, found = next(source.iterate(), None), tracked.track.used()
    if first is None or len(found) < LEAST_ROWS:
        return tracked
    rough, hidden = _scatter(tracked.track), _hidden(tracked.track)
    late = outside and found.frame[0] - first.index >= LATE
    if not (late or hidden > HIDDEN or rough > ROUGH):
        return tracked
    track = _followed(tracked, found, source, along, outside)
    if _hidden(track) > max(hidden, HIDDEN) or _scatter(track) > NO_ROUGHER * rough:
        return tracked
    gained = found.frame[0] - track.used().frame[0] >= LATE
    clearer = hidden > HIDDEN and _hidden(track) < hidden
    if gained or clearer or _scatter(track) < SMOOTHER * rough:
        return _taken(tracked, track, int(found.frame[0]))
    return tracked


def _followed(
    tracked: TrackedSeed, found: Track, source: FrameSource, along: bool, outside: bool
) -> Track:
    """The track by a template of the seed; found: the places that are known."""
    height, size_px = tracked.scene.shape[0], tracked.size
    known = found.frame, found.x, height - 1 - found.y
    between = int(found.frame[0]), int(found.frame[-1])
    shape = tracked.scene.shape
    pictures = spread(list(_alike(source.picked(LEARNT_FROM, between), shape)), known)
    template, typical = learn_template(pictures, known, size_px, along)
    reach = np.array([REACH, REACH * (ACROSS if along else 1.0)]) * size_px
    far = np.array([OUTSIDE * size_px, reach[1] if along else OUTSIDE * size_px])
    rows = located(_alike(source.iterate(), shape), template, known, reach, far)
    inside = (rows[:, 0] >= between[0]) & (rows[:, 0] <= between[1])
    # elsewhere another background may have taken the place of the one that was learnt
    lost = np.where(inside, rows[:, 4] > MOST_MISFIT * typical, rows[:, 5] > DISTINCT)
    lost |= _leapt(rows, inside, lost, size_px)
    kept = inside | (~lost if outside else False)
    rows, lost = rows[kept], lost[kept]
    frame, t_s, x, y = rows[:, :4].T
    return make_track(
        t_s,
        x,
        height - 1 - y,
        unit="px",
        frame=frame.astype(int),
        sd=max(LEAST_SD_PX, *(difference_noise(v[~lost], 3) for v in (x, y))),
        outlier=lost,
        notes=tracked.track.notes,
    )


def _alike(pictures: Iterable[Frame], shape: tuple[int, int]) -> Iterator[Frame]:
    """Those of the scene's size."""
    return (p for p in pictures if p.pixels.shape[:2] == shape)


def _scatter(track: Track) -> float:
    return scatter_px(track.frame, track.x, track.y, track.outlier)


def _hidden(track: Track) -> float:
    """Share of the rows in which the seed moves that are marked."""
    marked = track.outlier[moving(track.x, track.y)]
    return float(marked.sum()) / max(1, len(marked))


def _leapt(
    rows: np.ndarray, inside: np.ndarray, lost: np.ndarray, size_px: float
) -> np.ndarray:
    """Rows outside that do not join on to those inside: farther than the seed's size a
    frame from the nearest one before or after that does."""
    leapt = np.zeros(len(rows), bool)
    first, last = np.flatnonzero(inside)[[0, -1]]
    for way in (range(first - 1, -1, -1), range(last + 1, len(rows))):
        at = first if way.step < 0 else last
        for k in way:
            step = np.hypot(*(rows[k, 2:4] - rows[at, 2:4]))
            leapt[k] = step > size_px * abs(rows[k, 0] - rows[at, 0])
            at = at if leapt[k] or lost[k] else k
    return leapt


def _taken(tracked: TrackedSeed, track: Track, seen_from: int) -> TrackedSeed:
    """The track by a template of the seed, with the silhouettes and orientations that
    were seen."""
    old = tracked.track

    def of_old(values: np.ndarray) -> np.ndarray:
        return pd.Series(values, old.frame).reindex(track.frame).to_numpy()

    first = int(track.used().frame[0])
    note = tr(
        "what moves stood out little: the seed's places are those of a template of it"
    )
    if first < seen_from:
        note = tr(
            "the seed was found from frame {} on as something that moves, and from"
            " frame {} on by a template of it",
            seen_from,
            first,
        )
    angle, angle_sd = old.angle_deg, old.angle_sd_deg
    track = replace(
        track,
        angle_deg=None if angle is None else of_old(angle),
        angle_sd_deg=None if angle_sd is None else of_old(angle_sd),
        notes=(*track.notes, note),
    )
    return replace(tracked, track=track, areas=of_old(tracked.areas))


def spread(pictures: list[Frame], known: Known) -> list[Frame]:
    """Those of the pictures that are evenly spaced along the seed's way, and a little
    in time, so that what lies behind it differs. known: as of `learn_template`."""
    x = np.interp([p.index for p in pictures], known[0], known[1])
    way = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(x)) + STEP_PX)])
    wanted = np.linspace(0.0, way[-1], len(pictures))
    return [pictures[k] for k in sorted({int(np.argmin(abs(way - w))) for w in wanted})]


def learn_template(
    pictures: list[Frame],
    known: Known,
    size_px: float,
    along: bool = False,
) -> tuple[Template, float]:
    """What the seed looks like in pictures in which its place is about known, and the
    median of their misfits. known: frames, columns and rows [px, down]."""
    size = (2 * round(WIDE * size_px / 2) + 1, 2 * round(HIGH * size_px / 2) + 1)
    frames = np.array([p.index for p in pictures])
    x, y = (np.interp(frames, known[0], v) for v in known[1:])
    reach = np.array([1.0, ACROSS if along else 1.0]) * AT_FIRST * size_px
    template, misfit = _laid_over(pictures, x, y, size), np.zeros(0)
    for _ in range(ROUNDS):
        rows = located(pictures, template, (frames, x, y), reach)
        x, y, misfit = rows[:, 2], rows[:, 3], rows[:, 4]
        template = _laid_over(pictures, x, y, size)
    return template, float(np.median(misfit))


def located(
    pictures: Iterable[Frame],
    template: Template,
    known: Known,
    reach_px: np.ndarray,
    outside_px: np.ndarray | None = None,
) -> np.ndarray:
    """A row a picture: frame, time [s], column, row [px, down], mean squared difference
    [variances], the same over the median of other columns. The seed is sought within
    reach_px (along columns, rows) of where the known places put it, between two of them
    or at the nearest; before the first and after the last within outside_px."""
    rows = []
    for picture in pictures:
        at = [float(np.interp(picture.index, known[0], v)) for v in known[1:]]
        inside = known[0][0] <= picture.index <= known[0][-1]
        far = reach_px if inside or outside_px is None else outside_px
        reach = max(2, round(far[0])), max(2, round(far[1]))
        here = _best(picture.pixels, template, at, reach)
        rows.append((picture.index, picture.t_s, *here))
    return np.array(rows)


def _laid_over(
    pictures: list[Frame], x: np.ndarray, y: np.ndarray, size: tuple[int, int]
) -> Template:
    places = zip(pictures, np.column_stack([x, y]).tolist(), strict=True)
    cut = np.array([_part(p.pixels, size, tuple(at)) for p, at in places])
    mean = np.median(cut, axis=0)
    sd = 1.4826 * np.median(np.abs(cut - mean), axis=0)
    return Template(mean, (1 / np.hypot(sd, FLOOR)).astype(np.float32))


def _best(
    picture: np.ndarray, template: Template, at: list[float], reach: tuple[int, int]
) -> tuple[float, float, float, float]:
    """Column, row and misfit of the best place about `at`, and that misfit over the
    median of all columns'."""
    size = template.size[0] + 2 * reach[0], template.size[1] + 2 * reach[1]
    middle = round(at[0]), round(at[1])
    window = _part(picture, size, middle)
    off = cv2.matchTemplate(window, template.mean, cv2.TM_SQDIFF, mask=template.weight)
    row, column = divmod(int(np.argmin(off)), off.shape[1])
    misfit = float(off[row, column]) / template.weight.size
    dx = _lowest(off[row], column)
    dy = _lowest(off[:, column], row)
    share = float(off[row, column] / np.median(off[row]))
    return middle[0] - reach[0] + dx, middle[1] - reach[1] + dy, misfit, share


def _part(
    picture: np.ndarray, size: tuple[int, int], middle: tuple[float, float]
) -> np.ndarray:
    """The part of a picture about a place [px], float32 (h, w, c) from 0 to 255."""
    if (white := np.iinfo(picture.dtype).max) != 255:
        picture = (picture * (255 / white)).astype(np.float32)
    return np.atleast_3d(cv2.getRectSubPix(picture, size, middle)).astype(np.float32)


def _lowest(values: np.ndarray, at: int) -> float:
    """Place of the lowest value, by a parabola through its neighbours."""
    if not 0 < at < len(values) - 1:
        return float(at)
    a, b, c = values[at - 1 : at + 2]
    return float(at + 0.5 * (a - c) / max(a - 2 * b + c, 1e-12))
