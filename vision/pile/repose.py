"""Photo of a pile → angle of repose.

The angle of repose is the inclination of the least-squares line through the pile's
surface between two heights, by default 20 and 80 % of the crest's height above the base
line. The rounded crest and the long toe are thus left out.

Steps: which pixels are the heap, sub-pixel surface and foot, base line, flanks, lines,
angles. The heap is segmented by colour and texture (`heap_region`); what has no texture
of seeds is where one smooth background ends (`surface`)."""

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, replace

import numpy as np
import pandas as pd

from benchtwin.bench.language import tr
from benchtwin.vision.measurement import (
    FAILED,
    GOOD,
    MeasurementError,
    Quantity,
    failed,
    require,
)
from benchtwin.vision.pile.base_line import (
    BASES,
    NO_FOOT,
    find_base_line,
    find_horizontal,
    in_reduced_px,
    stated_base_line,
)
from benchtwin.vision.pile.centroid import centroid_angle
from benchtwin.vision.pile.heap import (
    NOTHING_RISES,
    STATED_WALL,
    TOE,
    WALL,
    BaseLine,
    Heap,
    find_heap,
)
from benchtwin.vision.pile.heap_region import NO_SEEDS, Region, find_region
from benchtwin.vision.pile.layer import without_layer
from benchtwin.vision.pile.line import FlankLine, Line, fit_flank
from benchtwin.vision.pile.pitch import CONE, SLAB, level_angle
from benchtwin.vision.pile.surface import (
    Edges,
    borders,
    distance_from_background,
    in_full_px,
    silhouettes,
    subpixel_edge,
)
from benchtwin.vision.recording import Camera, Recording

NO_SLOPE = "no slope to measure: "
UNSURE = (
    "what was taken for the pile (see the overlay) may be less than it, or more: name"
    " it by --roi"
)
NO_PILE = "no pile in the picture: nothing stands out from the background"
NO_LINE = "the surface is too rough or too short for a line"
# of a heap's form and colours where there is nothing else: half of what is enough
LEAST_CONFIDENCE = NO_SEEDS / 2
# levels of 255 across a heap's edge: of less, the place is the cut's own
LEAST_STEP = 8.0
MOST_APART_SDS = 3.0  # of two readings of one heap
# shares of the picture: a foot that is nearer to its border is cut by it
LEAST_BELOW, LEAST_BESIDE = 0.985, 0.99
# a flank's height is known from the side: lopsided heaps differ by less
MOST_LOPSIDED_DEG = 4.0
# heaps of seeds stand at some 20 to 40°: ± 5° tells none from another
MOST_SD_DEG = 5.0
# by the foot's bow: that of a camera 6° above the plate, five foot radii away
MOST_PITCH_DEG = 9.0
MAIN = "repose_angle"


@dataclass(frozen=True)
class PileOptions:
    """How a pile photo is read. window: heights between which the line is fitted, as
    shares of the crest's height. roi: x, y, width, height [px] of the part that is
    looked at. baseline: two points x1, y1, x2, y2 [px] of the base line. side: "left"
    or "right" for a pile with one flank only (it leans on a box), else "". form: CONE
    or SLAB (between walls) where it is known, by which a pile seen from above is
    corrected, else ""."""

    window: tuple[float, float] = (0.2, 0.8)
    roi: tuple[int, int, int, int] | None = None
    baseline: tuple[float, float, float, float] | None = None
    side: str = ""
    form: str = ""


def rig_options(recording: Recording, options: PileOptions) -> PileOptions:
    """The options with what the rig itself says: what let the seeds go, a box or a
    cylinder, tells where the pile leans and what form it has."""
    pile = recording.pile
    if pile.cylinder_mm is not None:
        return replace(options, form=CONE)
    if pile.channel_mm is not None:  # filmed from either side
        return replace(options, form=SLAB)
    if pile.box_mm is not None:  # the gate's side; the other flank leans on the box
        return replace(options, side=options.side or "right", form=SLAB)
    return options


