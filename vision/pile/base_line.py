"""Base line of a pile and the true horizontal: what heights and angles are measured
from.

The foot of a segmented heap is straight for a level camera and the near half of an
ellipse for one that looks down on a round heap. On a shiny plate the base line lies
half-way between the heap and its mirror image."""

from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from benchtwin.bench.language import tr
from benchtwin.bench.priors import unstated_sd
from benchtwin.bench.robust import robust_sd
from benchtwin.vision.measurement import NARROWED, require
from benchtwin.vision.pile.heap import MAX_PLATE_SLOPE, BaseLine
from benchtwin.vision.pile.line import EDGE_FLOOR_PX, LEAST_COLUMNS, Line, fit_line
from benchtwin.vision.pile.surface import Edges
from benchtwin.vision.recording import Camera

Segment = tuple[float, float, float, float]  # x1, y1, x2, y2 [px, y down]
# between the tops of seeds, small px; shares of the columns along a line, above which
# it runs over a layer of seeds: between them; gaps of a twentieth of the heap's height
LEAST_DEPTH_PX, MOST_BETWEEN, MOST_GAPS = 1.5, 0.03, 0.01
# of the columns, at least: a plate's; of the others, at most: what is below it
LEAST_ON_PLATE, MOST_BELOW = 0.08, 0.15
LEVEL_SD = 0.5  # small px: of a line read off the picture's edges
GIVEN_SD_PX = 1.0
# off the stated horizontal: a line farther off is taken only where no other is found
MOST_TILT_DEG = 2.0
BASES = ("given", "plate", "foot", "mirror", "toe")  # how it was found, best first
SEEN = ("plate", "foot")  # lines that are told by the picture
MOST_OFF_DEG = 0.5  # of a line set by hand beside the plate that is seen
LOOKS_DOWN_DEG = 10.0  # photos are asked for from 0 to 5°, and taken from higher, too
NO_FOOT = "no line is seen that the pile stands on: name it by --baseline"
MIRRORED = (
    "what is taken for the pile's foot may be its mirror image's, or the other way"
    " round: name it by --baseline"
)
UNLIKELY = 0.05  # what has so little probability is no second explanation
MOST_BOW_DEG = 30.0  # of a camera above the plate
LEAST_SEEDS = 8.0  # along the foot, whose errors are independent
TAILS = 3.0  # degrees of freedom of what is off the foot
ROUNDS = 30  # until weights and line agree


def find_base_line(
    edges: Edges,
    shape: tuple[int, ...],
    stated: BaseLine | None,
    camera: Camera,
    with_plate: bool,
) -> BaseLine | None:
    """The line that the pile stands on, by the first method of BASES that finds one;
    None where none does. with_plate: the edges may be those of the plate, too.

    given: stated; plate: the surface beside the pile; foot: the pile's lower edge;
    mirror: half-way between the surface and its mirror image; toe: as level as is
    believed. A line that contradicts the stated plumb (a shelf's edge, a pattern) is
    taken only where none agrees with it; a stated one is doubtful where the plate
    contradicts it."""
    foot = foot_line(edges, camera, shape[0])
    seen = [] if foot is None or foot.source == "toe" else [foot]
    if with_plate and (plate := _plate_line(edges)) is not None:
        seen.insert(0, _beside_plumb(plate, camera))
    if stated is not None:
        bow_deg = 0.0 if foot is None else foot.pitch_deg
        found: BaseLine | None = replace(_beside_seen(stated, seen), pitch_deg=bow_deg)
    elif seen or not with_plate:
        found = min(seen, key=lambda line: bool(line.doubt), default=foot)
    else:
        found = _lowest_place(edges, camera)
    if found is None or camera.pitch_deg is None:
        return found
    return replace(found, pitch_deg=max(camera.pitch_deg, 0.0))


