"""Measures a recording for the page: with and without corrections by hand, what is
drawn over its picture, and the one number that stands on its card."""

import math
import re
from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path

import numpy as np
import pandas as pd

from benchtwin.bench.language import spoken, tr
from benchtwin.measure.batch import split_photos
from benchtwin.measure.observe import Progress, observe, observe_or_fail
from benchtwin.page.folder import MEASURED
from benchtwin.page.pictures import photo
from benchtwin.page.upload import brought_as
from benchtwin.vision.board.camera import with_board
from benchtwin.vision.measurement import (
    DOUBTFUL,
    FAILED,
    GOOD,
    MeasurementError,
    Observation,
    Quantity,
)
from benchtwin.vision.pile.heap_region import Region, find_region
from benchtwin.vision.pile.repose import (
    PileOptions,
    Repose,
    measure_repose,
    rig_options,
)
from benchtwin.vision.recording import Recording
from benchtwin.vision.summary import summarise
from benchtwin.vision.terminal import MAIN_QUANTITIES

MOST_POINTS = 900  # of a drawn surface
KEPT_REGIONS = 12
# the seeds in a photo stay where they are when a base line is dragged
_regions: dict[tuple, Region | None] = {}


@dataclass(frozen=True)
class PileOverlay:
    """A pile as drawn, in px of the whole picture: polylines by name, and the numbers.
    trouble: why there are none."""

    surface: list[list[float]] = field(default_factory=list)
    base: list[float] | None = None
    roi: list[int] | None = None
    window: list[float] = field(default_factory=lambda: [20.0, 80.0])
    crest: list[float] | None = None
    lines: list[list[float]] = field(default_factory=list)
    quantities: tuple[Quantity, ...] = ()
    notes: tuple[str, ...] = ()
    trouble: str = ""


def measure_pile(recording: Recording, options: PileOptions) -> PileOverlay:
    """Measure the recording's first photo with these options."""
    file = recording.files[0]
    changed = file.stat().st_mtime_ns

    def find(cut: np.ndarray) -> Region | None:
        key = (file, changed, options.roi)
        if key not in _regions:
            if len(_regions) >= KEPT_REGIONS:
                _regions.pop(next(iter(_regions)), None)
            _regions[key] = find_region(cut)
        return _regions[key]

    try:
        image = photo(file, changed)
        seen = with_board(recording, image)
        camera = seen.recording.camera
        found = measure_repose(seen.picture, camera, options, find=find)
        return _overlay(found, image)
    except (MeasurementError, OSError, MemoryError) as error:
        return PileOverlay(
            roi=list(options.roi) if options.roi else None,
            base=list(options.baseline) if options.baseline else None,
            window=[100 * w for w in options.window],
            trouble=str(error),
        )


def automatic_options(recording: Recording) -> PileOptions:
    """How the photo is read when nobody corrects: only what the rig itself says."""
    return rig_options(recording, PileOptions())


def corrected_options(recording: Recording) -> PileOptions:
    """The same with the corrections that recording.toml holds."""
    pile, options = recording.pile, automatic_options(recording)
    window = (
        tuple(w / 100 for w in pile.window_pct) if pile.window_pct else options.window
    )
    return replace(
        options,
        roi=pile.roi_px,
        baseline=pile.baseline_px,
        window=(window[0], window[1]),
    )


def measure_recording(
    recording: Recording, progress: Progress | None = None
) -> Observation:
    """Measure whatever it is; what cannot be measured says why. progress: called with
    the fraction done."""
    return observe_or_fail(recording, partial(observe, progress=progress))


def reasons(
    quantities: Iterable[Quantity], notes: Iterable[str], trouble: str = ""
) -> list[str]:
    """Why something is doubtful or failed, each once; paths of files shortened to their
    names."""
    texts = [trouble, *(q.reason for q in quantities), *notes]
    return [shorten_paths(text) for text in dict.fromkeys(filter(None, texts))]


def shorten_paths(text: str) -> str:
    """A message with the names of files in the place of their paths.

    >>> shorten_paths(
    ...     "/home/me/soy/drop-01/recording.toml: [drop] height_mm is missing"
    ... )
    'recording.toml: [drop] height_mm is missing'
    """
    return re.sub(r"(?:/[^\s:/]+)+/(?=[^\s:/]+)", "", text)


