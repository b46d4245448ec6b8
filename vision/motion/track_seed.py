"""Frames → track of the seed: of all things that move, the one that moves like a
falling, sliding or rolling seed.

Moving things are detected in each frame independently (`detect`), so a lost frame costs
nothing, and linked to tracklets. The tracklets are scored by their motion: in flight
the height is a parabola that opens downwards. A hand, a clamp, a mirror image (which
falls upwards) and a shadow (fainter) score low."""

import itertools
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from scipy.ndimage import median_filter
from scipy.signal import find_peaks

from benchtwin.bench.language import tr
from benchtwin.bench.robust import robust_sd
from benchtwin.vision.evidence.frames import FrameSource
from benchtwin.vision.measurement import MeasurementError, require
from benchtwin.vision.motion.detect import Silhouette, find_silhouettes
from benchtwin.vision.motion.ellipse import fit_ellipses
from benchtwin.vision.motion.scene import Scene, learn_scene
from benchtwin.vision.motion.track import (
    LEAST_PLACES,
    Places,
    Track,
    make_track,
    track_of_places,
    upside_down,
    with_places,
)
from benchtwin.vision.motion.tracklets import (
    PATIENCE,
    Tracklet,
    alike,
    appended,
    extend,
    join_alike,
)

# from the frames around: more means merged with something, or partly hidden
MOST_AREA_CHANGE = 0.12
MOST_ANGLE_SD_DEG = 12.0  # of an orientation that is used
# (a² − b²)/(a² + b²) of the axes, below which an outline is round: pixels and shading
# give a ball 0.003
LEAST_ELONGATION = 0.01
FALLS_AGAIN = 0.5  # of the best score, of a tracklet in which the seed falls once more
FROM_AS_HIGH = 0.3  # of the height, by which it may begin lower
# ways up in a picture, y down: as it should be, lying on a side, upside down
UPWARDS = ((0.0, -1.0), (1.0, 0.0), (-1.0, 0.0), (0.0, 1.0))
# px a frame, from which on a seed moves; differences from which a scatter is taken; of
# their sizes, and of a standard normal value's
MOVES_PX, LEAST_DIFFERENCES = 0.3, 8
QUANTILE, NORMAL_QUANTILE = 0.3, 0.385
MOST_SAID = 3  # times at which the seed was lost, in a note


@dataclass(frozen=True)
class TrackedSeed:
    """The seed's track [px, y up from the bottom row] and the scene behind it."""

    track: Track
    scene: Scene
    # diameter of the circle with the seed's silhouette area, px; NaN where nobody knows
    size: float
    # of the silhouette in each row of the track, px²; NaN where it was set by hand
    areas: np.ndarray


def track_seed(
    source: FrameSource,
    *,
    falling: bool,
    progress: Callable[[float], None] | None = None,
    at: tuple[float, float, float] | None = None,
    area_px: tuple[float, float] = (0.0, np.inf),
    places: Places | None = None,
    only_places: bool = False,
) -> TrackedSeed:
    """Track the seed, which falls or rolls, through all frames; MeasurementError where
    nothing moves like a seed. at: frame, x, y [px, y down] where somebody says that it
    is. area_px: least and greatest silhouette of the stated seed. places [y down]: set
    by hand, instead of what is found in their frames; alone where nothing is
    found, or where only_places."""
    scene = learn_scene(source)
    tracklets: list[Tracklet] = []
    active: list[Tracklet] = []
    times: dict[int, float] = {}
    done, places = 0, upside_down(places or {}, scene.shape[0])
    for frame in source.iterate():
        times[frame.index] = frame.t_s
        if only_places:
            continue
        if frame.pixels.shape[:2] != scene.shape:
            source.note(
                tr("frame {} skipped: its size is not that of the others", frame.index)
            )
            continue
        shapes = find_silhouettes(frame.pixels, scene)
        active = [p for p in active if frame.index - p.frames[-1] <= PATIENCE]
        extend(active, tracklets, shapes, frame.index, frame.t_s)
        done += 1
        if progress and done % 20 == 0:
            progress(min(done / max(source.count, 1), 1.0))
    if progress:
        progress(1.0)
    tracklets = [p for p in tracklets if len(p.frames) >= 3]
    near = None if at is None else _nearest_to(tracklets, *at)
    chosen = _choose(tracklets, falling, scene) if at is None else near
    if chosen is None and len(places) >= LEAST_PLACES:
        return _by_hand(places, times, scene, area_px)
    require(
        not only_places,
        tr(
            "{}: {} places set by hand ([track] places_px) so far; {} make a track",
            source.path,
            len(places),
            LEAST_PLACES,
        ),
    )
    if chosen is None:
        where = tr("like a seed in {} frames", done)
        if at is not None:
            where = tr("near [track] follow_px = {}", [float(f"{v:.6g}") for v in at])
        raise MeasurementError(tr("{}: nothing moves {}", source.path, where))
    track = _to_track(chosen, scene, done, max(times), area_px)
    areas = np.array([s.area for s in chosen.shapes])
    size = 2 * float(np.sqrt(np.median(areas) / np.pi))
    if places:
        found = dict(zip(track.frame.tolist(), areas, strict=True))
        track = with_places(track, places, times)
        areas = np.array(
            [np.nan if f in places else found[f] for f in track.frame.tolist()]
        )
    return TrackedSeed(track, scene, size, areas)