def _lowest_place(edges: Edges, camera: Camera) -> BaseLine:
    """A line as level as is believed through the surface's lowest place."""
    slope, sd = np.tan(np.radians(camera.plumb_deg or 0.0)), camera.plumb_sd
    rows = edges.top - slope * np.arange(edges.top.size)
    lowest = float(np.nanpercentile(rows, 99.5))
    return BaseLine(lowest, slope, np.radians(sd), "toe", LEVEL_SD * edges.factor)


def stated_base_line(
    baseline: Segment | None, shape: tuple[int, ...], roi: tuple[int, int, int, int]
) -> BaseLine | None:
    """The base line as stated in px of the whole picture, converted to px of the roi;
    None where none is stated."""
    if baseline is None:
        return None
    x1, y1, x2, y2 = baseline
    require(
        x1 != x2 and -shape[0] < (y1 + y2) / 2 - roi[1] < 2 * shape[0],
        f"--baseline {x1:g},{y1:g},{x2:g},{y2:g} does not lie in the picture",
    )
    slope = (y2 - y1) / (x2 - x1)
    intercept = y1 - roi[1] - slope * (x1 - roi[0])
    slope_sd = np.hypot(1, 1) / abs(x2 - x1)  # each end is set to a pixel
    return BaseLine(intercept, slope, slope_sd, "given", GIVEN_SD_PX)


def _beside_seen(given: BaseLine, seen: Iterable[BaseLine]) -> BaseLine:
    """A stated base line, doubtful where the plate that is seen lies at an angle to
    it."""
    for line in (line for line in seen if line.source in SEEN):
        angles = np.degrees(np.arctan([given.slope, line.slope]))
        sd = np.degrees(np.hypot(given.slope_sd, line.slope_sd))
        off = float(angles[1] - angles[0])
        if abs(off) > MOST_OFF_DEG + 3 * sd:
            why = tr(
                "the stated base line is {:.1f}° off the plate in the picture", abs(off)
            )
            return replace(given, doubt=why)
    return given


def _beside_plumb(base: BaseLine, camera: Camera) -> BaseLine:
    """A line that is seen, doubtful where it is not level by the stated plumb: one is,
    and one of both is wrong."""
    if camera.plumb_deg is None or base.source == "toe":
        return base
    off = float(np.degrees(np.arctan(base.slope))) - camera.plumb_deg
    sd = np.hypot(np.degrees(base.slope_sd), camera.plumb_sd)
    if abs(off) <= max(MOST_TILT_DEG, 3 * sd):
        return base
    why = tr(
        "the plate in the picture is {:.1f}° off level by plumb_deg as stated: one of"
        " both is wrong",
        abs(off),
    )
    return replace(base, doubt="; ".join(filter(None, (base.doubt, why))))


def _plate_line(edges: Edges) -> BaseLine | None:
    """The plate beside the pile; None where it is not seen."""
    line = _level_line(edges.top, edges.factor)
    if line is None or _runs_over_seed_tops(edges.top, line, edges.factor):
        return None
    sd = LEVEL_SD * edges.factor
    return BaseLine(line.intercept, line.slope, line.slope_sd, "plate", sd)


def _level_line(profile: np.ndarray, factor: float) -> Line | None:
    """The nearly level line through most of the profile's points, a twelfth and more,
    with few of the others below it; None where there is none."""
    tolerance, step = 1.0 + 0.5 * factor, max(1, int(factor))
    x = np.flatnonzero(np.isfinite(profile)).astype(float)
    y, best = profile[np.isfinite(profile)], (0, 0.0, 0.0)
    if y.size < LEAST_ON_PLATE * profile.size:
        return None
    for slope in np.linspace(-MAX_PLATE_SLOPE, MAX_PLATE_SLOPE, 61):
        rows = np.sort((y - slope * x)[::step])
        last = np.searchsorted(rows, rows + 2 * tolerance, side="right")
        count = last - np.arange(rows.size)
        lowest = float(rows[count.argmax()] + tolerance)
        best = max(best, (int(count.max()) * step, float(slope), lowest))
    on = np.abs(y - best[1] * x - best[2]) <= tolerance
    for _ in range(5):  # the first, wide tolerance includes what leans on the plate
        if on.sum() < max(LEAST_COLUMNS, LEAST_ON_PLATE * profile.size / 2):
            return None
        line = fit_line(x[on], y[on], floor=EDGE_FLOOR_PX)
        off = y - line.at(x)
        on = np.abs(off) <= min(tolerance, max(4 * robust_sd(off[on]), 0.3))
    rest = off[np.abs(off) > tolerance]
    tilted = abs(line.slope) > MAX_PLATE_SLOPE
    bent = np.degrees(line.slope_high - line.slope_low) > 1.5
    toe = line.cubic_share > 0.5 and bent  # of a slope, no plate
    below = (rest > 0).sum() > MOST_BELOW * rest.size
    return None if tilted or below or toe else line


