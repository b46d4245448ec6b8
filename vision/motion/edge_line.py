"""Tracks one long straight edge that rotates (that of a tilting plate), sub-pixel."""

from dataclasses import dataclass, replace

import cv2
import numpy as np

from benchtwin.vision.evidence.frames import FrameSource
from benchtwin.vision.motion.scene import grey

SEARCH_PX = 8  # how far an edge may move from one frame to the next
PLACES = 90  # along the edge where its position is measured
CANDIDATES = 5
# in which an edge is seen at least; by how much one that rotates turns
LEAST_FRAMES, LEAST_TURN_DEG = 8, 0.3


@dataclass(frozen=True)
class Line:
    """A line in the picture (x right, y down): points at(s), s = 0 nearest to the
    picture's origin. angle: clockwise from the picture's horizontal [rad]; extent:
    first and last s at which it was seen."""

    angle: float
    offset: float
    extent: tuple[float, float]
    angle_sd: float = 0.0

    @property
    def along(self) -> np.ndarray:
        return np.array([np.cos(self.angle), np.sin(self.angle)])

    @property
    def across(self) -> np.ndarray:
        """Normal, downwards in the picture."""
        return np.array([-np.sin(self.angle), np.cos(self.angle)])

    def at(self, s: float) -> np.ndarray:
        return self.offset * self.across + s * self.along

    def foot(self, point: np.ndarray) -> np.ndarray:
        """The point of the line nearest to `point`."""
        return point - (self.across @ point - self.offset) * self.across


def track_edge(
    source: FrameSource,
) -> tuple[dict[int, Line] | None, tuple[int, int], np.ndarray]:
    """The rotating edge by frame number (None: no edge rotates), the shape of the
    pictures, the last one."""
    sample = source.spread()
    last = sample[-1].pixels
    stretched = []
    for image in (grey(f.pixels) for f in sample):
        low, high = np.percentile(image[::4, ::4], (1, 99))
        stretched.append(
            np.clip((image - low) * (255 / max(high - low, 1)), 0, 255).astype(np.uint8)
        )
    starts = _candidates(stretched)
    signs = [_sign(stretched[0].astype(np.float32), line) for line in starts]
    found: list[dict[int, Line]] = [{} for _ in starts]
    for frame in source.iterate():
        image = grey(frame.pixels)
        for k, line in enumerate(starts):
            if (better := _refine(image, line, signs[k])) is not None:
                found[k][frame.index] = starts[k] = better
    turning = []
    for lines in (lines for lines in found if len(lines) >= LEAST_FRAMES):
        angles = np.degrees([line.angle for line in lines.values()])
        length = np.median([np.ptp(line.extent) for line in lines.values()])
        if np.ptp(np.percentile(angles, (2, 98))) > LEAST_TURN_DEG:
            turning.append((len(lines) * length, lines))
    best = max(turning, key=lambda one: one[0], default=(0.0, None))[1]
    return best, last.shape[:2], last


