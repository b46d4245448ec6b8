"""Drum rig: film of a rotating drum → dynamic angle of repose, the inclination of the
flowing surface.

The grey of a pixel that seeds pass varies over a stretch of the film, that of the empty
drum does not. The upper edge of the varying pixels is the mean surface of that stretch;
a least-squares line is fitted to the middle of it."""

from collections.abc import Callable

import cv2
import numpy as np
from scipy import ndimage

from benchtwin.bench.distributions import t as student
from benchtwin.bench.language import tr
from benchtwin.vision.evidence.frames import FrameSource, open_frames
from benchtwin.vision.measurement import GOOD, MeasurementError, Observation, Quantity
from benchtwin.vision.overlay.canvas import GREEN, RED, WHITE, YELLOW, Canvas
from benchtwin.vision.pile.line import EDGE_FLOOR_PX, Line, fit_line
from benchtwin.vision.pile.surface import binarise, shrink
from benchtwin.vision.recording import Recording

# of the surface from wall to wall, along the horizontal: between these the line is
# fitted
WINDOW = (0.25, 0.75)
LONGEST_PX = 800
STRETCHES, LEAST_FRAMES = (4, 10), 6  # of a film; of a stretch
SEPARABLE = 0.7  # least separability η (Otsu) of the flicker; noise alone gives 0.64
LEAST_FLICKER = 0.1  # levels of 255; less counts as none
CLEAR = 4.0  # times the empty drum's flicker
# the flow is not steady where the halves differ by more than chance and avalanches
# explain
STEADY_P, STEADY_DEG = (0.003, 2.0)
# differences of the surface's slope in the window, above which a line is the wrong
# model
BENT_DEG = 15.0


def observe_drum(
    recording: Recording,
    options: object = None,
    progress: Callable[[float], None] | None = None,
) -> Observation:
    """Measure flowing_angle [deg] on frames or a video. MeasurementError where nothing
    flows, or the film is too short. options: of piles, not used."""
    if recording.evidence not in ("frames", "video"):
        raise MeasurementError(
            tr(
                "{}: a drum is measured on frames or a video, not on {}",
                recording.path,
                recording.evidence,
            )
        )
    source = open_frames(recording)
    stretches, first = _flicker(source, progress)
    surfaces = _surfaces(recording, stretches)
    lines = [_line(surface) for surface in surfaces]
    found = [line for line in lines if line is not None]
    if len(found) < STRETCHES[0]:
        none = tr("{} of {} stretches", len(lines) - len(found), len(lines))
        raise MeasurementError(
            tr(
                "{}: no surface from wall to wall was found in {} of the film",
                recording.path,
                none,
            )
        )
    level, level_sd, notes = _horizontal(recording)
    angles = np.array([line.angle_deg - level for line in found])
    sd = float(
        student.ppf(0.975, len(angles) - 1)
        / 1.96
        * angles.std(ddof=1)
        / np.sqrt(len(angles))
    )
    sd = float(np.hypot(sd, level_sd))
    value = Quantity(
        "flowing_angle", abs(float(angles.mean())), sd, "deg", sd_common=level_sd
    )
    value = value.doubt(*_doubts(angles, found))
    seen = np.isfinite(surfaces)
    total, count = np.where(seen, surfaces, 0.0).sum(axis=0), seen.sum(axis=0)
    mean = np.where(count > 0, total / np.maximum(count, 1), np.nan)
    picture = _overlay(first, mean, found, value)
    share = f"{100 * (WINDOW[1] - WINDOW[0]):.0f} %"
    notes += [
        (
            tr(
                "line through the middle {} of the surface; {} stretches of the film",
                share,
                len(found),
            )
        ),
        *source.notes,
    ]
    return Observation(recording.id, "drum", (value,), tuple(notes), {"drum": picture})