def _overlay(found: Repose, image: np.ndarray) -> PileOverlay:
    x0, y0, width, height = found.roi
    columns = np.flatnonzero(np.isfinite(found.surface))
    columns = columns[:: max(1, len(columns) // MOST_POINTS)]
    surface = [[float(c + x0), float(found.surface[c] + y0)] for c in columns]
    base = [
        float(x0),
        float(found.base.at(0) + y0),
        float(x0 + width - 1),
        float(found.base.at(width - 1) + y0),
    ]
    lines = [
        [c for x in (s.line.x_low, s.line.x_high) for c in (x + x0, s.line.at(x) + y0)]
        for s in found.slopes
    ]
    whole = (width, height) == (image.shape[1], image.shape[0])
    return PileOverlay(
        surface,
        base,
        None if whole else [int(v) for v in found.roi],
        [100 * w for w in found.window],
        [float(v) for v in found.crest],
        [[float(v) for v in line] for line in lines],
        found.quantities,
        found.notes,
    )


def ruler(points: list[float], length_mm: float) -> tuple[float, float]:
    """(mm_per_px, its sd) of a length drawn between two points, each placed to a pixel:
    s = L/d, sd = s √2/d."""
    distance = float(np.hypot(points[2] - points[0], points[3] - points[1]))
    if distance < 10 or not 0 < length_mm < 1e5:
        raise MeasurementError(
            tr("draw the ruler over at least 10 px, and say its length in mm")
        )
    scale = length_mm / distance
    return scale, scale * float(np.sqrt(2)) / distance


def plumb(points: list[float]) -> float:
    """Direction of a drawn plumb line, clockwise from straight down [deg], whichever
    end was set first."""
    dx, dy = points[2] - points[0], points[3] - points[1]
    if dy < 0:
        dx, dy = -dx, -dy
    return float(-np.degrees(np.arctan2(dx, dy)))


FILMS, PHOTOS = ("frames", "video"), "photos"
TABLE_NAMES = (".csv",)  # of evidence that has the same name in every folder


@dataclass(frozen=True)
class CardNumber:
    """A recording's main quantity: the mean over its n repeats ± the standard deviation
    of that mean. reason: why it is doubtful or failed."""

    quantity: str
    value: float
    sd: float
    unit: str
    n: int
    quality: str
    reason: str = ""


def version(recording: Recording) -> tuple:
    """Changes whenever a file changes that the number depends on, and with the language
    of its reasons."""
    files = (*recording.files, *_stated(recording))
    return (
        spoken(),
        recording.path,
        *(p.stat().st_mtime_ns if p.exists() else 0 for p in files),
    )


def measured_number(recording: Recording) -> CardNumber:
    """Measure the recording, every photo of it, and take its main number."""
    return main_number(
        recording.rig, [measure_recording(one) for one in split_photos(recording)]
    )


def number_of_last_run(recording: Recording, results: Path) -> CardNumber | None:
    """The main number as the last run of `measure` left it; None where there is none,
    or the recording has changed since. Pictures only: all else is measured in no
    time."""
    table = results / MEASURED / "measurements.csv"
    if recording.evidence not in (*FILMS, PHOTOS) or not table.is_file():
        return None
    changed = max(
        p.stat().st_mtime for p in (*recording.files, *_stated(recording)) if p.exists()
    )
    if table.stat().st_mtime <= changed:
        return None
    try:
        rows = pd.read_csv(table, dtype={"recording": str, "unit": str})
        found = [
            Observation(one.id, recording.rig or "", _quantities(rows, one.id))
            for one in split_photos(recording)
        ]
    except (OSError, ValueError, KeyError):
        return None  # a table that is being written, or is no table
    return (
        main_number(recording.rig, found) if all(o.quantities for o in found) else None
    )


def _quantities(rows: pd.DataFrame, name: str) -> tuple[Quantity, ...]:
    mine = rows[rows["recording"] == name].fillna({"reason": "", "unit": ""})
    return tuple(
        Quantity(r.quantity, r.value, r.sd, r.unit, r.quality, r.reason, r.sd_common)
        for r in mine.itertuples()
    )


def main_number(rig: str | None, found: Iterable[Observation]) -> CardNumber:
    """The first quantity that could be measured of those that `benchtwin measure` calls
    the rig's main ones, over all observations of one recording."""
    found = list(found)
    every = [q for o in found for q in o.quantities]
    lines = {line.quantity: line for line in summarise(found)}
    if not lines:
        reason = next((q.reason for q in every if q.reason), tr("nothing was measured"))
        return CardNumber("", math.nan, math.nan, "", 0, FAILED, shorten_paths(reason))
    wanted = MAIN_QUANTITIES.get(rig or "", ((),))[0]
    line = lines[next((name for name in wanted if name in lines), next(iter(lines)))]
    mine = [q for q in every if q.name == line.quantity]
    doubts = dict.fromkeys(q.reason for q in mine if q.quality != GOOD and q.reason)
    return CardNumber(
        line.quantity,
        line.mean,
        (line.high - line.low) / (2 * 1.96),
        line.unit,
        max(one.n for one in lines.values()),  # a ratio of a mean has its repeats
        DOUBTFUL if line.doubtful or line.not_measured else GOOD,
        shorten_paths("; ".join(doubts)),
    )


def original_name(recording: Recording) -> str:
    """The name under which the file came; for frames the first and the last. "" for a
    table of which nobody knows how it was called."""
    if brought := brought_as(recording):
        return brought
    files = [f for f in recording.files if f.suffix.lower() not in TABLE_NAMES]
    if not files:
        return ""
    if len(files) == 1:
        return files[0].name
    both = tr("{} and {}") if len(files) == 2 else tr("{} to {}")
    return both.format(files[0].name, files[-1].name)


def _stated(recording: Recording) -> tuple[Path, Path]:
    return recording.toml, recording.toml.parent.parent / "bench.toml"
