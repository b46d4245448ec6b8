"""The block of a slide on its tilting plate, with the plate's angle, in a film whose
frames are rotated with the plate."""

import contextlib
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

import cv2
import numpy as np
from benchtwin.vision.evidence.frames import Frame, FrameSource, limit_to_memory
from benchtwin.vision.measurement import MeasurementError
from benchtwin.vision.motion.behind_plate import background
from benchtwin.vision.motion.edge_line import Line, track_edge
from benchtwin.vision.motion.own_look import LATE, by_own_look
from benchtwin.vision.motion.places import Places, places_of
from benchtwin.vision.motion.scene import (
    MEDIAN_FRAMES,
    even_in_motion,
    grey,
    learn_scene,
)
from benchtwin.vision.motion.track import Track
from benchtwin.vision.motion.track_seed import TrackedSeed, track_seed
from benchtwin.vision.recording import Recording

LEAST_SEEN = 0.5  # of the frames: an edge seen in fewer is not used
ABOVE, BELOW = 110, 14  # px of a picture 640 px wide, of the plate's edge: the strip
AFTER_SLIDE = 16  # least number of pictures after the block has left its first place
BEHIND = (
    "what lies behind the plate was subtracted: before it the block was not seen from"
    " the beginning on"
)
STEADY = 6.0  # grey levels, sd over the film: of rows that are the plate's
RESTS_PX, MOVED_PX = 3.0, 6.0  # of a block: at most, while it rests; at least, later
COLUMNS = 400  # of a strip that are used for a row's brightness
STAYS, GONE = 0.25, 0.8  # share of the block that has left its first place


@dataclass(frozen=True)
class PlateOverlay:
    """For the overlay: the last picture, the block's places in it (columns, rows), and
    plate lines as segments."""

    picture: np.ndarray
    places: tuple[np.ndarray, np.ndarray]
    lines: list


@dataclass(frozen=True)
class Behind:
    """The picture of what lies behind the plate, and how many rows above the plate's
    edge are the plate's own."""

    picture: np.ndarray
    plate: int


def track_slide(
    source: FrameSource,
    recording: Recording,
    progress: Callable[[float], None] | None = None,
) -> tuple[TrackedSeed, PlateOverlay]:
    """Track the block along the tilting plate [px], with the plate's angle, both from
    the pictures. Angles are against the picture's horizontal plus `camera.plumb_deg`.
    In pictures rotated with the plate only the block moves."""
    lines, shape, last = track_edge(source)
    if lines is not None and len(lines) < LEAST_SEEN * source.count:
        source.note(
            f"the plate's edge is seen in {len(lines)} of {source.count} frames only"
            " and is not used"
        )
        lines = None
    if lines is None:
        return _without_plate(source, recording, progress)
    strip = _strip(source, lines, shape)
    tracked = _block(strip, recording, progress)
    shown = [lines[min(lines)], lines[max(lines)]]
    segments = [
        (tuple(line.at(line.extent[0])), tuple(line.at(line.extent[1])))
        for line in shown
    ]
    overlay = PlateOverlay(last, strip.in_picture(tracked.track), segments)
    track = _with_tilt(tracked.track, lines, recording)
    return replace(tracked, track=track), overlay


def _block(
    strip: "PlateFrames",
    recording: Recording,
    progress: Callable[[float], None] | None,
) -> TrackedSeed:
    """The block in pictures that are rotated with the plate; where it is not seen from
    the beginning on, or not at all, without what lies behind, which turns in them."""
    stated, places = recording.track, places_of(recording.track)

    def tracked(frames: PlateFrames) -> TrackedSeed:
        found = track_seed(
            frames,
            falling=False,
            progress=progress,
            scene=learn_scene(frames, still=plate_only),
            at=frames.follow(stated.follow_px),
            places=frames.places(places),
            only_places=bool(stated.only_places),
        )
        return found if places else by_own_look(found, frames, along=True)

    def alone() -> TrackedSeed:
        found = tracked(strip.alone())
        notes = (*found.track.notes, BEHIND)
        return replace(found, track=replace(found.track, notes=notes))

    try:
        found = [tracked(strip)]
    except MeasurementError:
        if places:
            raise
        return alone()
    by_hand = places or stated.follow_px is not None
    if not (by_hand or _like_a_block(found[0].track, strip)[0]):
        with contextlib.suppress(MeasurementError):
            found.append(alone())
    return max(found, key=lambda t: _like_a_block(t.track, strip))


def _like_a_block(track: Track, strip: "PlateFrames") -> tuple[bool, bool, int]:
    """Whether a track is that of a block that rests from the film's beginning on and
    then slides; whether it moves down the plate; and how many rows it has."""
    used = track.used()
    begins = used.frame[0] - next(strip.iterate()).index
    down = (used.x[-1] - used.x[0]) * strip.downhill > MOVED_PX
    rests = begins < LATE and np.ptp(used.x[:LATE]) < RESTS_PX
    return bool(rests and down), bool(down), len(used)


