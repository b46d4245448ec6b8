"""`benchtwin.measure`: recordings → quantities with standard deviations, as tables."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

import pandas as pd

from benchtwin.measure import batch
from benchtwin.measure.observe import LEAST_WINDOW
from benchtwin.twin.campaign.results import Measurement
from benchtwin.vision.measurement import MeasurementError, Observation
from benchtwin.vision.pile.repose import PileOptions
from benchtwin.vision.results import Results
from benchtwin.vision.summary import as_table, summarise

Paths = str | Path | Sequence[str | Path]
QUANTITIES = [
    "recording",
    "rig",
    "quantity",
    "value",
    "sd",
    "sd_common",
    "unit",
    "quality",
    "reason",
]


@dataclass(frozen=True, eq=False)
class Measurements:
    """What was measured on some recordings.

    observations: one a recording, with its track, bounces and readings as tables.
    notes: (recording, note) of what was assumed or left out. folder: where files were
    written, None where none were."""

    observations: tuple[Observation, ...] = field(repr=False)
    notes: tuple[tuple[str, str], ...] = field(default=(), repr=False)
    folder: Path | None = None

    @property
    def quantities(self) -> pd.DataFrame:
        """A row a quantity: recording, rig, quantity, value, sd, sd_common, unit,
        quality, reason; as in measurements.csv.

        value ± 1.96 sd is a 95 % interval. A quantity that could not be measured is
        NaN, and its reason says why."""
        rows = [
            (
                o.recording,
                o.rig,
                q.name,
                q.value,
                q.sd,
                q.sd_common,
                q.unit,
                q.quality,
                q.reason,
            )
            for o in self.observations
            for q in o.quantities
        ]
        return pd.DataFrame(rows, columns=QUANTITIES)

    @property
    def table(self) -> pd.DataFrame:
        """A row a recording: recording, rig, its conditions, and NAME_UNIT and
        NAME_sd_UNIT of each quantity."""
        return pd.DataFrame([_row(observation) for observation in self.observations])

    @property
    def summary(self) -> pd.DataFrame:
        """A row for each bench, rig and quantity: mean over the repeats, its 95 %
        interval, the scatter; as in summary.csv."""
        return as_table(summarise(self.observations))


def measure(
    paths: Paths,
    *,
    out: str | Path | None = None,
    overwrite: bool = False,
    window_pct: tuple[float, float] = (20.0, 80.0),
    region_px: tuple[int, int, int, int] | None = None,
    baseline_px: tuple[float, float, float, float] | None = None,
    trim: bool = False,
) -> Measurements:
    """Measure photos, films, sound and tables: one path or several, each a file, a
    recording or a bench folder.

    out: folder for the files that `benchtwin measure` writes (tables, tracks, pictures
    of what was found), none without it; overwrite: replace results that are there. Of
    piles: window_pct, heights in % of the crest's between which the line is fitted;
    region_px (x, y, width, height), where to look; baseline_px (x1, y1, x2, y2), the
    plate's line, y down. trim: of readings leave out one highest and one lowest.

    A recording that cannot be measured stands in the tables with its reason. Raises
    FileNotFoundError for a path that is not there; MeasurementError for a window below
    a tenth of the crest's height, or where `out` must not be replaced."""
    chosen = [
        Path(path) for path in ([paths] if isinstance(paths, str | Path) else paths)
    ]
    if missing := [path for path in chosen if not path.exists()]:
        raise FileNotFoundError(f"{missing[0]}: no such file or folder")
    options = PileOptions(_fractions(window_pct), region_px, baseline_px)
    results = None if out is None else Results(Path(out), chosen, overwrite)
    unread = batch.unread_notes(chosen, batch.find_all(chosen))
    kept = []
    try:
        for observation in batch.measure(chosen, options, trim):
            if results is not None:
                results.add(observation)
            kept.append(replace(observation, pictures={}))  # megabytes a recording
        if results is not None:
            results.notes += unread
            results.finish()
    finally:
        if results is not None:
            results.abandon()
    notes = (*unread, *((o.recording, note) for o in kept for note in o.notes))
    return Measurements(tuple(kept), notes, None if out is None else Path(out))


def _fractions(window_pct: tuple[float, float]) -> tuple[float, float]:
    low, high = (share / 100 for share in window_pct)
    if not 0 <= low < high <= 1 or high - low < LEAST_WINDOW:
        raise MeasurementError(
            f"window_pct = {window_pct}: two heights in %, at least 10 apart, such as"
            " (20, 80)"
        )
    return low, high


def _row(observation: Observation) -> dict[str, object]:
    row: dict[str, object] = {
        "recording": observation.recording,
        "rig": observation.rig,
        **observation.conditions,
    }
    for q in observation.quantities:
        named = Measurement(q.name, q.value, q.sd, q.unit)
        row[named.column()], row[named.column("_sd")] = q.value, q.sd
    return row
