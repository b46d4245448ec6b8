"""Tracklets: silhouettes of successive frames that are one thing, linked from frame to
frame and joined over gaps."""

from dataclasses import dataclass

import numpy as np

from benchtwin.vision.motion.detect import Silhouette

PATIENCE = 6  # frames for which a thing may be lost before its tracklet ends
# colour distance from frame to frame, and over the film
MOST_COLOUR_STEP = 0.67
MOST_COLOUR_CHANGE = 0.5


@dataclass
class Tracklet:
    """Silhouettes of one thing in successive frames."""

    frames: list[int]
    times: list[float]
    shapes: list[Silhouette]

    def distance(self, shape: Silhouette, frame: int) -> tuple[float, float]:
        """Distance [px] of `shape` from where this thing is expected in `frame`, and
        its speed [px per frame].

        A falling thing may have bounced: then any place between a dead stop and a full
        rebound is expected. (Otherwise the track of a falling seed would continue with
        its mirror image in the plate.)"""
        last = self.shapes[-1]
        if len(self.shapes) < 2:
            return float(np.hypot(shape.x - last.x, shape.y - last.y)), 0.0
        back = -min(4, len(self.shapes))
        span, ahead = self.frames[-1] - self.frames[back], frame - self.frames[-1]
        vx = (last.x - self.shapes[back].x) / span
        vy = (last.y - self.shapes[back].y) / span
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
    def typical(self) -> Silhouette:
        """The one of median contrast."""
        return sorted(self.shapes, key=lambda s: s.contrast)[len(self.shapes) // 2]

    @property
    def extent(self) -> float:
        """Diagonal of the box around its places [px]."""
        across = np.ptp([s.x for s in self.shapes])
        down = np.ptp([s.y for s in self.shapes])
        return float(np.hypot(across, down))


def extend(
    active: list[Tracklet],
    tracklets: list[Tracklet],
    shapes: list[Silhouette],
    frame: int,
    time: float,
) -> None:
    """Append each silhouette to the active tracklet that it fits best; the others start
    new tracklets."""
    offers = []
    for p, tracklet in enumerate(active):
        last = tracklet.shapes[-1]
        for s, shape in enumerate(shapes):
            size = np.sqrt(max(shape.area, last.area))
            away, speed = tracklet.distance(shape, frame)
            moves = len(tracklet.shapes) > 1
            gate = 1.2 * size + 2.2 * speed + 3.0 if moves else 2.5 * size + 40.0
            area = abs(np.log(shape.area / last.area))
            colour_distance = shape.colour_distance(last)
            if away < gate and area < 1.1 and colour_distance < MOST_COLOUR_STEP:
                offers.append((away / size + 1.5 * area + 2.0 * colour_distance, p, s))
    extended: dict[int, int] = {}  # shape → tracklet
    for _, p, s in sorted(offers):
        if s not in extended and p not in extended.values():
            extended[s] = p
            active[p].frames.append(frame)
            active[p].times.append(time)
            active[p].shapes.append(shapes[s])
    new = [
        Tracklet([frame], [time], [shape])
        for s, shape in enumerate(shapes)
        if s not in extended
    ]
    tracklets += new
    active += new


def join_alike(best: Tracklet, tracklets: list[Tracklet]) -> Tracklet:
    """`best` joined with the tracklets of the same thing before and after it."""
    joined, size = best, np.sqrt(best.area)
    same = [p for p in tracklets if p is not best and alike(p, best)]
    for tracklet in sorted(same, key=lambda p: -len(p.frames)):
        joined = appended(joined, tracklet, size)
    return joined


def alike(one: Tracklet, other: Tracklet) -> bool:
    """Whether two tracklets may be of the same thing, by area and colour."""
    return (
        0.6 < one.area / other.area < 1.7
        and one.typical.colour_distance(other.typical) < MOST_COLOUR_CHANGE
    )


def appended(one: Tracklet, other: Tracklet, size: float = np.inf) -> Tracklet:
    """Both in the order of time; `one` where they overlap, or what is of that size
    cannot cross the gap at their speeds."""
    first, second = sorted((one, other), key=lambda p: p.frames[0])
    gap = second.frames[0] - first.frames[-1]
    if gap <= 0:
        return one
    end, begin = first.shapes[-1], second.shapes[0]
    reach = size + 1.6 * gap * max(_speed(first, -12), _speed(second, 12))
    if np.hypot(begin.x - end.x, begin.y - end.y) > reach:
        return one
    frames = first.frames + second.frames
    return Tracklet(frames, first.times + second.times, first.shapes + second.shapes)


def _speed(tracklet: Tracklet, count: int) -> float:
    """Greatest speed [px per frame] over the last (count < 0) or first frames."""
    rows = slice(count, None) if count < 0 else slice(0, count)
    frames, shapes = tracklet.frames[rows], tracklet.shapes[rows]
    if len(frames) < 2:
        return 0.0
    steps = np.hypot(
        np.diff([s.x for s in shapes]), np.diff([s.y for s in shapes])
    ) / np.diff(frames)
    return float(np.max(steps))