def _runs_over_seed_tops(surface: np.ndarray, line: Line, factor: float) -> bool:
    """Whether a line runs over seeds that lie on the plate, one layer deep: between
    them the surface is deeper than the line, that of a plate is not."""
    depth = surface - line.at(np.arange(surface.size))
    on = np.flatnonzero(np.abs(depth) <= 3.0)
    if not on.size:
        return False
    within = depth[on[0] : on[-1] + 1]
    between = np.nanmean(within > LEAST_DEPTH_PX * factor)
    gaps = np.mean(within > max(4.0, -0.05 * np.nanmin(depth)))
    return bool(between > MOST_BETWEEN or gaps > MOST_GAPS)


def in_reduced_px(base: BaseLine, factor: float) -> BaseLine:
    """The base line in px of a picture reduced by `factor`: (y + ½)/f − ½ over (x +
    ½)/f − ½."""
    intercept = (base.at(0.5 * factor - 0.5) + 0.5) / factor - 0.5
    return replace(base, intercept=float(intercept), sd=base.sd / factor)


def find_horizontal(
    base: BaseLine, camera: Camera
) -> tuple[float, float, tuple[str, ...]]:
    """Inclination of the true horizontal in the picture [deg, clockwise], its sd, and
    doubts about it."""
    if camera.plumb_deg is not None:
        return camera.plumb_deg, camera.plumb_sd, ()
    if base.source == "toe":
        why = tr(
            "no plate line and no plumb_deg: the picture's rows are taken as level"
        )
        return 0.0, camera.plumb_sd, (f"{why}, ± {camera.plumb_sd:g}°",)
    angle = np.arctan(base.slope)
    return (
        float(np.degrees(angle)),
        float(np.degrees(base.slope_sd * np.cos(angle) ** 2)),
        (),
    )


def foot_line(edges: Edges, camera: Camera, height: int) -> BaseLine | None:
    """The line that a heap stands on in a picture `height` px high, by its edges; None
    where there is none."""
    top, bottom, sd = edges.top, edges.bottom, LEVEL_SD * edges.factor
    x = np.flatnonzero(np.isfinite(top) & np.isfinite(bottom))
    foot = _foot(x, top[x], bottom[x], camera, sd)
    if foot is None:
        return None
    # what goes on beyond the picture shows no foot
    cut = (bottom[x] >= height - 1.0).mean() > 0.5
    source = "toe" if cut else foot.source
    return _beside_plumb(replace(foot, sd=max(foot.sd, sd), source=source), camera)