def _by_hand(
    places: Places,
    times: dict[int, float],
    scene: Scene,
    area_px: tuple[float, float],
) -> TrackedSeed:
    """The places alone; of silhouettes nothing is known, the seed's size as stated."""
    track = track_of_places(places, times)
    least, most = area_px
    area = np.sqrt(least * most) if least > 0 else most
    size = 2 * float(np.sqrt(area / np.pi)) if np.isfinite(most) else np.nan
    return TrackedSeed(track, scene, size, np.full(len(track), np.nan))


def _nearest_to(
    tracklets: list[Tracklet], frame: float, x: float, y: float
) -> Tracklet | None:
    """The tracklet that passes the place at about that frame, joined with others of the
    same thing."""
    found: list[tuple[float, int, Tracklet]] = []
    for tracklet in tracklets:
        k = int(np.argmin(np.abs(np.array(tracklet.frames) - frame)))
        away = np.hypot(tracklet.shapes[k].x - x, tracklet.shapes[k].y - y)
        size = np.sqrt(tracklet.area)
        if abs(tracklet.frames[k] - frame) <= PATIENCE and away < 2 * size + 4:
            found.append((float(away), len(found), tracklet))
    return join_alike(min(found)[2], tracklets) if found else None


def _choose(tracklets: list[Tracklet], falling: bool, scene: Scene) -> Tracklet | None:
    """The tracklet with the highest score, joined with others of the same thing; None
    where all score 0. Where nothing falls down, what falls aside or up counts: the
    picture is turned."""
    for up in UPWARDS if falling else UPWARDS[:1]:
        scores = [_score(tracklet, falling, scene, up) for tracklet in tracklets]
        if max(scores, default=0.0) > 0:
            break
    else:
        return None
    best = max(range(len(scores)), key=lambda i: (scores[i], i))
    chosen = join_alike(tracklets[best], tracklets)
    if falling:
        chosen = _with_further_falls(chosen, tracklets, scores, best)
    return chosen


def _with_further_falls(
    chosen: Tracklet, tracklets: list[Tracklet], scores: list[float], best: int
) -> Tracklet:
    """The chosen tracklet with those before and after it of the same thing let go
    again: each falls as far, from as high."""
    top, bottom = (f(s.y for s in tracklets[best].shapes) for f in (min, max))
    for other, score in zip(tracklets, scores):
        highest = min(s.y for s in other.shapes)
        if (
            score > FALLS_AGAIN * scores[best]
            and highest - top < FROM_AS_HIGH * (bottom - top)
            and alike(other, tracklets[best])
        ):
            chosen = appended(chosen, join_alike(other, tracklets))
    return chosen


def _score(
    tracklet: Tracklet, falling: bool, scene: Scene, up: tuple[float, float]
) -> float:
    """Score of a tracklet: distance covered, times smoothness and contrast; for a drop,
    height fallen, times contrast. up: in the picture, y down."""
    x = np.array([s.x for s in tracklet.shapes])
    y = up[0] * x + up[1] * np.array([s.y for s in tracklet.shapes])
    extent = tracklet.extent
    size = np.sqrt(tracklet.area)
    if extent < max(0.7 * size, 4.0) or tracklet.area > 0.05 * np.prod(scene.shape):
        return 0.0
    strength = tracklet.contrast
    if not falling:
        return extent * np.sqrt(strength) * _smoothness(x, size)
    if np.ptp(y) < 0.5 * extent:
        return 0.0
    return _fall_height(np.array(tracklet.frames, dtype=float), y) * np.sqrt(strength)