def _candidates(images: list[np.ndarray]) -> list[Line]:
    """Long edges of the first picture that are not at the same place in the others
    (Hough transform)."""
    smooth = [cv2.GaussianBlur(i, (0, 0), 1.2) for i in images]
    edges = [cv2.Canny(i, 25, 70) for i in smooth]
    near = sum(
        (cv2.dilate(e, np.ones((3, 3), np.uint8)) > 0).astype(int) for e in edges[1:]
    )
    moving = edges[0].copy()
    moving[near > 0.6 * (len(edges) - 1)] = 0
    votes = cv2.HoughLines(moving, 1, np.pi / 720, max(40, moving.shape[1] // 8))
    points = np.argwhere(moving)[:, ::-1].astype(float)  # x, y
    lines: list[Line] = []
    for rho, theta in [] if votes is None else votes[:60, 0]:
        angle = theta - np.pi / 2
        line = Line(float(angle), float(rho), (0.0, 0.0))
        alike = (
            abs(line.angle - o.angle) < 0.03 and abs(line.offset - o.offset) < 8
            for o in lines
        )
        if abs(angle) > np.radians(80) or any(alike):
            continue
        on = np.abs(points @ line.across - line.offset) < 2.5
        if on.sum() < 30:
            continue
        s = points[on] @ line.along
        ends = (float(np.percentile(s, 1)), float(np.percentile(s, 99)))
        lines.append(Line(line.angle, line.offset, ends))
    return lines[:CANDIDATES]


def _profiles(
    image: np.ndarray, line: Line
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Brightness across the line at PLACES along it: (places, offsets), the places s,
    the offsets."""
    s = np.linspace(line.extent[0], line.extent[1], PLACES)
    across = np.arange(-SEARCH_PX, SEARCH_PX + 0.25, 0.5)
    at = line.offset * line.across + s[:, None, None] * line.along
    at = (at + across[:, None] * line.across).astype(np.float32)
    kept = cv2.BORDER_REPLICATE
    values = cv2.remap(image, at, None, cv2.INTER_LINEAR, borderMode=kept)
    return cv2.GaussianBlur(values, (5, 1), 1.0), s, across


def _sign(image: np.ndarray, line: Line) -> float:
    """Whether the picture gets brighter (+1) or darker (−1) downwards across the
    edge."""
    values, _, _ = _profiles(image, line)
    step = np.diff(values, axis=1)
    strongest = step[np.arange(len(step)), np.abs(step).argmax(axis=1)]
    return 1.0 if np.median(strongest) > 0 else -1.0


def _refine(image: np.ndarray, line: Line, sign: float) -> Line | None:
    """The edge near `line`, to a few hundredths of a pixel; None when fewer than a
    third of the places show it."""
    values, s, across = _profiles(image, line)
    step = np.maximum(np.diff(values, axis=1) * sign, 0)
    middle = (across[1:] + across[:-1]) / 2
    peak = step.argmax(axis=1)
    height = step[np.arange(PLACES), peak]
    window = np.abs(middle[None, :] - middle[peak][:, None]) <= 1.6
    weight = step * window
    place = (weight * middle).sum(axis=1) / np.maximum(weight.sum(axis=1), 1e-9)
    good = (height > 0.35 * np.percentile(height, 75)) & (height > 0.8)
    lever = s - s.mean()
    # Block, graph paper and clamps disturb some places: start from the line that most
    # places agree on.
    guess = _agreed(lever[good], place[good])
    if guess is None:
        return None
    level, slope = guess
    for limit in (1.5, 0.8, 0.5):
        near = good & (np.abs(place - level - slope * lever) < limit)
        if near.sum() < PLACES / 3:
            return None
        slope, level = np.polyfit(lever[near], place[near], 1)
        noise = float(np.std(place[near] - level - slope * lever[near]))
    centre = line.offset * line.across + s.mean() * line.along + level * line.across
    turned = replace(line, angle=line.angle + float(np.arctan(slope)))
    half, at = (line.extent[1] - line.extent[0]) / 2, float(centre @ turned.along)
    sd = max(noise, 0.02) / float(np.sqrt(((lever[near]) ** 2).sum()))
    return Line(turned.angle, float(centre @ turned.across), (at - half, at + half), sd)


def _agreed(lever: np.ndarray, place: np.ndarray) -> tuple[float, float] | None:
    """Level and slope of the line through two of the places that most others lie near
    to (all pairs of 24 places)."""
    if len(place) < PLACES / 3:
        return None
    pick = np.linspace(0, len(place) - 1, 24).astype(int)
    one, other = (pick[k] for k in np.triu_indices(len(pick), 1))
    apart = other > one + len(place) // 4
    one, other = one[apart], other[apart]
    slope = (place[other] - place[one]) / (lever[other] - lever[one])
    level = place[one] - slope * lever[one]
    near = (np.abs(place - level[:, None] - slope[:, None] * lever) < 0.6).sum(axis=1)
    best = int(near.argmax())
    return float(level[best]), float(slope[best])