def _foot(
    x: np.ndarray, top: np.ndarray, bottom: np.ndarray, camera: Camera, least: float
) -> BaseLine | None:
    """The line that a body stands on by its edges' rows in the columns x; least: sd of
    an edge.

    The lower edge is straight (a camera level with the plate), the near half of an
    ellipse (one that looks down on a round heap, or on half of one that leans on a
    wall), or the upper one's mirror image (a plate that shines): each is fitted, and
    they are weighed by how likely they make the edge. What the others say of the line's
    height is in its sd; which way is level is not told by an edge that narrows what is
    known of it by less than a third."""
    if x.size < 2 * LEAST_SEEDS:
        return None
    left, right = x[[0, -1]]
    middle, half_way = (left + right) / 2, (top + bottom) / 2
    # a plate need not be level where the camera is
    tilt_sd = np.radians(max(camera.plumb_sd, unstated_sd("plumb")))
    tilt = np.tan(np.radians(camera.plumb_deg or 0.0)), tilt_sd
    fits = [
        _fit_edge(x, half_way, 2.0, middle, False, tilt, least),
        _fit_edge(x, bottom, 1.0, middle, False, tilt, least),
        *(
            _fit_edge(x, bottom, 1.0, m, True, tilt, least)
            for m in (middle, left, right)
        ),
    ]
    lines, evidence = zip(*fits)
    likely = np.exp(np.array(evidence) - max(evidence))
    likely /= likely.sum()
    best = lines[int(likely.argmax())]
    if abs(best.slope) > MAX_PLATE_SLOPE or best.pitch_deg > MOST_BOW_DEG:
        return None
    apart = [line.at(middle) - best.at(middle) for line in lines]
    told = best.slope_sd < NARROWED * tilt[1]
    return replace(
        best,
        source=("mirror" if best is lines[0] else "foot") if told else "toe",
        sd=float(np.hypot(2 * best.sd, np.sqrt(likely @ np.square(apart)))),
        doubt=tr(MIRRORED) if UNLIKELY < likely[0] < 1 - UNLIKELY else "",
    )


def _fit_edge(
    x: np.ndarray,
    y: np.ndarray,
    times: float,
    middle: float,
    bowed: bool,
    tilt: tuple[float, float],
    least: float,
) -> tuple[BaseLine, float]:
    """The most likely line by Student's t, whose tails hold what is no foot (a seed
    beside it, a rounded corner). y is the edge but for its place, `times` less far off;
    tilt: slope as believed, and its sd. A bowed edge is intercept + slope x + bow ·
    half √(1 − u²), where u is the distance from the middle over half the width: a
    camera looks down by LOOKS_DOWN_DEG or so, whose sine is the bow. Also the logarithm
    of how likely the line, whose sd is that of what is off it, makes the edge."""
    half = float(np.abs(x - middle).max())
    u = (x - middle) / half
    design = np.c_[np.ones(x.size), half * u, bowed * half * np.sqrt(1 - u**2)]
    prior = np.array([np.median(y), tilt[0], 0.0])
    sds = np.array([y.size, tilt[1], np.sin(np.radians(LOOKS_DOWN_DEG))])
    terms, scale = prior, max(robust_sd(y - np.median(y)), 1.0)
    for _ in range(ROUNDS):
        off = y - design @ terms
        weight = (TAILS + 1) / (TAILS + (off / scale) ** 2)
        scale = max(float(np.sqrt(np.mean(weight * off**2))), least / times)
        counts = LEAST_SEEDS / y.size / scale**2  # neighbouring columns show one seed
        precision = counts * (design.T * weight) @ design + np.diag(sds**-2.0)
        right = counts * (design.T * weight) @ y + prior / sds**2
        terms = np.linalg.solve(precision, right)
        if terms[2] < 0:
            terms = np.r_[np.linalg.solve(precision[:2, :2], right[:2]), 0.0]
    tails = np.log1p((off / scale) ** 2 / TAILS).mean() * (TAILS + 1) / 2
    surprise = np.square((terms - prior)[1:] / sds[1:]).sum() / 2
    width = np.linalg.slogdet(precision * np.outer(sds, sds))[1] / 2
    slope_sd = float(np.sqrt(np.linalg.inv(precision)[1, 1]))
    pitch_deg = float(np.degrees(np.arcsin(min(terms[2], 1.0))))
    level, slope = float(terms[0] - terms[1] * middle), float(terms[1])
    evidence = -LEAST_SEEDS * (np.log(times * scale) + tails) - surprise - width
    return BaseLine(level, slope, slope_sd, "", scale, pitch_deg), float(evidence)
