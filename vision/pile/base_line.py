"""Base line of a pile on a smooth background, and the true horizontal: what heights and angles are measured from."""

from collections.abc import Iterator

import numpy as np

from vision.measurement import MeasurementError
from vision.pile.heap import BaseLine, level_line
from vision.pile.line import EDGE_FLOOR_PX, fit_line
from vision.pile.plate_edge import plate_edge
from vision.pile.surface import Background, Silhouette, subpixel_edge
from vision.recording import Camera

Segment = tuple[float, float, float, float]  # x1, y1, x2, y2 [px, y down]
UNKNOWN_PLUMB_SD_DEG = 0.5
MOST_TILT_DEG = 2.0  # off the stated horizontal: a line farther off is taken only where no other is found
BASES = ("given", "plate", "edge", "foot", "mirror", "toe")  # how the pile's foot was found, best first


def find_base_line(
    crop: np.ndarray, background: Background, silhouette: Silhouette, surface: np.ndarray, baseline: Segment | None, camera: Camera,
    roi: tuple[int, int, int, int],
) -> BaseLine:  # fmt: skip
    """The line that the pile stands on, by the first method of BASES that finds one.

    given: stated; plate: the surface beside the pile; edge: the plate's faint edge beside the pile; foot: the silhouette's lower
    edge; mirror: half-way between the surface and its mirror image; toe: a level line through the surface's lowest point.
    A line that contradicts the stated plumb (a shelf's edge, a pattern) is taken only where none agrees with it.
    """
    if (given := stated_base_line(baseline, crop.shape, roi)) is not None:
        return given
    tilted = None
    for line in _candidate_lines(crop, background, silhouette, surface):
        if not _contradicts_plumb(camera, line):
            return line
        tilted = tilted or line
    if tilted is not None:
        return tilted
    slope = np.tan(np.radians(camera.plumb_deg or 0.0))
    x = np.arange(surface.size)
    return BaseLine(float(np.nanpercentile(surface - slope * x, 99.5)), slope, np.radians(UNKNOWN_PLUMB_SD_DEG), "toe")


def _candidate_lines(crop: np.ndarray, background: Background, silhouette: Silhouette, surface: np.ndarray) -> Iterator[BaseLine]:
    """Lines that the pile may stand on, the most reliable first."""
    plate = _line_through(surface, background.factor, share=0.08 * surface.size)
    if plate is not None and not _runs_over_seed_tops(surface, *plate[:2]):
        yield BaseLine(*plate, "plate")
    line = plate_edge(crop, background, silhouette.top, EDGE_FLOOR_PX)
    if line is not None:
        yield BaseLine(line.intercept, line.slope, line.slope_sd, "edge")
    height = background.small.shape[0]
    lower = np.where(silhouette.bottom < height - 2, silhouette.bottom, -1)
    if (lower >= 0).sum() > 0.5 * (silhouette.bottom >= 0).sum():
        foot = subpixel_edge(crop, background, lower, silhouette.threshold, upward=True)
        enough = 0.4 * np.isfinite(foot).sum()
        for rows, source in ((foot, "foot"), ((surface + foot) / 2, "mirror")):
            lowest = _line_through(rows, background.factor, share=enough, below=1.0)
            if lowest is not None:
                yield BaseLine(*lowest, source)


def stated_base_line(baseline: Segment | None, shape: tuple[int, ...], roi: tuple[int, int, int, int]) -> BaseLine | None:
    """The base line as stated in px of the whole picture, converted to px of the roi; None where none is stated."""
    if baseline is None:
        return None
    x1, y1, x2, y2 = baseline
    if x1 == x2 or not -shape[0] < (y1 + y2) / 2 - roi[1] < 2 * shape[0]:
        raise MeasurementError(f"--baseline {x1:g},{y1:g},{x2:g},{y2:g} does not lie in the picture")
    slope = (y2 - y1) / (x2 - x1)
    return BaseLine(y1 - roi[1] - slope * (x1 - roi[0]), slope, np.hypot(1, 1) / abs(x2 - x1), "given")


def _line_through(profile: np.ndarray, factor: float, share: float, below: float = 0.15) -> tuple[float, float, float] | None:
    """Intercept, slope and the slope's sd of a nearly level line through most of the profile's points; None where there is none."""
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
        on = off <= min(tolerance, max(4 * 1.4826 * float(np.median(off[on])), 0.3))
        if on.sum() < max(8, share / 2):
            return None
    if line.cubic_share > 0.5 and np.degrees(line.slope_high - line.slope_low) > 1.5:
        return None  # the toe of a slope, not a plate
    return line.intercept, line.slope, line.slope_sd


def _contradicts_plumb(camera: Camera, line: BaseLine) -> bool:
    """Whether a line is off the stated horizontal by more than MOST_TILT_DEG and its error."""
    if camera.plumb_deg is None:
        return False
    sd = np.hypot(np.degrees(line.slope_sd), camera.plumb_sd)
    return bool(abs(np.degrees(np.arctan(line.slope)) - camera.plumb_deg) > MOST_TILT_DEG + 3 * sd)


def _runs_over_seed_tops(surface: np.ndarray, intercept: float, slope: float) -> bool:
    """Whether a line runs over the tops of seeds that cover the plate, not over the plate.

    Then more than 1 % of the columns along it lie deeper than it by a twentieth of the crest's height.
    """
    depth = surface - intercept - slope * np.arange(surface.size)
    on = np.flatnonzero(np.abs(depth) <= 3.0)
    if not on.size:
        return False
    within = depth[on[0] : on[-1] + 1]
    return float(np.mean(within > max(4.0, -0.05 * np.nanmin(depth)))) > 0.01


def in_reduced_px(base: BaseLine, factor: float) -> BaseLine:
    """The base line in px of a picture reduced by `factor`: (y + ½)/f − ½ over (x + ½)/f − ½."""
    intercept = (base.at(0.5 * factor - 0.5) + 0.5) / factor - 0.5
    return BaseLine(float(intercept), base.slope, base.slope_sd, base.source)


def find_horizontal(base: BaseLine, camera: Camera) -> tuple[float, float, tuple[str, ...]]:
    """Inclination of the true horizontal in the picture [deg, clockwise], its sd, and doubts about it."""
    if camera.plumb_deg is not None:
        return camera.plumb_deg, camera.plumb_sd, ()
    if base.source == "toe":
        return 0.0, UNKNOWN_PLUMB_SD_DEG, ("no plate line and no plumb_deg: the picture's rows are taken as level, ± 0.5°",)
    angle = np.arctan(base.slope)
    return float(np.degrees(angle)), float(np.degrees(base.slope_sd * np.cos(angle) ** 2)), ()
