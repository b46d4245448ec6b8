"""The pile recipe: photo → ground → silhouette → sub-pixel surface → base line → flanks → least-squares lines → angles.

The angle of repose is the inclination of the least-squares line through the surface between two heights, by default 20 and
80 % of the crest's height above the base line (`window`): rounded crest and long toe are left out, for photo and render alike.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from vision.measurement import DOUBTFUL, GOOD, MeasurementError, Quantity, failed
from vision.pile.base import BASES, find_base_line, find_horizontal, given_base, scaled
from vision.pile.boundary import Ground, Silhouette, edge, find_ground, silhouettes
from vision.pile.centroid import centroid_angle
from vision.pile.foot import foot_line
from vision.pile.heap import TOE, BaseLine, Heap, find_heap
from vision.pile.region import Region, find_region
from vision.pile.slope import Slope, fit_slope
from vision.recording import Camera

NO_SLOPE = "no slope to measure: "
LIKELY = 0.6  # of a sure likeness to seeds: where nothing else can be measured this is, with a doubt
APART, AREA = 0.1, 0.15  # of the heap's height, and area: farther apart two readings are of different things


@dataclass(frozen=True)
class PileOptions:
    """How a pile photo is read. window: height fractions; roi: x, y, width, height in px; baseline: two points x, y in px; side:
    "left" or "right" where the pile has one slope only (it leans on a box), else ""."""

    window: tuple[float, float] = (0.2, 0.8)
    roi: tuple[int, int, int, int] | None = None
    baseline: tuple[float, float, float, float] | None = None
    side: str = ""


@dataclass(frozen=True)
class Repose:
    """What was found in one pile photo; places in px of the whole picture, y down. `surface` has one row a column, NaN: none."""

    surface: np.ndarray
    base: BaseLine
    horizontal_deg: float
    horizontal_sd_deg: float
    heap: Heap
    crest: tuple[float, float]
    toes: tuple[float | None, float | None]
    slopes: tuple[Slope, ...]
    window: tuple[float, float]
    roi: tuple[int, int, int, int]
    quantities: tuple[Quantity, ...]
    notes: tuple[str, ...] = ()


def measure_repose(
    image: np.ndarray,
    camera: Camera | None = None,
    options: PileOptions | None = None,
    *,
    find: Callable[[np.ndarray], Region | None] = find_region,
) -> Repose:
    """Angle of repose of the pile in `image`, (h, w) or (h, w, 3), uint8 or uint16.

    find: finds the seeds in the part of the picture that is looked at; it knows of no base line and no window, so that who
    measures one picture with several of these may keep what it found.

    The horizontal is camera.plumb_deg when stated, else the plate's own line. Raises MeasurementError with the reason when no
    pile can be measured. Valid for slopes of about 8° to 65° seen from the side, the background showing at the picture's top.
    """
    camera, options = camera or Camera(), options or PileOptions()
    x0, y0, width, height = roi = _roi(image, options)
    cut = np.ascontiguousarray(image[y0 : y0 + height, x0 : x0 + width])
    if min(cut.shape[:2]) < 24:
        raise MeasurementError(f"the picture is {cut.shape[1]} × {cut.shape[0]} px; a pile needs at least 24 px each way")
    smooth = _before_one_background(cut, camera, options, roi)
    region = find(cut)
    by_hand = options.roi is not None or options.baseline is not None
    enough = 1.0 if isinstance(smooth, Repose) else 0.0 if by_hand else LIKELY
    if region is None or region.likeness < enough:
        return _or_raise(smooth)
    seeds = _as_seeds(cut, region, camera, options, roi)
    if isinstance(seeds, str) or (isinstance(smooth, Repose) and _same_heap(smooth, seeds, region)):
        return _or_raise(smooth)  # its edges are read off the full picture
    doubt = _which(region, by_hand)
    return replace(seeds, quantities=tuple(q.doubt(doubt) for q in seeds.quantities)) if doubt else seeds


def _which(region: Region, by_hand: bool) -> str:
    """What is to be doubted about which part of the picture is the pile."""
    if by_hand:
        return ""
    if region.rival is not None:
        x, _, foot = region.rival[:3]
        return f"another part of the picture, about x {x:.0f}, y {foot:.0f} px, looks as much like a heap: name the pile by --roi"
    if region.likeness < 1:
        return "it is not sure that what was taken for the pile (see the overlay) is all of it and only that: name it by --roi"
    return ""


def _or_raise(found: Repose | str) -> Repose:
    if isinstance(found, str):
        raise MeasurementError(found)
    return found


def _before_one_background(cut: np.ndarray, camera: Camera, options: PileOptions, roi) -> Repose | str:
    """The pile whose surface is where one smooth background ends; the reason in words where there is none."""
    ground = find_ground(cut)
    tried: list[Repose | str] = []
    for silhouette in silhouettes(ground):
        tried.append(_try(cut, ground, silhouette, camera, options, roi))
        if isinstance(tried[-1], Repose) and tried[-1].base.source in BASES[:2]:
            break  # no better base line is to be had
    found = [r for r in tried if isinstance(r, Repose)]
    if not found:
        return str(tried[0]) if tried else "no pile in the picture: nothing stands out from the background"
    best = min(found, key=lambda r: BASES.index(r.base.source))
    cut_off = next((r for r in tried if isinstance(r, str) and r.startswith(NO_SLOPE) and "cut by" in r), "")
    if best.base.source == "toe" and cut_off:  # a better base line knew that the foot is not in the picture
        return replace(best, quantities=tuple(q.doubt(cut_off.removeprefix(NO_SLOPE)) for q in best.quantities))
    return best


def _as_seeds(cut: np.ndarray, region: Region, camera: Camera, options: PileOptions, roi) -> Repose | str:
    """The heap that is told from its surroundings by being seeds; the reason in words where it cannot be measured."""
    base = given_base(options.baseline, cut.shape, roi) or foot_line(region, np.tan(np.radians(camera.plumb_deg or 0.0)))
    if base is None:
        return "no line is seen that the pile stands on: name it by --baseline"
    surface = np.minimum(_upper(region, region.mask, cut.shape[1]), base.at(np.arange(cut.shape[1])))
    return _angles(surface, base, region.factor, camera, options, roi, cut.shape)


def _upper(region: Region, mask: np.ndarray, width: int) -> np.ndarray:
    """The upper border of a mask of the region's close-up in every column of the picture, inf where it has none."""
    columns = np.flatnonzero(mask.any(axis=0))
    rows = mask[:, columns].argmax(axis=0) * region.factor - 0.5 + region.origin[1]
    x = (columns + 0.5) * region.factor - 0.5 + region.origin[0]
    return np.interp(np.arange(width), x, rows, left=np.inf, right=np.inf)