def _strip(
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


def _with_tilt(track: Track, lines: dict[int, Line], recording: Recording) -> Track:
    """The track with the plate's angle in each frame, positive however it leans."""
    camera = recording.camera
    angles = [np.degrees(lines[int(frame)].angle) for frame in track.frame]
    tilt = np.array(angles) - (camera.plumb_deg or 0.0)
    flip = -1.0 if np.median(tilt) < 0 else 1.0
    edge_sd = float(np.median([line.angle_sd for line in lines.values()]))
    notes, level_sd = track.notes, camera.plumb_sd
    if camera.plumb_deg is None and camera.plumb_sd_deg is None:
        missing = f"{recording.toml}: [camera] plumb_deg is missing"
        known = f"the plate's angle is known to ± {level_sd:g}° only"
        notes = (*notes, f"{missing}: {known}")
    sd = float(np.hypot(level_sd, np.degrees(edge_sd)))
    return replace(track, tilt_deg=flip * tilt, tilt_sd_deg=sd, notes=notes)


def _without_plate(
    source: FrameSource,
    recording: Recording,
    progress: Callable[[float], None] | None,
) -> tuple[TrackedSeed, PlateOverlay]:
    """The block where no plate is seen, whose angle is stated."""
    if recording.slide.tilt_rate_deg_s is None:
        text = (
            "no tilting plate edge is seen in the picture, and [slide] start_deg"
            " and tilt_rate_deg_s are missing"
        )
        raise MeasurementError(f"{recording.toml}: {text}")
    stated = recording.track
    tracked = track_seed(
        source,
        falling=False,
        progress=progress,
        at=stated.follow_px,
        places=places_of(stated),
        only_places=bool(stated.only_places),
    )
    return _along_own_line(tracked)


def _along_own_line(tracked: TrackedSeed) -> tuple[TrackedSeed, PlateOverlay]:
    """Without a plate in the picture: the travel along the principal axis of the
    block's places."""
    track, height = tracked.track, tracked.scene.shape[0]
    centre = np.array([np.median(track.x), np.median(track.y)])
    offset = np.column_stack([track.x, track.y]) - centre
    _, _, directions = np.linalg.svd(offset, full_matrices=False)
    travel = offset @ directions[0]
    places = (track.x, height - 1 - track.y)
    return replace(
        tracked, track=replace(track, x=travel, y=offset @ directions[1])
    ), PlateOverlay(tracked.scene.first, places, [])


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
    above, below: rows on either side of the line; behind: what is subtracted above it,
    or None. Changes along the whole plate as it tilts (its upper face, its
    illumination, the background behind it) are no motion: every row is brought to the
    brightness that it has in the first strip."""

    def __init__(
        self,
        source: FrameSource,
        lines: dict[int, Line],
        pivot: np.ndarray,
        reach: tuple[int, int],
        above: int,
        below: int,
        behind: Behind | None = None,
    ):
        super().__init__(
            path=source.path, count=len(lines), fps=source.fps, notes=source.notes
        )
        self._source, self._lines, self._pivot = source, lines, pivot
        self._reach, self._above, self._below = reach, above, below
        self._first_levels: np.ndarray | None = None
        self._behind = behind

    @property
    def height(self) -> int:
        return self._above + self._below

    def alone(self) -> "PlateFrames":
        """The block before an even grey: less what lies behind it, above the rows that
        hardly change, as those of the plate."""
        strips = np.array([grey(frame.pixels) for frame in self.picked(MEDIAN_FRAMES)])
        changes = np.median(strips.std(axis=0), axis=1)[: self._above][::-1]
        plate = max(int(np.argmax(changes > STEADY)), 1)
        behind = background(self._source, self._lines, plate)
        cut = self._reach, self._above, self._below
        lines, pivot = self._lines, self._pivot
        return PlateFrames(self._source, lines, pivot, *cut, Behind(behind, plate))

    def iterate(self) -> Iterator[Frame]:
        for frame in self._source.iterate():
            if frame.index in self._lines:
                yield self._warped(frame)

    def picked(self, n: int, between: tuple[int, int] | None = None) -> list[Frame]:
        near = self._source.picked(n, between)
        return [self._warped(frame) for frame in near if frame.index in self._lines]

    def sample(self, n: int) -> list[np.ndarray]:
        """About n strips spread over the film, and at least AFTER_SLIDE from after the
        slide, which may last an instant only."""
        first = next(self.iterate(), None)
        n = n if first is None else limit_to_memory(n, first.pixels)
        frames = self.picked(n)
        left = _block_departure([frame.pixels for frame in frames])
        gone = 0 if left is None else int(np.argmax(left[1] > GONE))
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
            self.note(f"[track] places_px: no plate is seen in frame {lost[0]}")
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
        ordered = np.sort(strip[:, :: max(1, strip.shape[1] // COLUMNS)], axis=1)
        quarter = ordered.shape[1] // 4
        rows = ordered[:, quarter : ordered.shape[1] - quarter].mean(
            axis=1, dtype=np.float32
        )
        if self._first_levels is None:
            self._first_levels = rows
        white = np.iinfo(frame.pixels.dtype).max
        levels = strip + (self._first_levels - rows)[:, None]
        if self._behind is not None:
            alone = self._turned(frame.pixels - self._behind.picture, frame.index)
            clear = slice(0, self._above - self._behind.plate)
            levels[clear] = white / 2 + alone[clear]
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


def plate_only(strips: list[np.ndarray]) -> list[np.ndarray]:
    """Pictures without the block: its first place from strips after it has left; evenly
    spaced ones where nothing leaves."""
    left = _block_departure(strips)
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


def _block_departure(strips: list[np.ndarray]) -> tuple[np.ndarray, np.ndarray] | None:
    """Columns (bool) in which the block rests at first, and the share of it that has
    left them in each strip. The block differs from the median of its rows; where that
    difference vanishes it has left. None where nothing has left by the last strip."""
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
    share = (first - profile) @ weight / (gone @ weight)
    rows_gone = (gone > 0.1 * gone.max()).astype(np.uint8)[None]
    place = cv2.dilate(rows_gone, np.ones((1, 7), np.uint8))[0] > 0
    return (
        place[np.minimum(np.arange(strips[0].shape[1]) // factor, len(place) - 1)],
        share,
    )