@dataclass(frozen=True)
class Repose:
    """What was found in one pile photo. surface (w,): row in each column of the roi,
    NaN where there is none; hidden (w,): whether a layer of seeds hides it there and
    the flank is led on; base: in the roi, too. crest, toes: in px of the whole picture,
    y down. horizontal_deg: inclination of the true horizontal in the
    picture."""

    surface: np.ndarray
    hidden: np.ndarray
    base: BaseLine
    horizontal_deg: float
    crest: tuple[float, float]
    toes: tuple[float | None, float | None]
    slopes: tuple[FlankLine, ...]
    window: tuple[float, float]
    roi: tuple[int, int, int, int]
    quantities: tuple[Quantity, ...]
    notes: tuple[str, ...] = ()

    def doubted(self, *reasons: str) -> "Repose":
        """With these doubts about every quantity: all are read off one outline."""
        return replace(
            self, quantities=tuple(q.doubt(*reasons) for q in self.quantities)
        )


@dataclass(frozen=True)
class _Photo:
    """The part of the picture that is looked at, and how it is read. seeds_only: its
    outline is that of the seeds, without what they lean on."""

    crop: np.ndarray
    camera: Camera
    options: PileOptions
    roi: tuple[int, int, int, int]
    seeds_only: bool = False


def measure_repose(
    image: np.ndarray,
    camera: Camera | None = None,
    options: PileOptions | None = None,
    *,
    find: Callable[[np.ndarray], Region | None] = find_region,
) -> Repose:
    """Angle of repose of the pile in `image`, (h, w) or (h, w, 3), uint8 or uint16.

    find: segments the seeds in the cropped picture. It depends on no option but the
    roi, so its result may be cached. The horizontal is camera.plumb_deg where that is
    stated, else the plate's line. Raises MeasurementError with the reason where no pile
    can be measured. Valid for slopes of about 8° to 65° seen from the side, with
    background at the picture's top."""
    camera, options = camera or Camera(), options or PileOptions()
    x0, y0, width, height = roi = _roi(image, options)
    crop = np.ascontiguousarray(image[y0 : y0 + height, x0 : x0 + width])
    photo = _Photo(crop, camera, options, roi)
    if min(photo.crop.shape[:2]) < 24:
        raise MeasurementError(
            f"the picture is {photo.crop.shape[1]} × {photo.crop.shape[0]} px; a pile"
            " needs at least 24 px each way"
        )
    region = find(photo.crop)
    try:
        found = _measure(photo, region)
    except MeasurementError as trouble:
        if not (lies := _lies(region)):
            raise
        raise MeasurementError(tr("{}; as it is: {}", lies, trouble)) from trouble
    found = replace(found, quantities=tuple(map(if_known, found.quantities)))
    main = found.quantities[0]
    # without the texture of seeds none tells which way is up
    textured = region is None or not NO_SEEDS <= region.confidence < 1
    if main.quality == GOOD or not textured:
        return found
    return found.doubted(_lies(region))


def _doubtful(found: Repose) -> bool:
    return found.quantities[0].quality != GOOD


def if_known(q: Quantity) -> Quantity:
    """With a doubt where it is known too badly to be of use."""
    if not q.sd > MOST_SD_DEG:
        return q
    return q.doubt(tr("known no better than ± {:.0f}°", q.sd))


def _lies(region: Region | None) -> str:
    """That the picture is turned; "" where it is not."""
    way = "" if region is None else region.seen.way_up
    return way and tr("the picture looks {}: turn it", way)


def _measure(photo: _Photo, region: Region | None) -> Repose:
    """The pile by colour and texture where these are surely of seeds, else where one
    smooth background ends; where that is doubtful, by what looks somewhat like seeds,
    and where there is none, by colour alone."""
    options = photo.options
    by_hand = options.roi is not None or options.baseline is not None
    sure = region is not None and region.confidence >= 1
    smooth = tr(NO_PILE) if sure else _on_smooth_background(photo)
    confidence = -np.inf if region is None else region.confidence
    told = by_hand or confidence >= LEAST_CONFIDENCE
    if not isinstance(smooth, str):
        told = confidence >= NO_SEEDS and _doubtful(smooth)
    segmented: Repose | str = tr(NO_PILE)
    if region is not None and told:
        segmented = _of_region(replace(photo, seeds_only=True), region)
        if sure and isinstance(segmented, str):
            smooth = _on_smooth_background(photo)
    if isinstance(segmented, str):
        if isinstance(smooth, str):
            raise MeasurementError(smooth)
        return smooth
    assert region is not None
    if not by_hand:
        segmented = segmented.doubted(*_other_heaps(region))
    if isinstance(smooth, str):
        return segmented
    found = smooth if _doubtful(segmented) else segmented
    return found.doubted(
        smooth.base.doubt, tr(UNSURE) if _apart(smooth, segmented) else ""
    )