def _fall_height(frames: np.ndarray, y: np.ndarray) -> float:
    """Sum of the heights of all flights that are parabolas opening downwards, less
    those opening upwards."""
    if len(y) < 4:
        return 0.3 * float(np.ptp(y))
    # minima that are deeper than noise
    turns = find_peaks(-y, prominence=0.03 * np.ptp(y) + 1.0)[0] if len(y) > 4 else ()
    big = [0, *map(int, turns), len(y) - 1]
    height = 0.0
    for a, b in itertools.pairwise(big):
        inner = slice(a + 1, b) if b - a > 5 else slice(a, b + 1)
        if inner.stop - inner.start < 3:
            continue
        f, h = frames[inner] - frames[inner].mean(), y[inner]
        if a == 0:  # omit the rest before the release
            begin = int(np.flatnonzero(h >= h.max() - 0.02 * np.ptp(h))[-1])
            f, h = (f[begin:], h[begin:]) if len(h) - begin >= 4 else (f, h)
        bend, slope, level = np.polyfit(f, h, 2)
        left = float(np.std(h - np.polyval([bend, slope, level], f)))
        extent = float(np.ptp(h))
        if extent > 2 and left < 0.1 * extent:
            height += extent * (1.0 if bend < 0 else -1.0)
    return max(height, 0.0)


def _smoothness(x: np.ndarray, size: float) -> float:
    """1 for a smooth path, towards 0 for one that jumps about."""
    if len(x) < 6:
        return 0.3
    jerk = np.abs(np.diff(x, 2))
    typical, step = np.median(jerk), max(np.ptp(x) / len(x), 1e-9)
    return float(1 / (1 + 10 * typical / step * (typical > 0.3) + np.mean(jerk > size)))


def _to_track(
    tracklet: Tracklet,
    scene: Scene,
    total: int,
    last: int,
    area_px: tuple[float, float],
) -> Track:
    """The tracklet as a Track: y up from the bottom row, orientation unwrapped,
    outlying silhouettes marked. total: frames that were looked at; last: the number of
    the last one."""
    shapes = tracklet.shapes
    x, y, sd = np.array([(s.x, s.y, s.sd) for s in shapes]).T
    area, cut = np.array([s.area for s in shapes]), np.array([s.cut for s in shapes])
    frame, t_s = np.array(tracklet.frames), np.array(tracklet.times)
    outlying = _outlying_areas(area)
    if (poses := fit_ellipses(shapes, area_px)) is not None:
        best = [s if one is None else one for s, one in zip(shapes, poses)]
        x, y, sd = np.array([(s.x, s.y, s.sd) for s in best]).T
        outlying = np.array([one is None for one in poses])
    y = scene.shape[0] - 1 - y
    sd = _seen_sd(frame, x, y, sd, outlying | cut)
    angle, angle_sd = _orientation(shapes, frame, outlying | cut)
    has_angle = bool(np.isfinite(angle).any())
    left = cut[-1] or _leaves(shapes, scene)
    lost = _lost(frame, frame[-1] if left else last)
    hidden = int((outlying & ~cut).sum())
    told = (
        (
            total > len(shapes),
            tr("the seed was found in {} of {} frames{}", len(shapes), total, lost),
        ),
        (
            cut.any(),
            tr(
                "{} frames with the seed partly out of the picture (marked as"
                " outliers)",
                int(cut.sum()),
            ),
        ),
        (
            hidden,
            tr(
                "{} frames with the seed partly hidden or merged with something (marked"
                " as outliers)",
                hidden,
            ),
        ),
    )
    return make_track(
        t_s,
        x,
        y,
        unit="px",
        frame=frame,
        sd=sd,
        outlier=outlying | cut,
        angle_deg=angle if has_angle else None,
        angle_sd_deg=angle_sd if has_angle else None,
        notes=tuple(note for holds, note in told if holds),
    )