def _same_heap(smooth: Repose, seeds: Repose, region: Region) -> bool:
    """Whether the surface before a smooth background is that of the seeds: it leaves few out, takes in nothing that is not
    grainy, and stands on the same line."""
    x = np.arange(seeds.surface.size)
    foot = seeds.base.at(x)
    surface = np.fmin(smooth.surface, foot)
    area = float((foot - seeds.surface).sum())
    grainy = np.minimum(_upper(region, region.grown, x.size), foot)
    crest = smooth.crest[0] - smooth.roi[0]
    left, right = (crest if toe is None else toe for toe in smooth.toes)
    heap = (x >= left) & (x <= right)  # without the wall that it may lean on
    if not heap.any():
        return False
    left_out, taken_in = np.clip(surface - seeds.surface, 0, None).sum(), np.clip(grainy - surface, 0, None)[heap].sum()
    under = foot - seeds.surface > 0
    apart = np.abs(smooth.base.at(x) - foot)[under].mean()
    tall = float(np.ptp(seeds.surface[under]))
    top, loose, close = (float(s[heap].min()) for s in (surface, grainy, seeds.surface))  # the crest lies between these two
    apart = max(apart, loose - top, top - close)
    return bool(max(left_out, taken_in) < AREA * area and apart < APART * tall)


def _roi(image: np.ndarray, options: PileOptions) -> tuple[int, int, int, int]:
    height, width = image.shape[:2]
    if options.roi is None:
        return 0, 0, width, height
    x, y, w, h = options.roi
    if x < 0 or y < 0 or w <= 0 or h <= 0 or x + w > width or y + h > height:
        raise MeasurementError(f"--roi {x},{y},{w},{h} does not lie inside the picture ({width} × {height} px)")
    return x, y, w, h


def _try(cut, ground: Ground, silhouette: Silhouette, camera: Camera, options: PileOptions, roi) -> Repose | str:
    """Measure one candidate silhouette; the reason in words when it holds no measurable pile."""
    surface = edge(cut, ground, silhouette.top, silhouette.threshold)
    base = find_base_line(cut, ground, silhouette, surface, options.baseline, camera, roi)
    return _angles(surface, base, ground.factor, camera, options, roi, cut.shape)


def _angles(surface, base: BaseLine, factor: float, camera: Camera, options: PileOptions, roi, shape) -> Repose | str:
    """What a surface above its base line says; the reason in words when it is no measurable pile."""
    heap = find_heap(_shrink_profile(surface, factor), scaled(base, factor), options.window)
    if heap.problem:
        return heap.problem
    if options.side:
        flanks = (f if f.side == options.side else replace(f, problem="a wall, as stated") for f in heap.flanks)
        heap = replace(heap, flanks=tuple(flanks))
    horizontal, horizontal_sd, doubts = find_horizontal(base, camera)
    if base.source == "toe" and np.nanmax(surface) > 0.985 * shape[0]:
        doubts = (*doubts, "the pile is cut by the picture's bottom border: the window is of the height that shows")
    slopes = []
    for flank in heap.flanks:
        if not flank.problem:
            slope = fit_slope(surface, base, heap, flank, factor, options.window, horizontal, horizontal_sd)
            if slope:
                slopes.append(slope)
    if not slopes:
        reasons = {f.problem for f in heap.flanks if f.problem} or {"the surface is too rough or too short for a line"}
        return NO_SLOPE + "; ".join(sorted(reasons))
    return _result(surface, base, heap, tuple(slopes), horizontal, horizontal_sd, doubts, factor, options, roi)


