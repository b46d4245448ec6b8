"""Base line of a pile and the true horizontal: what heights and angles are measured
from.

The foot of a segmented heap is straight for a level camera and the near half of an
ellipse for one that looks down on a round heap. On a shiny plate the base line lies
half-way between the heap and its mirror image."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace

import cv2
import numpy as np

from benchtwin.bench.priors import unstated_sd
from benchtwin.bench.robust import robust_sd
from benchtwin.vision.measurement import MeasurementError
from benchtwin.vision.pile.heap import MAX_PLATE_SLOPE, BaseLine, level_line
from benchtwin.vision.pile.heap_region import Region
from benchtwin.vision.pile.line import EDGE_FLOOR_PX, Line, fit_line
from benchtwin.vision.pile.surface import (
    Background,
    Silhouette,
    denoise,
    in_float,
    in_full_px,
    subpixel_edge,
)
from benchtwin.vision.recording import Camera

Segment = tuple[float, float, float, float]  # x1, y1, x2, y2 [px, y down]
# between the tops of seeds, small px; shares of the columns along a line, above which
# it runs over a layer of seeds: between them; gaps of a twentieth of the heap's height
LEAST_DEPTH_PX, MOST_BETWEEN, MOST_GAPS = 1.5, 0.03, 0.01
LEVEL_SD = 0.5  # small px: of a line read off the picture's edges
GIVEN_SD_PX = 1.0
# off the stated horizontal: a line farther off is taken only where no other is found
MOST_TILT_DEG = 2.0
BASES = (
    "given",
    "plate",
    "edge",
    "foot",
    "mirror",
    "toe",
)  # how the pile's foot was found, best first
SEEN = ("plate", "edge")  # lines of the plate itself
MOST_OFF_DEG = 0.5  # of a line set by hand beside the plate that is seen
# standard errors of a step's mean over the columns, below which it is none
CLEAR_STEP_SDS = 6.0
MOST_SLOPE = np.tan(np.radians(2.0))
# of the heap's height: a larger sag of a leaning heap's foot means that the camera
# looks down
LEANING_SAG = 0.05
# of a foot's half width: a larger sag is no bow (of a camera 30° above the plate)
MOST_SAG = 0.5
LEAST_SEEDS = 8.0  # along the foot, whose errors are independent
MOST_SDS = 3.0  # robust; columns farther off are outliers


def find_base_line(
    crop: np.ndarray,
    background: Background,
    silhouette: Silhouette,
    surface: np.ndarray,
    baseline: Segment | None,
    camera: Camera,
    roi: tuple[int, int, int, int],
) -> BaseLine:
    """The line that the pile stands on, by the first method of BASES that finds one.

    given: stated; plate: the surface beside the pile; edge: the plate's faint edge
    beside the pile; foot: the silhouette's lower edge; mirror: half-way between the
    surface and its mirror image; toe: a level line through the surface's lowest point.
    A line that contradicts the stated plumb (a shelf's edge, a pattern) is taken only
    where none agrees with it; a stated one is doubtful where the plate contradicts
    it."""
    if (given := stated_base_line(baseline, crop.shape, roi)) is not None:
        candidates = _candidate_lines(crop, background, silhouette, surface)
        return beside_seen(given, (c for c in candidates if c.source in SEEN))
    tilted = None
    for line in _candidate_lines(crop, background, silhouette, surface):
        if not _contradicts_plumb(camera, line):
            return line
        tilted = tilted or line
    if tilted is not None:
        return tilted
    slope = np.tan(np.radians(camera.plumb_deg or 0.0))
    x = np.arange(surface.size)
    intercept = float(np.nanpercentile(surface - slope * x, 99.5))
    sd = np.radians(camera.plumb_sd)
    return BaseLine(intercept, slope, sd, "toe", LEVEL_SD * background.factor)


def _candidate_lines(
    crop: np.ndarray,
    background: Background,
    silhouette: Silhouette,
    surface: np.ndarray,
) -> Iterator[BaseLine]:
    """Lines that the pile may stand on, the most reliable first."""
    sd = LEVEL_SD * background.factor
    plate = _line_through(surface, background.factor, share=0.08 * surface.size)
    if plate is not None and not _runs_over_seed_tops(
        surface, *plate[:2], background.factor
    ):
        yield BaseLine(*plate, "plate", sd)
    line = plate_edge(crop, background, silhouette.top)
    if line is not None:
        yield BaseLine(line.intercept, line.slope, line.slope_sd, "edge", sd)
    height = background.small.shape[0]
    lower = np.where(silhouette.bottom < height - 2, silhouette.bottom, -1)
    if (lower >= 0).sum() > 0.5 * (silhouette.bottom >= 0).sum():
        rows = in_full_px(lower, background.factor, crop.shape[1])
        least = silhouette.threshold / 2
        foot = subpixel_edge(crop, rows, background.factor, least, upward=True)
        enough = 0.4 * np.isfinite(foot).sum()
        for rows, source in ((foot, "foot"), ((surface + foot) / 2, "mirror")):
            lowest = _line_through(rows, background.factor, share=enough, below=1.0)
            if lowest is not None:
                yield BaseLine(*lowest, source, sd)


def stated_base_line(
    baseline: Segment | None, shape: tuple[int, ...], roi: tuple[int, int, int, int]
) -> BaseLine | None:
    """The base line as stated in px of the whole picture, converted to px of the roi;
    None where none is stated."""
    if baseline is None:
        return None
    x1, y1, x2, y2 = baseline
    if x1 == x2 or not -shape[0] < (y1 + y2) / 2 - roi[1] < 2 * shape[0]:
        raise MeasurementError(
            f"--baseline {x1:g},{y1:g},{x2:g},{y2:g} does not lie in the picture"
        )
    slope = (y2 - y1) / (x2 - x1)
    intercept = y1 - roi[1] - slope * (x1 - roi[0])
    slope_sd = np.hypot(1, 1) / abs(x2 - x1)  # each end is set to a pixel
    return BaseLine(intercept, slope, slope_sd, "given", GIVEN_SD_PX)


def beside_seen(given: BaseLine, seen: Iterable[BaseLine]) -> BaseLine:
    """A stated base line, doubtful where the plate that is seen lies at an angle to
    it."""
    for line in seen:
        angles = np.degrees(np.arctan([given.slope, line.slope]))
        sd = np.degrees(np.hypot(given.slope_sd, line.slope_sd))
        off = float(angles[1] - angles[0])
        if abs(off) > MOST_OFF_DEG + 3 * sd:
            why = (
                f"the stated base line is {abs(off):.1f}° off the plate in the picture"
            )
            return replace(given, doubt=why)
    return given


def beside_plumb(base: BaseLine, camera: Camera) -> str:
    """A doubt where the plate that is seen is not level by the stated plumb: one is,
    and one of both is wrong; ""."""
    if camera.plumb_deg is None or base.source not in SEEN:
        return ""
    off = float(np.degrees(np.arctan(base.slope))) - camera.plumb_deg
    sd = np.hypot(np.degrees(base.slope_sd), camera.plumb_sd)
    if abs(off) <= max(MOST_TILT_DEG, 3 * sd):
        return ""
    return (
        f"the plate in the picture is {abs(off):.1f}° off level by plumb_deg as stated:"
        " one of both is wrong"
    )


def _line_through(
    profile: np.ndarray, factor: float, share: float, below: float = 0.15
) -> tuple[float, float, float] | None:
    """Intercept, slope and the slope's sd of a nearly level line through most of the
    profile's points; None where there is none."""
    tolerance = 1.0 + 0.5 * factor
    step = max(1, int(factor))
    found = level_line(profile[::step], tolerance, share / profile.size, below)
    if found is None:
        return None
    intercept, slope = found
    x = np.arange(profile.size)
    slope /= step
    on = np.abs(profile - intercept - slope * x) <= tolerance
    for _ in range(4):  # the first, wide tolerance includes what leans on the plate
        line = fit_line(x[on], profile[on], floor=EDGE_FLOOR_PX)
        off = np.abs(profile - line.at(x))
        on = off <= min(tolerance, max(4 * robust_sd(off[on]), 0.3))
        if on.sum() < max(8, share / 2):
            return None
    if line.cubic_share > 0.5 and np.degrees(line.slope_high - line.slope_low) > 1.5:
        return None  # the toe of a slope, not a plate
    return line.intercept, line.slope, line.slope_sd


def _contradicts_plumb(camera: Camera, line: BaseLine) -> bool:
    """Whether a line is off the stated horizontal by more than MOST_TILT_DEG and its
    error."""
    if camera.plumb_deg is None:
        return False
    sd = np.hypot(np.degrees(line.slope_sd), camera.plumb_sd)
    return bool(
        abs(np.degrees(np.arctan(line.slope)) - camera.plumb_deg)
        > MOST_TILT_DEG + 3 * sd
    )


def _runs_over_seed_tops(
    surface: np.ndarray, intercept: float, slope: float, factor: float
) -> bool:
    """Whether a line runs over seeds that lie on the plate, one layer deep: between
    them the surface is deeper than the line, that of a plate is not."""
    depth = surface - intercept - slope * np.arange(surface.size)
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
        why = "no plate line and no plumb_deg: the picture's rows are taken as level"
        return 0.0, camera.plumb_sd, (f"{why}, ± {camera.plumb_sd:g}°",)
    angle = np.arctan(base.slope)
    return (
        float(np.degrees(angle)),
        float(np.degrees(base.slope_sd * np.cos(angle) ** 2)),
        (),
    )


def plate_edge(
    image: np.ndarray, background: Background, top: np.ndarray
) -> Line | None:
    """The plate's edge beside the pile, as a line in px of the full picture; None where
    there is none.

    top (w,): the silhouette's rows in the small picture, −1 beside the pile. For every
    slope within MAX_PLATE_SLOPE the vertical gradient is averaged over those columns;
    the strongest mean near the pile's lowest visible point is the edge, if it is
    CLEAR_STEP_SDS. It is then refined to sub-pixel rows on the full picture."""
    columns = np.flatnonzero(top < 0)
    columns = columns[(columns > 2) & (columns < top.size - 3)]
    if columns.size < 0.08 * top.size or (top >= 0).sum() < 8:
        return None
    grey = cv2.GaussianBlur(background.distance, (0, 0), 1.0)
    gradient = np.gradient(grey, axis=0)[:, columns]
    foot, reach = int(top.max()), max(12, int(0.15 * (top.max() - top[top >= 0].min())))
    noise = robust_sd(gradient - np.median(gradient)) + 1e-3
    best = (0.0, 0.0, 0.0)
    middle = columns.mean()
    offsets = np.arange(foot - reach, foot + reach + 1)
    for slope in np.linspace(-MAX_PLATE_SLOPE, MAX_PLATE_SLOPE, 81):
        rows = offsets[:, None] + slope * (columns - middle)
        inside = (rows >= 2) & (rows <= grey.shape[0] - 3)
        steps = gradient[
            np.clip(np.rint(rows).astype(int), 0, grey.shape[0] - 1),
            np.arange(columns.size),
        ]
        rows_inside = np.maximum(inside.sum(axis=1), 1)
        mean = np.where(
            inside.mean(axis=1) > 0.8, (steps * inside).sum(axis=1) / rows_inside, 0.0
        )
        at = int(np.abs(mean).argmax())
        # a blot is not a line
        alike = (steps[at] * np.sign(mean[at]) > 0.3 * abs(mean[at]))[inside[at]]
        if abs(mean[at]) > abs(best[0]) and alike.mean() > 0.6:
            best = (float(mean[at]), slope, float(offsets[at]))
    step, slope, row = best
    if abs(step) < max(CLEAR_STEP_SDS * noise / np.sqrt(columns.size), 0.5):
        return None
    return _refine(image, background, columns, slope, row - slope * middle)


def _refine(image, background: Background, columns, slope, intercept) -> Line | None:
    """The line through the gradient's centroid in each full column beside the pile;
    None where that is no straight line."""
    factor, (height, width) = background.factor, image.shape[:2]
    x = np.arange(width)
    x = x[np.isin(((x + 0.5) / factor).astype(int), columns)]
    guess = (intercept + slope * ((x + 0.5) / factor - 0.5) + 0.5) * factor - 0.5
    reach = int(np.ceil(2.5 * factor)) + 3
    rows = np.rint(guess).astype(int) + np.arange(-reach, reach + 1)[:, None]
    fits = (rows.min(axis=0) >= 0) & (rows.max(axis=0) < height)
    x, rows = x[fits], rows[:, fits]
    if x.size < 16:
        return None
    first = rows.min()
    band = denoise(np.ascontiguousarray(image[first : rows.max() + 1]))
    band = np.atleast_3d(band)
    strip = in_float(band[rows - first, x])
    face = (strip[-3:] - strip[:3]).mean(axis=(0, 1))
    level = strip @ (face / max(np.linalg.norm(face), 1e-9))
    rise = np.clip(np.gradient(cv2.blur(level, (1, 3)), axis=0), 0, None) ** 2
    weight = rise.sum(axis=0)
    clear = weight > 0.1 * np.median(weight)
    if clear.sum() < 16:
        return None
    y = (rows * rise).sum(axis=0) / np.maximum(weight, 1e-9)
    line = fit_line(x[clear], y[clear], EDGE_FLOOR_PX)
    return (
        line if line.rms < max(1.0, 0.7 * factor) and line.outlier_share < 0.4 else None
    )


def foot_line(region: Region, mask: np.ndarray, level: float) -> BaseLine | None:
    """The line through the two toes of a heap's mask, in px of the picture; None where
    there is none. level: dy/dx of a level line."""
    columns = np.flatnonzero(mask.any(axis=0))
    if columns.size < 16:
        return None
    top = mask[:, columns].argmax(axis=0).astype(float)
    bottom = mask.shape[0] - 1.0 - mask[::-1, columns].argmax(axis=0)
    middle, half = _ellipse_span(columns, top)
    leaning = middle in (columns[0], columns[-1])
    heap_height = float(np.median(bottom) - top.min())
    foot, source = _fit_foot(columns, bottom, middle, half), "foot"
    mirror = _fit_foot(columns, (top + bottom) / 2, middle, half, bowed=False)
    level_mirror = not leaning or abs(mirror.slope - level) < MOST_SLOPE
    if level_mirror and (2 * mirror.rms < foot.rms or foot.sag > MOST_SAG * half):
        # the lower edge is the upper one's mirror image
        foot, source = mirror, "mirror"
    elif leaning and (
        foot.sag > LEANING_SAG * heap_height or abs(foot.slope - level) > MOST_SLOPE
    ):
        level_foot = _fit_foot(
            columns, bottom - level * columns, middle, half, tilted=False
        )
        sd = np.radians(unstated_sd("plumb"))
        foot, source = replace(level_foot, slope=level, slope_sd=sd), "toe"
    if abs(foot.slope) > MAX_PLATE_SLOPE or foot.sag > MOST_SAG * half:
        return None
    x0, y0 = region.origin
    f = region.factor
    at = (foot.intercept + 1.0) * f - 0.5 + y0  # the lower border of the lowest pixel
    return BaseLine(
        float(at - foot.slope * (0.5 * f - 0.5 + x0)),
        foot.slope,
        foot.slope_sd,
        source,
        f * float(np.hypot(region.start.halo / 2, 2 * foot.rms)),
        float(np.degrees(np.arcsin(min(foot.sag / half, 1.0)))),
    )


def _ellipse_span(columns: np.ndarray, top: np.ndarray) -> tuple[float, float]:
    """Middle and half width of the ellipse whose near half is the foot; a heap that
    leans on a wall shows half of it."""
    left, right = float(columns[0]), float(columns[-1])
    high = columns[top < top.min() + 0.1 * np.ptp(top)]
    crest = float((np.median(high) - left) / (right - left))
    if min(crest, 1 - crest) < 0.2:
        return (left if crest < 0.5 else right), right - left
    return (left + right) / 2, (right - left) / 2


@dataclass(frozen=True)
class _Foot:
    """y = intercept + slope x + sag √(1 − u²), in px of the close-up."""

    intercept: float
    slope: float
    sag: float
    slope_sd: float
    rms: float


def _fit_foot(
    x: np.ndarray,
    y: np.ndarray,
    middle: float,
    half: float,
    tilted: bool = True,
    bowed: bool = True,
) -> _Foot:
    """Least squares without outliers, sag ≥ 0; not tilted, not bowed: without that."""
    bow = bowed * np.sqrt(np.clip(1 - ((x - middle) / max(half, 1.0)) ** 2, 0, None))
    keep = np.ones(x.size, dtype=bool)
    for _ in range(6):
        terms = np.c_[np.ones(x.size), (x - middle) * tilted, bow]
        found = np.linalg.lstsq(terms[keep], y[keep], rcond=None)[0]
        if found[2] < 0:
            found = np.r_[np.linalg.lstsq(terms[keep, :2], y[keep], rcond=None)[0], 0.0]
        off = np.abs(y - terms @ found)
        inliers = off <= MOST_SDS * max(robust_sd(off[keep]), 0.7)
        if (inliers == keep).all() or inliers.sum() < 0.4 * x.size:
            break
        keep = inliers
    rms = float(np.sqrt(np.mean(off[keep] ** 2)))
    extent = float(np.sqrt(np.sum((x[keep] - x[keep].mean()) ** 2)))
    sd = float(np.sqrt(x.size / LEAST_SEEDS) * max(rms, 0.5) / extent)
    level, slope, sag = (float(v) for v in found)
    return _Foot(level - slope * middle, slope, sag, sd, rms)