def _seen_sd(
    frame: np.ndarray, x: np.ndarray, y: np.ndarray, sd: np.ndarray, bad: np.ndarray
) -> np.ndarray:
    """The places' sd [px], where the seed moves at least what its places scatter by:
    light, blur and rows that it crosses shift its outline by more than noise does, from
    one frame to the next."""
    moves = moving(x, y)
    typical = float(np.median(sd[moves & ~bad])) if (moves & ~bad).any() else np.inf
    factor = np.nanmax([1.0, scatter_px(frame, x, y, bad) / typical])
    return np.where(moves, factor * sd, sd)


def moving(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """In which rows the seed moves by more than MOVES_PX a frame."""
    if len(x) < 2:
        return np.zeros(len(x), bool)
    return np.hypot(np.gradient(x), np.gradient(y)) > MOVES_PX


def scatter_px(
    frame: np.ndarray, x: np.ndarray, y: np.ndarray, bad: np.ndarray
) -> float:
    """What the places scatter by while the seed moves [px], the greater of both axes;
    NaN of too few rows. Third differences, √20 sd of independent places, hold no steady
    acceleration; impacts are in few of them, whence the lower quantile."""
    if len(frame) < 4:
        return np.nan
    together = frame[3:] - frame[:-3] == 3
    unused = sliding_window_view(bad | ~moving(x, y), 4).any(axis=1)
    used = together & ~unused
    if used.sum() < LEAST_DIFFERENCES:
        return np.nan
    steps = max(np.quantile(np.abs(np.diff(v, 3)[used]), QUANTILE) for v in (x, y))
    return float(steps / np.sqrt(20) / NORMAL_QUANTILE)


def _lost(frame: np.ndarray, last: int) -> str:
    """Where the seed was lost for longer than a tracklet waits, the longest times
    first, and whether it was found again until frame `last`."""
    gone = np.diff(frame) - 1
    longest = [k for k in np.argsort(-gone, kind="stable") if gone[k] > PATIENCE]
    parts = [
        tr("lost at frame {}, found again at {}", frame[k] + 1, frame[k + 1])
        for k in sorted(longest[:MOST_SAID])
    ]
    if last - frame[-1] > PATIENCE:
        parts.append(tr("lost at frame {} and not found again", frame[-1] + 1))
    return "".join(f"; {part}" for part in parts)


def _leaves(shapes: list[Silhouette], scene: Scene) -> bool:
    """Whether the last step, taken twice more, leads out of the picture."""
    before, end = shapes[-2:]
    x, y = 3 * end.x - 2 * before.x, 3 * end.y - 2 * before.y
    high, wide = scene.shape
    return not (0 <= x < wide and 0 <= y < high)


def _outlying_areas(area: np.ndarray) -> np.ndarray:
    """Rows whose area differs from that of the frames around (a tumbling seed's changes
    slowly)."""
    if len(area) < 9:
        return np.zeros(len(area), dtype=bool)
    window = 15 if len(area) > 60 else 5
    off = np.abs(area / median_filter(area, window, mode="mirror") - 1)
    return off > max(MOST_AREA_CHANGE, 6 * robust_sd(off))


def _orientation(
    shapes: list[Silhouette], frame: np.ndarray, outlying: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Unwrapped orientation [deg, anticlockwise] and its sd; NaN where it is unknown. A
    silhouette gives it up to half turns, so the value nearest to the extrapolated spin
    is taken. A round outline has none."""
    raw = np.array(
        [0.5 * np.degrees(np.arctan2(-2 * s.xy, s.xx - s.yy)) for s in shapes]
    )
    sd = np.array([s.angle_sd_deg for s in shapes])
    stretch = np.array(
        [np.hypot(s.xx - s.yy, 2 * s.xy) / (s.xx + s.yy) for s in shapes]
    )
    round_outline = (
        np.median(stretch[~outlying] if (~outlying).any() else stretch)
        < LEAST_ELONGATION
    )
    clear = (sd < MOST_ANGLE_SD_DEG) & ~outlying & ~round_outline
    angle = np.full(len(shapes), np.nan)
    spin = 0.0
    history: list[float] = []
    last = None
    for i in np.flatnonzero(clear):
        if last is None:
            angle[i] = raw[i]
        else:
            ahead = frame[i] - frame[last]
            expected = angle[last] + spin * ahead
            angle[i] = raw[i] + 180 * np.round((expected - raw[i]) / 180)
            history = [*history[-4:], (angle[i] - angle[last]) / ahead]
            spin = float(np.median(history))
        last = i
    return angle, np.where(clear, sd, np.nan)