def _apart(one: Repose, other: Repose) -> bool:
    """Whether two readings are not of the same heap."""
    a, b = one.quantities[0], other.quantities[0]
    return abs(a.value - b.value) > MOST_APART_SDS * float(np.hypot(a.sd, b.sd))


def _other_heaps(region: Region) -> Iterator[str]:
    """What speaks against the region's being the heap."""
    if region.confidence < NO_SEEDS:
        yield tr(UNSURE)
    if region.rival is not None:
        x, _, foot = region.rival[:3]
        yield (
            tr(
                "another part of the picture, about x {:.0f}, y {:.0f} px, looks as"
                " much like a heap: name the pile by --roi",
                x,
                foot,
            )
        )


def _roi(image: np.ndarray, options: PileOptions) -> tuple[int, int, int, int]:
    height, width = image.shape[:2]
    if options.roi is None:
        return 0, 0, width, height
    x, y, w, h = options.roi
    require(
        x >= 0 and y >= 0 and w > 0 and h > 0 and x + w <= width and y + h <= height,
        f"--roi {x},{y},{w},{h} does not lie inside the picture ({width} ×"
        f" {height} px)",
    )
    return x, y, w, h


def _on_smooth_background(photo: _Photo) -> Repose | str:
    """The pile whose surface is where one smooth background ends; the reason where
    there is none."""
    distance, factor = distance_from_background(photo.crop)
    tried: list[Repose | str] = []
    for mask, threshold in silhouettes(distance):
        found = _of_mask(photo, mask, factor, threshold / 2)
        if isinstance(found, Repose):
            found = _with_base_error(photo, found, factor)
        tried.append(found)
        if isinstance(found, Repose) and found.base.source in BASES[:2]:
            break  # there is no better kind of base line
    readings = [r for r in tried if isinstance(r, Repose)]
    if not readings:
        return str(tried[0]) if tried else tr(NO_PILE)
    return min(readings, key=lambda r: BASES.index(r.base.source))


def _of_mask(
    photo: _Photo,
    mask: np.ndarray,
    factor: float,
    least_step: float = LEAST_STEP,
    origin: tuple[int, int] = (0, 0),
) -> Repose | str:
    """The pile that a mask, whose px are `factor` px each, takes for the heap; the
    reason where it cannot be measured. Its edges are those of the steps beside the
    mask's where there are some; of seeds else the mask's own."""
    if not mask.any():
        return tr(NOTHING_RISES)

    def edge(rows: np.ndarray, lower: bool) -> np.ndarray:
        own = in_full_px(rows, factor, photo.crop.shape[1], origin)
        step = subpixel_edge(photo.crop, own, factor, least_step, lower)
        return np.where(np.isfinite(step) | (not photo.seeds_only), step, own)

    top, bottom = borders(mask)
    return _of_edges(photo, Edges(edge(top, False), edge(bottom, True), factor))


def _of_edges(photo: _Photo, edges: Edges) -> Repose | str:
    """Angles of a pile of these edges; the reason where it cannot be measured."""
    shape = photo.crop.shape
    stated = stated_base_line(photo.options.baseline, shape, photo.roi)
    base = find_base_line(edges, shape, stated, photo.camera, not photo.seeds_only)
    if base is None:
        return tr(NO_FOOT)
    surface = edges.top
    if photo.seeds_only:  # beside them is the plate
        surface = np.fmin(surface, base.at(np.arange(shape[1])))
    return _at_base_line(photo, surface, base, edges.factor)


