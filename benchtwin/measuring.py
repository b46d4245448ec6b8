"""`benchtwin.measure`: recordings → quantities with standard deviations, as tables."""

import os
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
import pandas as pd
from plotly.graph_objects import Figure

from benchtwin import shown
from benchtwin.bench.conditions import MEASURED
from benchtwin.bench.numbers import plus_minus
from benchtwin.blas import on_one_blas_thread
from benchtwin.measure import batch
from benchtwin.measure.observed import Observed, PackedPictures
from benchtwin.report import draw
from benchtwin.rigs.pile.observe import LEAST_WINDOW
from benchtwin.twin.campaign.results import Measurement
from benchtwin.vision.measurement import MeasurementError, Observation
from benchtwin.vision.pile.repose import PileOptions
from benchtwin.vision.results import Results, row_of
from benchtwin.vision.summary import as_table, summarise

Paths = str | Path | Sequence[str | Path]


@dataclass(frozen=True, eq=False)
class Measurements:
    """What was measured on some recordings; `calibrate`, `diagnose` and `audit` take it
    in the place of the bench's folder, and read no recording again.

    observations: one a recording, with its track, bounces and readings as tables, and
    pictures of what was found. notes: (recording, note) of what was assumed or left
    out. folder: where files were written, None where none were. observed: the
    recordings themselves; its fields may change between versions."""

    observations: tuple[Observation, ...] = field(repr=False)
    observed: Observed = field(repr=False)
    notes: tuple[tuple[str, str], ...] = field(default=(), repr=False)
    folder: Path | None = None

    @property
    def quantities(self) -> pd.DataFrame:
        """A row a quantity: recording, rig, quantity, value, sd, sd_common, unit,
        quality, reason; as in measurements.csv.

        value ± 1.96 sd is a 95 % interval. A quantity that could not be measured is
        NaN, and its reason says why."""
        rows = [row_of(o, q) for o in self.observations for q in o.quantities]
        return pd.DataFrame(rows, columns=MEASURED[:-1])

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

    def picture(self, recording: str) -> np.ndarray:
        """What was found, drawn on the recording: (h, w, 3), uint8 RGB. KeyError where
        there is no such recording, or nothing to draw on."""
        for observation in self.observations:
            if observation.recording == recording and observation.pictures:
                return observation.pictures[next(iter(observation.pictures))]
        raise KeyError(f"{recording}: no picture of such a recording")

    def plot(self) -> Figure:
        """A panel a quantity: its value ± 1.96 sd on each recording, coloured by
        quality."""
        table = self.quantities.dropna(subset="value")
        groups = list(table.groupby(["rig", "quantity", "unit"], sort=False))
        titles = [
            f"{rig}: {quantity.replace('_', ' ')}"
            + (f" ({draw.unit(unit)})" if draw.unit(unit) else "")
            for (rig, quantity, unit), _ in groups
        ]
        figure, places = shown.panels(titles)
        for (_, rows), place in zip(groups, places, strict=True):
            colour = [shown.COLOURS[quality] for quality in rows["quality"]]
            reach = 1.96 * rows["sd"].fillna(0.0)
            across, up, text = rows["recording"], rows["value"], rows["reason"]
            trace = shown.points(across, up, reach, colour=colour, text=text)
            figure.add_trace(trace, **place)
        return figure

    def _repr_html_(self) -> str:
        table = self.quantities
        cells = pd.DataFrame(
            {
                "recording": table["recording"],
                "quantity": table["quantity"],
                "value ± sd": [
                    plus_minus(value, sd)
                    for value, sd in zip(table["value"], table["sd"], strict=True)
                ],
                "unit": table["unit"].map(draw.unit),
                "quality": table["quality"],
                "reason": table["reason"],
            }
        )
        return shown.html(f"{len(self.observations)} recordings", cells)


Bench = str | Path | Measurements  # what may be calibrated, diagnosed or audited


def recordings_of(bench: Bench) -> Path | Observed:
    """The recordings of a bench: those measured before, or the folder that holds
    them."""
    return bench.observed if isinstance(bench, Measurements) else Path(bench)


@on_one_blas_thread
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
    entries = tuple(batch.find_all(chosen))
    observed = Observed(_folder_of(chosen), entries, options, trim)
    results = None if out is None else Results(Path(out), chosen, overwrite)
    unread = batch.unread_notes(chosen, list(entries))
    kept = []
    try:
        for observation in batch.measure_each(entries, observed.observe):
            if results is not None:
                results.add(observation)
            kept.append(_packed(observation))
        if results is not None:
            results.notes += unread
            results.finish()
    finally:
        if results is not None:
            results.abandon()
    notes = (*unread, *((o.recording, note) for o in kept for note in o.notes))
    return Measurements(
        tuple(kept), observed, notes, None if out is None else Path(out)
    )


def _packed(observation: Observation) -> Observation:
    """Megabytes a recording become a tenth; those kept by an `Observed` are packed."""
    if isinstance(observation.pictures, PackedPictures):
        return observation
    return replace(observation, pictures=PackedPictures(observation.pictures))


def _folder_of(paths: Sequence[Path]) -> Path:
    """The one path, or the folder that holds all of them."""
    if len(paths) == 1:
        return paths[0]
    return Path(os.path.commonpath([path.resolve() for path in paths] or [Path.cwd()]))


def _fractions(window_pct: tuple[float, float]) -> tuple[float, float]:
    low, high = (share / 100 for share in window_pct)
    if not 0 <= low < high <= 1 or high - low < LEAST_WINDOW:
        raise MeasurementError(
            f"window_pct = {window_pct}: two heights in %, at least 10 apart, such as"
            " (20, 80)"
        )
    return low, high


def _row(observation: Observation) -> dict[str, object]:
    measured: dict[str, object] = {}
    for q in observation.quantities:
        named = Measurement(q.name, q.value, q.sd, q.unit)
        measured[named.column()], measured[named.column("_sd")] = q.value, q.sd
    stated: dict[str, object] = {
        f"condition_{name}" if name in measured else name: value
        for name, value in observation.conditions.items()
    }
    row: dict[str, object] = {
        "recording": observation.recording,
        "rig": observation.rig,
    }
    return row | stated | measured
