"""The pile's foot and the true horizontal: what angles and heights count from."""

from collections.abc import Iterator

import numpy as np

from vision.measurement import MeasurementError
from vision.pile.boundary import Ground, Silhouette, edge
from vision.pile.heap import BaseLine, level_line
from vision.pile.level import plate_edge
from vision.pile.line import EDGE_FLOOR_PX, fit_line
from vision.recording import Camera

Segment = tuple[float, float, float, float]  # x1, y1, x2, y2 [px, y down]
UNKNOWN_PLUMB_SD_DEG = 0.5
TILT_DEG = 2.0  # that a plate may lie off level before another line is looked for
BASES = ("given", "plate", "edge", "foot", "mirror", "toe")  # how the pile's foot was found, best first


def find_base_line(
    cut: np.ndarray, ground: Ground, silhouette: Silhouette, surface: np.ndarray, baseline: Segment | None, camera: Camera,
    roi: tuple[int, int, int, int],
) -> BaseLine:  # fmt: skip
    """The pile's foot: given; else the plate on either side of it; else the plate's faint edge there; else the pile's lower
    edge; else the middle between it and its mirror image; else a level line through the lowest point of the surface.

    A line that contradicts the stated plumb (a shelf's edge, a pattern, a leaning plate) is taken only where none agrees with it.
    """
    if (given := given_base(baseline, cut.shape, roi)) is not None:
        return given
    leaning = None
    for line in _lines(cut, ground, silhouette, surface):
        if not _leans(camera, line):
            return line
        leaning = leaning or line
    if leaning is not None:
        return leaning
    slope = np.tan(np.radians(camera.plumb_deg or 0.0))
    x = np.arange(surface.size)
    return BaseLine(float(np.nanpercentile(surface - slope * x, 99.5)), slope, np.radians(UNKNOWN_PLUMB_SD_DEG), "toe")


def _lines(cut: np.ndarray, ground: Ground, silhouette: Silhouette, surface: np.ndarray) -> Iterator[BaseLine]:
    """The lines that the pile may stand on, the surest first."""
    plate = _line_through(surface, ground.factor, share=0.08 * surface.size)
    if plate is not None and not _gaps_below(surface, *plate[:2]):
        yield BaseLine(*plate, "plate")
    line = plate_edge(cut, ground, silhouette.top, EDGE_FLOOR_PX)
    if line is not None:
        yield BaseLine(line.intercept, line.slope, line.slope_sd, "edge")
    height = ground.small.shape[0]
    lower = np.where(silhouette.bottom < height - 2, silhouette.bottom, -1)
    if (lower >= 0).sum() > 0.5 * (silhouette.bottom >= 0).sum():
        foot = edge(cut, ground, lower, silhouette.threshold, upward=True)
        enough = 0.4 * np.isfinite(foot).sum()
        for rows, source in ((foot, "foot"), ((surface + foot) / 2, "mirror")):
            lowest = _line_through(rows, ground.factor, share=enough, below=1.0)
            if lowest is not None:
                yield BaseLine(*lowest, source)


def given_base(baseline: Segment | None, shape: tuple[int, ...], roi: tuple[int, int, int, int]) -> BaseLine | None:
    """The base line as stated in px of the whole picture, told in px of the part that is read; None where none is stated."""
    if baseline is None:
        return None
    x1, y1, x2, y2 = baseline
    if x1 == x2 or not -shape[0] < (y1 + y2) / 2 - roi[1] < 2 * shape[0]:
        raise MeasurementError(f"--baseline {x1:g},{y1:g},{x2:g},{y2:g} does not lie in the picture")
    slope = (y2 - y1) / (x2 - x1)
    return BaseLine(y1 - roi[1] - slope * (x1 - roi[0]), slope, np.hypot(1, 1) / abs(x2 - x1), "given")


def _line_through(profile: np.ndarray, factor: float, share: float, below: float = 0.15) -> tuple[float, float, float] | None:
    """A nearly level line most of the profile's points lie on: intercept, slope, sd of the slope."""
    tolerance = 1.0 + 0.5 * factor
    step = max(1, int(factor))
    found = level_line(profile[::step], tolerance, share / profile.size, below)
    if found is None:
        return None
    intercept, slope = found
    x = np.arange(profile.size)
    slope /= step
    on = np.abs(profile - intercept - slope * x) <= tolerance
    for _ in range(4):  # what leans on the plate is drawn in by the first, wide tolerance
        line = fit_line(x[on], profile[on], floor=EDGE_FLOOR_PX)
        off = np.abs(profile - line.at(x))
        on = off <= min(tolerance, max(4 * 1.4826 * float(np.median(off[on])), 0.3))
        if on.sum() < max(8, share / 2):
            return None
    if line.bent > 0.5 and np.degrees(line.slope_high - line.slope_low) > 1.5:
        return None  # a slope running out, not a plate
    return line.intercept, line.slope, line.slope_sd


def _leans(camera: Camera, line: BaseLine) -> bool:
    """Whether a line contradicts the stated plumb by more than plates lie off level."""
    if camera.plumb_deg is None:
        return False
    sd = np.hypot(np.degrees(line.slope_sd), camera.plumb_sd)
    return bool(abs(np.degrees(np.arctan(line.slope)) - camera.plumb_deg) > TILT_DEG + 3 * sd)


def _gaps_below(surface: np.ndarray, intercept: float, slope: float) -> bool:
    """Whether more than 1 % of the columns along a line lie deeper than it by a twentieth of the crest's height: then it
    runs over the tops of seeds that cover the plate, not over the plate."""
    depth = surface - intercept - slope * np.arange(surface.size)
    along = np.flatnonzero(np.abs(depth) <= 3.0)
    if not along.size:
        return False
    within = depth[along[0] : along[-1] + 1]
    return float(np.mean(within > max(4.0, -0.05 * np.nanmin(depth)))) > 0.01


def scaled(base: BaseLine, factor: float) -> BaseLine:
    """The base line in the small picture's px: (y + ½)/f − ½ over (x + ½)/f − ½."""
    intercept = (base.at(0.5 * factor - 0.5) + 0.5) / factor - 0.5
    return BaseLine(float(intercept), base.slope, base.slope_sd, base.source)


def find_horizontal(base: BaseLine, camera: Camera) -> tuple[float, float, tuple[str, ...]]:
    """Inclination of the true horizontal in the picture (deg, clockwise), its sd, and what is to be doubted about it."""
    if camera.plumb_deg is not None:
        return camera.plumb_deg, camera.plumb_sd, ()
    if base.source == "toe":
        return 0.0, UNKNOWN_PLUMB_SD_DEG, ("no plate line and no plumb_deg: the picture's rows are taken as level, ± 0.5°",)
    angle = np.arctan(base.slope)
    return float(np.degrees(angle)), float(np.degrees(base.slope_sd * np.cos(angle) ** 2)), ()