def _flicker(
    source: FrameSource, progress: Callable[[float], None] | None
) -> tuple[np.ndarray, np.ndarray]:
    """sd of each pixel's grey in each stretch of the film, (stretches, h, w), reduced;
    and the first frame."""
    count = source.count
    stretches = min(STRETCHES[1], count // LEAST_FRAMES)
    if stretches < STRETCHES[0]:
        raise MeasurementError(
            tr(
                "{}: {} frames; a drum needs {} at least",
                source.path,
                count,
                STRETCHES[0] * LEAST_FRAMES,
            )
        )
    sums = squares = first = None
    taken = np.zeros(stretches)
    for number, frame in enumerate(source.iterate()):
        grey = cv2.GaussianBlur(
            shrink(frame.pixels, LONGEST_PX)[0].mean(axis=2), (0, 0), 1.0
        )
        if sums is None or squares is None or first is None:
            first = frame.pixels
            sums = np.zeros((stretches, *grey.shape), np.float32)
            squares = np.zeros((stretches, *grey.shape), np.float32)
        if grey.shape != sums.shape[1:]:
            raise MeasurementError(
                tr(
                    "{}: frame {} is of another size than the first",
                    source.path,
                    frame.index,
                )
            )
        k = min(number * stretches // count, stretches - 1)
        sums[k] += grey
        squares[k] += grey**2
        taken[k] += 1
        if progress:
            progress(min(number / count, 1.0))
    if (
        first is None
        or sums is None
        or squares is None
        or (taken < LEAST_FRAMES - 1).any()
    ):
        raise MeasurementError(
            tr(
                "{}: {} of {} frames could be read",
                source.path,
                int(taken.sum()),
                count,
            )
        )
    each = taken[:, None, None]
    return np.sqrt(np.maximum(squares / each - (sums / each) ** 2, 0.0)), first


def _surfaces(recording: Recording, flicker: np.ndarray) -> np.ndarray:
    """Row of the upper edge of the flickering pixels in each column, NaN where there is
    none, (stretches, w), reduced."""
    whole = np.sqrt((flicker**2).mean(axis=0))
    # logarithm: the surface flickers more than the seeds below it
    level, separable = binarise(np.log(np.maximum(whole, LEAST_FLICKER)))
    threshold = float(np.exp(level))
    if separable < SEPARABLE or whole.max() < CLEAR * np.median(
        whole[whole <= threshold]
    ):
        raise MeasurementError(
            tr(
                "{}: nothing is seen to flow; the camera must stand still and look"
                " along the drum's axis",
                recording.path,
            )
        )
    grain = max(3, round(0.012 * max(whole.shape))) | 1
    core = _largest(whole > threshold, grain)
    surfaces = []
    for each in flicker:
        mask = _largest(
            (each > threshold) & ndimage.binary_dilation(core, iterations=2 * grain),
            grain,
        )
        rows = np.where(mask.any(axis=0), mask.argmax(axis=0).astype(float), np.nan)
        surfaces.append(rows)
    return np.array(surfaces)


def _largest(mask: np.ndarray, grain: int) -> np.ndarray:
    """The largest connected part after closing and opening by the size of a grain."""
    kernel = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (grain, grain))
    closed = cv2.morphologyEx(mask.astype(np.uint8), cv2.MORPH_CLOSE, kernel)
    opened = cv2.morphologyEx(closed, cv2.MORPH_OPEN, kernel)
    count, labels, stats, _ = cv2.connectedComponentsWithStats(opened)
    if count < 2:
        return np.zeros(mask.shape, bool)
    return labels == 1 + int(stats[1:, cv2.CC_STAT_AREA].argmax())


def _line(surface: np.ndarray) -> Line | None:
    columns = np.flatnonzero(np.isfinite(surface))
    if len(columns) < 40:
        return None
    first, wide = columns[0], columns[-1] - columns[0]
    inside = columns[
        (columns >= first + WINDOW[0] * wide) & (columns <= first + WINDOW[1] * wide)
    ]
    return fit_line(inside, surface[inside], floor=EDGE_FLOOR_PX)


def _horizontal(recording: Recording) -> tuple[float, float, list[str]]:
    """Direction of the horizontal in the picture [deg], its sd, and notes."""
    plumb, sd = recording.camera.plumb_deg, recording.camera.plumb_sd
    if plumb is not None:
        return plumb, sd, []
    return (
        0.0,
        sd,
        [tr("[camera] plumb_deg is missing: the camera is level to ± {:g}°", sd)],
    )


def _doubts(angles: np.ndarray, lines: list[Line]):
    half = len(angles) // 2
    early, late = angles[:half], angles[half:]
    apart = abs(early.mean() - late.mean()) / np.hypot(
        early.std(ddof=1) / np.sqrt(len(early)), late.std(ddof=1) / np.sqrt(len(late))
    )
    if (
        apart > student.ppf(1 - STEADY_P / 2, len(angles) - 2)
        and abs(early.mean() - late.mean()) > STEADY_DEG
    ):
        yield (
            tr(
                "the angle goes on changing ({:.1f}°, then {:.1f}°): no steady flow"
                " yet",
                abs(early.mean()),
                abs(late.mean()),
            )
        )
    ends = [(line.slope_low, line.slope_high) for line in lines]
    bend = np.mean([np.degrees(np.arctan(b) - np.arctan(a)) for a, b in ends])
    if bend > BENT_DEG:
        yield (
            tr(
                "the surface is bent (its slope differs by {:.0f}° within the window):"
                " one line is the wrong model",
                bend,
            )
        )


def _overlay(
    first: np.ndarray, surface: np.ndarray, lines: list[Line], value: Quantity
) -> np.ndarray:
    """Mean surface green, the line of each stretch yellow, their mean red."""
    canvas = Canvas(first)
    factor = max(1.0, max(first.shape[:2]) / LONGEST_PX)
    canvas.curve(np.arange(len(surface)) * factor, surface * factor, GREEN, 1.5)
    for line in lines:
        x = np.array([line.x_low, line.x_high])
        canvas.curve(factor * x, factor * line.at(x), YELLOW, 0.5)
    slope = np.mean([line.slope for line in lines])
    x = np.array([lines[0].x_low, lines[0].x_high])
    middle = np.mean([line.at(x.mean()) for line in lines])
    canvas.curve(factor * x, factor * (middle + slope * (x - x.mean())), RED, 2.5)
    colour = WHITE if value.quality == GOOD else YELLOW
    legend = [(f"{value.in_words}  {value.quality}", colour)]
    canvas.legend([*legend, (value.reason, YELLOW)] if value.reason else legend)
    return canvas.pixels