def _of_region(photo: _Photo, region: Region) -> Repose | str:
    """The pile that most cuts agree on, with what they differ by in every sd."""
    start = region.start
    agreed, *cuts = (
        _of_mask(photo, mask, start.zoom, origin=start.origin)
        for mask in (region.agreed, *region.cuts)
    )
    if isinstance(agreed, str):
        return agreed
    shown = [k for k, cut in enumerate(cuts) if isinstance(cut, Repose)]
    found = [cut for cut in cuts if isinstance(cut, Repose)]
    likely = float(region.weights[shown].sum())
    if likely <= 0.5:
        why = tr(
            "no such pile is seen with a probability of {:.0f} %", 100 * (1 - likely)
        )
        agreed = agreed.doubted(tr("{}: name it by --roi", why))
    agreed = _with_base_error(photo, agreed, start.zoom)
    return _widened(agreed, found, region.weights[shown])


def _widened(
    found: Repose, others: Iterable[Repose], weights: np.ndarray | None = None
) -> Repose:
    """With the root mean square by which other readings differ, by their weights (alike
    where there are none), added to every sd."""
    given = [{q.name: q.value for q in other.quantities} for other in others]
    weights = np.ones(len(given)) if weights is None else weights
    quantities = []
    for q in found.quantities:
        off = np.array([v.get(q.name, np.nan) - q.value for v in given])
        told = np.isfinite(off)
        counts = max(float(weights[told].sum()), 1e-9)
        spread = np.sqrt(float(weights[told] @ off[told] ** 2) / counts)
        quantities.append(replace(q, sd=float(np.hypot(q.sd, spread))))
    return replace(found, quantities=tuple(quantities))


def _with_base_error(photo: _Photo, found: Repose, factor: float) -> Repose:
    """With what an error of the base line's height makes of every quantity; what lies
    beside the pile moves with the line."""
    x, base = np.arange(found.surface.size), found.base
    left, right = found.toes
    beside = (x < (left or -np.inf)) | (x > (right or np.inf))
    others = []
    for off in (-base.sd, base.sd):
        line = replace(base, intercept=base.intercept + off)
        surface = np.where(beside, np.fmax(found.surface, line.at(x)), found.surface)
        others.append(_at_base_line(photo, surface, line, factor))
    return _widened(found, (other for other in others if isinstance(other, Repose)))


def _at_base_line(
    photo: _Photo, surface: np.ndarray, base: BaseLine, factor: float
) -> Repose | str:
    options = photo.options
    seen = surface
    surface, layered = without_layer(seen, base)
    heap = find_heap(
        _shrink_profile(surface, factor),
        in_reduced_px(base, factor),
        options.window,
        walled=not photo.seeds_only,
    )
    if heap.problem:
        return heap.problem
    if options.side:
        flanks = (
            f if f.side == options.side else replace(f, problem=STATED_WALL)
            for f in heap.flanks
        )
        heap = replace(heap, flanks=tuple(flanks))
    horizontal, horizontal_sd, unlevel = find_horizontal(base, photo.camera)
    fits = [
        fit_flank(
            surface, base, heap, f, factor, options.window, horizontal, horizontal_sd
        )
        for f in heap.flanks
        if not f.problem
    ]
    slopes = tuple(fit for fit in fits if fit is not None)
    if not slopes:
        return tr(NO_SLOPE) + "; ".join(
            sorted(
                {tr(f.problem or NO_LINE) for f in heap.flanks if f.problem}
                or {tr(NO_LINE)}
            )
        )
    crest_x = (heap.crest + 0.5) * factor - 0.5
    fitted = {s.side for s in slopes}
    left, right = (
        (f.toe + 0.5) * factor - 0.5 if f.side in fitted else None for f in heap.flanks
    )
    quantities = (
        *_mean_angles(slopes, horizontal_sd, unlevel),
        *_side_angles(slopes, heap, unlevel),
        _height_over_radius(heap, base, slopes, (left, right), factor).doubt(*unlevel),
        centroid_angle(surface, base, heap, factor).doubt(*unlevel),
    )
    x0, y0 = photo.roi[:2]
    crest = (crest_x + x0, float(base.at(crest_x)) - heap.height_px * factor + y0)
    low, high = options.window
    definition = tr(
        "line through {:.0f}–{:.0f} % of the crest's height; base line: {}",
        100 * low,
        100 * high,
        base.source,
    )
    if base.pitch_deg > 0:
        quantities = tuple(_as_level(q, base.pitch_deg, options) for q in quantities)
    found = Repose(
        surface,
        surface != seen,
        base,
        horizontal,
        crest,
        (left, right),
        slopes,
        options.window,
        photo.roi,
        quantities,
        (definition, *_notes(layered, heap, surface.size / factor)),
    )
    return found.doubted(*_doubts(photo, found, heap, horizontal_sd))


