"""The one number that stands on a recording's card: from the last run of `measure`
where that is newer than the recording, else measured."""

import math
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

import pandas as pd

from benchtwin.measure.batch import split_photos
from benchtwin.page.measuring import measure_recording, shorten_paths
from benchtwin.page.results import MEASURED
from benchtwin.page.upload import brought_as
from benchtwin.vision.measurement import (
    DOUBTFUL,
    FAILED,
    GOOD,
    Observation,
    Quantity,
)
from benchtwin.vision.recording import Recording
from benchtwin.vision.summary import summarise
from benchtwin.vision.terminal import MAIN_QUANTITIES

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
    """Changes whenever a file changes that the number depends on."""
    files = (*recording.files, *_stated(recording))
    return (
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
        reason = next((q.reason for q in every if q.reason), "nothing was measured")
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
    between = " and " if len(files) == 2 else " to "
    return f"{files[0].name}{between}{files[-1].name}"


def _stated(recording: Recording) -> tuple[Path, Path]:
    return recording.toml, recording.toml.parent.parent / "bench.toml"