def _shrink_profile(surface: np.ndarray, factor: float) -> np.ndarray:
    """The surface in px of `factor` columns each: the median of the full columns in each."""
    count = max(1, round(surface.size / factor))
    columns = ((np.arange(surface.size) + 0.5) / factor).astype(int).clip(0, count - 1)
    bounds = np.searchsorted(columns, np.arange(count + 1))
    out = np.full(count, np.nan)
    for i, (a, b) in enumerate(pairwise(bounds)):
        piece = surface[a:b]
        piece = piece[np.isfinite(piece)]
        if piece.size:
            out[i] = (np.median(piece) + 0.5) / factor - 0.5
    return out


def _result(surface, base, heap, slopes, horizontal, horizontal_sd, doubts, factor, options, roi) -> Repose:
    by_side = {s.side: s for s in slopes}
    quantities = [_repose(slopes, horizontal_sd, doubts, heap)]
    for side in ("left", "right"):
        name = f"repose_angle_{side}"
        problem = next(f.problem for f in heap.flanks if f.side == side)
        if side in by_side:
            quantities.append(_angle(name, by_side[side].angle_deg, by_side[side].angle_sd_deg, (*by_side[side].doubts, *doubts)))
        elif not problem.startswith("a wall"):
            quantities.append(failed(name, "deg", problem or "the surface is too rough or too short for a line"))
    crest_x = (heap.crest + 0.5) * factor - 0.5
    left, right = ((f.toe + 0.5) * factor - 0.5 if f.side in by_side else None for f in heap.flanks)
    toes = (left, right)
    quantities.append(_height_over_radius(heap, base, slopes, toes, crest_x, factor, doubts))
    quantities.append(centroid_angle(surface, base, heap, factor, tuple(doubts)))
    x0, y0 = roi[:2]
    return Repose(
        surface=surface, base=base, horizontal_deg=horizontal, horizontal_sd_deg=horizontal_sd, heap=heap,
        crest=(crest_x + x0, float(base.at(crest_x)) - heap.height_px * factor + y0), toes=toes, slopes=slopes,
        window=options.window, roi=roi, quantities=tuple(quantities), notes=(_definition(base, options.window),),
    )  # fmt: skip


def _definition(base: BaseLine, window: tuple[float, float]) -> str:
    """What the angle is the angle of: without it the number means little."""
    return f"line through {100 * window[0]:.0f}–{100 * window[1]:.0f} % of the crest's height; base line: {base.source}"


def _repose(slopes, horizontal_sd, doubts, heap: Heap) -> Quantity:
    """Mean of both flanks (the horizontal's error cancels), or the one flank there is."""
    notes = [d for s in slopes for d in s.doubts] + list(doubts)
    if len(slopes) == 1:
        for flank in heap.flanks:
            if flank.problem and not flank.problem.startswith("a wall"):
                notes.append(f"{flank.side} side: {flank.problem}")
        return _angle("repose_angle", slopes[0].angle_deg, slopes[0].angle_sd_deg, notes)
    left, right = slopes
    mean = (left.angle_deg + right.angle_deg) / 2
    sd = float(np.hypot(left.line.angle_sd_deg, right.line.angle_sd_deg)) / 2
    apart = abs(left.angle_deg - right.angle_deg)
    if apart > max(3 * np.hypot(2 * sd, 2 * horizontal_sd), 4.0):
        notes.append(f"left and right differ by {apart:.1f}°: the camera or the plate is tilted, or the heap is lopsided")
    return _angle("repose_angle", mean, sd, [n for n in notes if not n.startswith("no plate line")])


def _height_over_radius(heap, base, slopes, toes, crest_x, factor, doubts) -> Quantity:
    """atan((h − h_toe) / r): crest height over the half width (heap) or width (slope), both at the toe's height (TOE · h).

    On a straight-sided pile this is its angle; rounded crests and long toes lower it.
    """
    name = "height_over_radius_angle"
    known = [abs(t - crest_x) for t in toes if t is not None]
    two = len(slopes) == 2
    flanks_ok = two or any(f.problem.startswith("a wall") for f in heap.flanks)
    if not known or not flanks_ok:
        return failed(name, "deg", "the pile's foot is not in the picture on both sides")
    radius, height = float(np.mean(known)), heap.height_px * factor * (1 - TOE)
    ratio = height / radius
    rough = float(np.mean([s.line.rms for s in slopes]))
    blunt = 1.5 * factor  # px: a running median of 5 takes that much off a sharp crest
    sd_ratio = np.hypot(max(rough, blunt) / height, max(rough / ratio, factor) / radius / np.sqrt(len(known))) * ratio
    return _angle(name, float(np.degrees(np.arctan(ratio))), float(np.degrees(sd_ratio / (1 + ratio**2))), doubts)


def _angle(name: str, value: float, sd: float, doubts) -> Quantity:
    reason = "; ".join(dict.fromkeys(doubts))
    return Quantity(name, float(value), float(sd), "deg", DOUBTFUL if reason else GOOD, reason)