def _notes(layered: tuple[str, ...], heap: Heap, wide: float) -> Iterator[str]:
    """What was left out; what leans on the picture's border may go on beyond it."""
    if layered:
        beside = tr(" and ").join(layered)
        yield tr("a layer of seeds beside the heap ({}) is left out", beside)
    margin = max((1 - LEAST_BESIDE) * wide, 2.0)
    for flank in heap.flanks:
        if flank.problem == WALL and not margin < flank.toe < wide - 1 - margin:
            yield (
                tr(
                    "the heap reaches the picture's {} border, where it is taken to"
                    " lean on a wall: if it goes on, its angle is a part's",
                    flank.side,
                )
            )


def _as_level(q: Quantity, pitch_deg: float, options: PileOptions) -> Quantity:
    """The quantity as a camera level with the plate sees it."""
    if q.quality == FAILED:
        return q
    value, off = level_angle(q.name, q.value, pitch_deg, options.form, options.window)
    return replace(q, value=value, sd=float(np.hypot(q.sd, off)))


def _doubts(
    photo: _Photo, found: Repose, heap: Heap, horizontal_sd: float
) -> Iterator[str]:
    """What speaks against the outline, of which every quantity is read."""
    yield found.base.doubt
    height, width = photo.crop.shape[:2]
    foot = found.base.at(found.crest[0] - found.roi[0])
    told = photo.seeds_only or heap.walls or photo.options.roi is not None
    pitch = f"{found.base.pitch_deg:.0f}°"
    reasons = (
        (found.base.source == "toe" and not photo.seeds_only, tr(NO_FOOT)),
        (
            foot > LEAST_BELOW * height,
            tr("the pile is cut by the picture's bottom border"),
        ),
        (
            found.base.pitch_deg > MOST_PITCH_DEG,
            tr("the camera looks down by about {}: the pile's foot is bowed", pitch),
        ),
        (
            (photo.options.side or heap.boxed) and not told,
            tr(
                "the wall that the heap leans on is not told from it: name the heap by"
                " --roi"
            ),
        ),
    )
    yield from (why for holds, why in reasons if holds)
    yield from dict.fromkeys(doubt for s in found.slopes for doubt in s.doubts)
    fitted = {s.side for s in found.slopes}
    for flank in heap.flanks:
        if flank.side not in fitted and not flank.at_wall:
            yield tr("{} side: {}", tr(flank.side), tr(flank.problem or NO_LINE))
    margin = (1 - LEAST_BESIDE) * width
    for side, toe in zip(("left", "right"), found.toes):
        if toe is not None and not margin < toe < width - 1 - margin:
            yield tr("the pile's foot is cut by the picture's {} border", side)
    if len(found.slopes) == 2:
        left, right = found.slopes
        apart = abs(left.angle_deg - right.angle_deg)
        sd = np.hypot(left.line.angle_sd_deg, right.line.angle_sd_deg)
        if apart > max(3 * np.hypot(sd, 2 * horizontal_sd), MOST_LOPSIDED_DEG):
            yield (
                tr(
                    "left and right differ by {:.1f}°: the camera or the plate is"
                    " tilted, or the heap is lopsided",
                    apart,
                )
            )


