"""Frames → Track: the one thing among all that move which behaves like a thrown, sliding or rolling seed.

Every frame's moving things are found on their own (detect.py), so a lost frame costs nothing. They are then linked into
pieces, and the pieces are judged by what a seed does: in flight its height is a parabola that opens downwards. A hand, a
clamp, a mirror image (which falls upwards) and a shadow (fainter) fail that.
"""

import itertools
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from vision.evidence.frames import FrameSource
from vision.measurement import MeasurementError
from vision.motion.detect import Silhouette, find_silhouettes
from vision.motion.scene import Scene, learn_scene
from vision.motion.settled import settle
from vision.motion.track import Track, make_track

PATIENCE = 6  # frames for which a thing may be lost before its piece ends
AREA_ODD = 0.12  # silhouette this much off its neighbours' is merged with something, or partly hidden
UNLIKE, UNLIKE_LONG = 0.67, 0.5  # a body keeps its colour, to this share of its contrast: from frame to frame, over the film
ANGLE_SD_DEG = 12.0  # an orientation known worse than this is none (a round silhouette)
ROUND_OUTLINE = 0.01  # (a² − b²)/(a² + b²) of its axes: pixels and shading stretch a ball's by 0.003


@dataclass
class _Piece:
    """Silhouettes of successive frames that are one thing."""

    frames: list[int]
    times: list[float]
    shapes: list[Silhouette]

    def distance(self, shape: Silhouette, frame: int) -> tuple[float, float]:
        """How far `shape` is from where this thing should be in `frame`, and how fast it goes [px per frame].

        What goes down may also have bounced: then any place between a dead stop and a full rebound will do. (Without that
        a falling seed is taken on by its mirror image in the plate, which goes on downwards.)
        """
        last = self.shapes[-1]
        if len(self.shapes) < 2:
            return float(np.hypot(shape.x - last.x, shape.y - last.y)), 0.0
        back = -min(4, len(self.shapes))
        span, ahead = self.frames[-1] - self.frames[back], frame - self.frames[-1]
        vx, vy = (last.x - self.shapes[back].x) / span, (last.y - self.shapes[back].y) / span
        across, along = shape.x - last.x - vx * ahead, shape.y - last.y
        away = float(np.hypot(across, along - vy * ahead))
        if vy > 0:
            bounced = np.clip(along, -vy * ahead, vy * ahead)
            away = min(away, float(np.hypot(across, along - bounced)))
        return away, float(np.hypot(vx, vy))

    @property
    def area(self) -> float:
        return float(np.median([s.area for s in self.shapes]))

    @property
    def contrast(self) -> float:
        return float(np.median([s.contrast for s in self.shapes]))

    @property
    def usual(self) -> Silhouette:
        """The one of median contrast."""
        return sorted(self.shapes, key=lambda s: s.contrast)[len(self.shapes) // 2]

    @property
    def reach(self) -> float:
        return float(np.hypot(np.ptp([s.x for s in self.shapes]), np.ptp([s.y for s in self.shapes])))


@dataclass(frozen=True)
class Followed:
    """The track [px, y up from the bottom row], the scene behind it, and the first frame for the overlay."""

    track: Track
    scene: Scene
    size: float  # diameter of the circle with the seed's silhouette area, px
    areas: np.ndarray  # of the silhouette in each row of the track, px²


def follow(
    source: FrameSource, *, falling: bool, progress: Callable[[float], None] | None = None, scene: Scene | None = None,
    at: tuple[float, float, float] | None = None, area_px: tuple[float, float] = (0.0, np.inf),
) -> Followed:  # fmt: skip
    """Track the seed through all frames. `falling`: it flies (drop); otherwise it rolls or slides.

    scene: what is behind the seed, where the caller knows better than the median of the frames. at: frame, x, y [px, y down]
    where somebody says that the seed is. area_px: least and greatest silhouette that the stated seed can have.
    progress(fraction done) is called now and then. Raises MeasurementError when nothing in the picture moves like a seed.
    """
    scene = learn_scene(source) if scene is None else scene
    pieces: list[_Piece] = []
    active: list[_Piece] = []
    done, times, frames = 0, [], []
    for frame in source.iterate():
        if frame.pixels.shape[:2] != scene.shape:
            source.note(f"frame {frame.index} skipped: its size is not that of the others")
            continue
        shapes = find_silhouettes(frame.pixels, scene)
        active = [p for p in active if frame.index - p.frames[-1] <= PATIENCE]
        _extend(active, pieces, shapes, frame.index, frame.t_s)
        frames.append(frame.index)
        times.append(frame.t_s)
        done += 1
        if progress and done % 20 == 0:
            progress(min(done / max(source.count, 1), 1.0))
    if progress:
        progress(1.0)
    pieces = [p for p in pieces if len(p.frames) >= 3]
    chosen = _choose(pieces, falling, scene) if at is None else _nearest(pieces, *at)
    if chosen is None and at is not None:
        raise MeasurementError(f"{source.path}: nothing moves near [track] follow_px = {[float(f'{v:.6g}') for v in at]}")
    if chosen is None:
        raise MeasurementError(f"{source.path}: nothing moves like a seed in {done} frames")
    areas = np.array([s.area for s in chosen.shapes])
    return Followed(_as_track(chosen, scene, done, area_px), scene, 2 * float(np.sqrt(np.median(areas) / np.pi)), areas)


def _extend(active: list[_Piece], pieces: list[_Piece], shapes: list[Silhouette], frame: int, time: float) -> None:
    """Give each piece the silhouette that fits it best; what nobody wants starts a piece."""
    offers = []
    for p, piece in enumerate(active):
        last = piece.shapes[-1]
        for s, shape in enumerate(shapes):
            size = np.sqrt(max(shape.area, last.area))
            away, speed = piece.distance(shape, frame)
            gate = 1.2 * size + 2.2 * speed + 3.0 if len(piece.shapes) > 1 else 2.5 * size + 40.0
            area, unlike = abs(np.log(shape.area / last.area)), shape.unlike(last)
            if away < gate and area < 1.1 and unlike < UNLIKE:
                offers.append((away / size + 1.5 * area + 2.0 * unlike, p, s))
    taken_p, taken_s = set(), set()
    for _, p, s in sorted(offers):
        if p in taken_p or s in taken_s:
            continue
        taken_p.add(p)
        taken_s.add(s)
        piece = active[p]
        piece.frames.append(frame)
        piece.times.append(time)
        piece.shapes.append(shapes[s])
    for s, shape in enumerate(shapes):
        if s not in taken_s:
            piece = _Piece([frame], [time], [shape])
            pieces.append(piece)
            active.append(piece)


def _nearest(pieces: list[_Piece], frame: float, x: float, y: float) -> _Piece | None:
    """The piece that passes the place at about that frame, joined with what is the same thing before and after it."""
    found: list[tuple[float, int, _Piece]] = []
    for piece in pieces:
        k = int(np.argmin(np.abs(np.array(piece.frames) - frame)))
        away, size = np.hypot(piece.shapes[k].x - x, piece.shapes[k].y - y), np.sqrt(piece.area)
        if abs(piece.frames[k] - frame) <= PATIENCE and away < 2 * size + 4:
            found.append((float(away), len(found), piece))
    return _joined(min(found)[2], pieces) if found else None


def _choose(pieces: list[_Piece], falling: bool, scene: Scene) -> _Piece | None:
    """The seed's piece, joined with the others that are the same thing before and after it."""
    scored = [(_score(p, falling, scene), i) for i, p in enumerate(pieces)]
    scored = [entry for entry in scored if entry[0] > 0]
    if not scored:
        return None
    return _joined(pieces[max(scored)[1]], pieces)


def _joined(best: _Piece, pieces: list[_Piece]) -> _Piece:
    """The piece with those that are the same thing before and after it."""
    area = best.area
    joined, size = best, np.sqrt(best.area)
    alike = [
        p for p in pieces
        if p is not best and 0.6 < p.area / area < 1.7 and p.usual.unlike(best.usual) < UNLIKE_LONG
    ]  # fmt: skip
    for piece in sorted(alike, key=lambda p: -len(p.frames)):
        joined = _join(joined, piece, size)
    return joined


def _join(one: _Piece, other: _Piece, size: float) -> _Piece:
    """Both in one when they do not overlap in time and the way between them is one the seed could have gone."""
    first, second = (one, other) if one.frames[0] <= other.frames[0] else (other, one)
    if first.frames[-1] >= second.frames[0]:
        return one
    gap = second.frames[0] - first.frames[-1]
    speed = max(_speed(first, -12), _speed(second, 12))
    away = np.hypot(second.shapes[0].x - first.shapes[-1].x, second.shapes[0].y - first.shapes[-1].y)
    if away > size + 1.6 * speed * gap:
        return one
    return _Piece(first.frames + second.frames, first.times + second.times, first.shapes + second.shapes)


def _speed(piece: _Piece, count: int) -> float:
    """px per frame over the last (count < 0) or first frames."""
    rows = slice(count, None) if count < 0 else slice(0, count)
    frames, shapes = piece.frames[rows], piece.shapes[rows]
    if len(frames) < 2:
        return 0.0
    steps = np.hypot(np.diff([s.x for s in shapes]), np.diff([s.y for s in shapes])) / np.diff(frames)
    return float(np.max(steps))


def _score(piece: _Piece, falling: bool, scene: Scene) -> float:
    """How much of a seed's motion there is in a piece: way gone, times how evenly; for a drop only what falls downwards."""
    frames = np.array(piece.frames, dtype=float)
    x, y = np.array([s.x for s in piece.shapes]), -np.array([s.y for s in piece.shapes])
    reach = piece.reach
    size = np.sqrt(piece.area)
    if reach < max(0.7 * size, 4.0) or piece.area > 0.05 * np.prod(scene.shape):
        return 0.0
    strength = piece.contrast
    if not falling:
        return reach * np.sqrt(strength) * _evenness(frames, x, size)
    if np.ptp(y) < 0.5 * reach:
        return 0.0
    way = _falling_way(frames, y)
    return way * np.sqrt(strength)


def _falling_way(frames: np.ndarray, y: np.ndarray) -> float:
    """Height gone through while the path bends downwards as a parabola does, less where it bends upwards."""
    if len(y) < 4:
        return 0.3 * float(np.ptp(y))
    turns = np.flatnonzero((np.diff(y)[:-1] < 0) & (np.diff(y)[1:] > 0)) + 1 if len(y) > 4 else np.array([], int)
    big = [0, *[int(t) for t in turns if _stands_out(y, int(t))], len(y) - 1]
    way = 0.0
    for a, b in itertools.pairwise(big):
        inner = slice(a + 1, b) if b - a > 5 else slice(a, b + 1)
        if inner.stop - inner.start < 3:
            continue
        f, h = frames[inner] - frames[inner].mean(), y[inner]
        if a == 0:  # without the rest before the release
            begin = int(np.flatnonzero(h >= h.max() - 0.02 * np.ptp(h))[-1])
            f, h = (f[begin:], h[begin:]) if len(h) - begin >= 4 else (f, h)
        bend, slope, level = np.polyfit(f, h, 2)
        left = float(np.std(h - np.polyval([bend, slope, level], f)))
        extent = float(np.ptp(h))
        if extent > 2 and left < 0.1 * extent:
            way += extent * (1.0 if bend < 0 else -1.0)
    return max(way, 0.0)


def _stands_out(y: np.ndarray, at: int) -> bool:
    reach = 0.03 * np.ptp(y) + 1.0
    return bool(y[: at + 1].max() - y[at] > reach and y[at:].max() - y[at] > reach)


def _evenness(frames: np.ndarray, x: np.ndarray, size: float) -> float:
    """1 for a smooth path, towards 0 for one that jumps about."""
    if len(x) < 6:
        return 0.3
    jerk = np.abs(np.diff(x, 2))
    return float(1 / (1 + 10 * np.median(jerk) / max(np.ptp(x) / len(x), 1e-9) * (np.median(jerk) > 0.3) + np.mean(jerk > size)))


def _as_track(piece: _Piece, scene: Scene, total: int, area_px: tuple[float, float]) -> Track:
    """Arrays from a piece: y up from the bottom row, orientation unwrapped, odd silhouettes marked."""
    shapes = piece.shapes
    x, y, sd = np.array([(s.x, s.y, s.sd) for s in shapes]).T
    area, cut = np.array([s.area for s in shapes]), np.array([s.cut for s in shapes])
    frame, t_s = np.array(piece.frames), np.array(piece.times)
    odd = _odd_area(area)
    if (settled := settle(shapes, area_px)) is not None:
        laid = settled[0]
        x, y, sd = np.array([(s.x, s.y, s.sd) if one is None else (one.x, one.y, one.sd) for s, one in zip(shapes, laid)]).T
        odd = np.array([one is None for one in laid])
    y = scene.shape[0] - 1 - y
    angle, angle_sd = _orientation(shapes, frame, odd | cut)
    seen = bool(np.isfinite(angle).any())
    notes = []
    lost = total - len(shapes)
    if lost:
        notes.append(f"the seed was found in {len(shapes)} of {total} frames")
    if cut.any():
        notes.append(f"{int(cut.sum())} frames with the seed partly out of the picture (marked as outliers)")
    if (odd & ~cut).any():
        notes.append(
            f"{int((odd & ~cut).sum())} frames with the seed partly hidden or merged with something (marked as outliers)"
        )
    return make_track(
        t_s, x, y, unit="px", frame=frame, sd=sd, outlier=odd | cut,
        angle_deg=angle if seen else None, angle_sd_deg=angle_sd if seen else None, notes=tuple(notes),
    )  # fmt: skip


def _odd_area(area: np.ndarray) -> np.ndarray:
    """Silhouettes whose area jumps off that of the frames around (a tumbling seed's changes slowly)."""
    if len(area) < 9:
        return np.zeros(len(area), dtype=bool)
    window = 15 if len(area) > 60 else 5
    half = window // 2
    padded = np.pad(area, half, mode="reflect")
    usual = np.median(np.lib.stride_tricks.sliding_window_view(padded, window), axis=1)
    off = np.abs(area / usual - 1)
    return off > max(AREA_ODD, 6 * 1.4826 * float(np.median(off)))


def _orientation(shapes: list[Silhouette], frame: np.ndarray, odd: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Unwrapped orientation, anticlockwise; known only up to half turns, so each is taken nearest to the spin so far. The outline of
    a ball has none."""
    raw = np.array([0.5 * np.degrees(np.arctan2(-2 * s.xy, s.xx - s.yy)) for s in shapes])
    sd = np.array([s.angle_sd_deg for s in shapes])
    stretch = np.array([np.hypot(s.xx - s.yy, 2 * s.xy) / (s.xx + s.yy) for s in shapes])
    round_outline = np.median(stretch[~odd] if (~odd).any() else stretch) < ROUND_OUTLINE
    seen = (sd < ANGLE_SD_DEG) & ~odd & ~round_outline
    angle = np.full(len(shapes), np.nan)
    spin = 0.0
    history: list[float] = []
    last = None
    for i in np.flatnonzero(seen):
        if last is None:
            angle[i] = raw[i]
        else:
            ahead = frame[i] - frame[last]
            expected = angle[last] + spin * ahead
            angle[i] = raw[i] + 180 * np.round((expected - raw[i]) / 180)
            history = [*history[-4:], (angle[i] - angle[last]) / ahead]
            spin = float(np.median(history))
        last = i
    return angle, np.where(seen, sd, np.nan)