def _shrink_profile(surface: np.ndarray, factor: float) -> np.ndarray:
    """The surface in px of `factor` columns each: the median of the full columns in
    each."""
    count = max(1, round(surface.size / factor))
    columns = ((np.arange(surface.size) + 0.5) / factor).astype(int).clip(0, count - 1)
    found = pd.Series(surface).groupby(columns).median().to_numpy()
    return (found + 0.5) / factor - 0.5


def _mean_angles(
    slopes: tuple[FlankLine, ...], horizontal_sd: float, unlevel: tuple[str, ...]
) -> Iterator[Quantity]:
    """Of whole flanks, their lower and their upper thirds: the mean of both, in which
    the horizontal's error cancels, or the one that there is."""
    for name, parts in (
        (MAIN, [(s.angle_deg, s.line.angle_sd_deg) for s in slopes]),
        ("toe_angle", [s.toe for s in slopes]),
        ("top_angle", [s.top for s in slopes]),
    ):
        told = np.array([part for part in parts if part is not None])
        if len(told) < len(parts):
            continue
        one = len(told) == 1
        own = np.linalg.norm(told[:, 1]) / len(told)
        sd = float(np.hypot(own, one * horizontal_sd))
        if name != MAIN and sd > MOST_SD_DEG:
            continue  # of too few seeds
        q = Quantity(name, float(told[:, 0].mean()), sd, "deg")
        yield q.doubt(*unlevel) if one else q


def _side_angles(
    slopes: tuple[FlankLine, ...], heap: Heap, unlevel: tuple[str, ...]
) -> Iterator[Quantity]:
    """The angle of each flank; none for a side with a wall."""
    fitted = {s.side: s for s in slopes}
    for flank in heap.flanks:
        name = f"{MAIN}_{flank.side}"
        if slope := fitted.get(flank.side):
            q = Quantity(name, slope.angle_deg, slope.angle_sd_deg, "deg")
            yield q.doubt(*unlevel)
        elif not flank.at_wall:
            yield failed(name, "deg", tr(flank.problem or NO_LINE))


def _foot_of(line: Line, base: BaseLine, above: float) -> float:
    """Where a flank's line is so many px above the base line."""
    off = base.intercept - above - line.intercept
    return off / (line.slope - base.slope)


def _height_over_radius(
    heap: Heap,
    base: BaseLine,
    slopes: tuple[FlankLine, ...],
    toes: tuple[float | None, float | None],
    factor: float,
) -> Quantity:
    """atan((h − h_toe) / r): crest height over half the width (heap) or the width (one
    flank), both at the toe's height TOE · h. It is the angle of a straight-sided pile;
    rounded crests and long toes lower it. A seed that lies at the toe may be the
    heap's: half of what is between the toe and the flank's own line is in the sd."""
    name = "height_over_radius_angle"
    crest_x = (heap.crest + 0.5) * factor - 0.5
    known = [abs(t - crest_x) for t in toes if t is not None]
    complete = len(slopes) == 2 or any(f.at_wall for f in heap.flanks)
    if not known or not complete:
        return failed(
            name, "deg", tr("the pile's foot is not in the picture on both sides")
        )
    radius, height = float(np.mean(known)), heap.height_px * factor * (1 - TOE)
    ratio = height / radius
    rms = float(np.mean([s.line.rms for s in slopes]))
    blunt = 1.5 * factor  # px that a running median of 5 takes off a sharp crest
    up = max(rms, blunt) / height
    # where the crest of a pile with one flank is; of two, both ends count alike
    flat = heap.crest_width * factor / np.sqrt(12) if len(known) == 1 else 0.0
    aside = np.hypot(max(rms / ratio, factor), flat) / radius / np.sqrt(len(known))
    led = [_foot_of(s.line, base, TOE * heap.height_px * factor) for s in slopes]
    ends = [toe for toe in toes if toe is not None]
    beyond = [toe - end for toe, end in zip(ends, led, strict=True)]
    aside = np.hypot(aside, np.linalg.norm(beyond) / 2 / len(beyond) / radius)
    sd = float(np.degrees(np.hypot(up, aside) * ratio / (1 + ratio**2)))
    return Quantity(name, float(np.degrees(np.arctan(ratio))), sd, "deg")
