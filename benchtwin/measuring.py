"""What `benchtwin.measure` finds: quantities with standard deviations, as tables."""

import os
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path

import numpy as np
import pandas as pd
from plotly.graph_objects import Figure
from rich.progress import BarColumn, Progress, TimeRemainingColumn

from benchtwin import shown
from benchtwin.bench.conditions import MEASURED
from benchtwin.bench.exits import DONE, FAILED, say
from benchtwin.bench.numbers import plus_minus
from benchtwin.bench.terminal import Terminal, Words
from benchtwin.measure import batch
from benchtwin.measure.observe import observe_or_fail, observe_seeds_photo
from benchtwin.measure.observed import Observed, PackedPictures
from benchtwin.report import draw
from benchtwin.twin.campaign.results import Measurement
from benchtwin.vision.measurement import MeasurementError, Observation
from benchtwin.vision.pile.repose import PileOptions
from benchtwin.vision.results import Results, measured_anything, row_of
from benchtwin.vision.summary import as_table, summarise
from benchtwin.vision.terminal import show_results


@dataclass(frozen=True, eq=False)
class Measurements:
    """What was measured on some recordings; `calibrate`, `diagnose` and `audit` take it
    in the place of the bench's folder, and read no recording again.

    observations: one a recording, with its track, bounces and readings as tables, and
    pictures of what was found. notes: (recording, note) of what was assumed or left
    out; unread: those on files that benchtwin does not read. folder: where files were
    written, None where none were. observed: the recordings themselves; its fields may
    change between versions."""

    observations: tuple[Observation, ...] = field(repr=False)
    observed: Observed = field(repr=False)
    notes: tuple[tuple[str, str], ...] = field(default=(), repr=False)
    folder: Path | None = None
    unread: tuple[tuple[str, str], ...] = field(default=(), repr=False)

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

    def tell(self, *, quiet: bool) -> int:
        """Print this as the command does, and return its exit code."""
        table, out = self.quantities, self.folder or Path()
        found = measured_anything(table)
        if not quiet:
            means = summarise(self.observations)
            show_results(table, means, self.notes, self.unread, out)
        elif not found:
            why = f"the reasons are in {out / 'measurements.csv'}"
            say("measure", f"nothing could be measured; {why}", FAILED)
        return DONE if found else FAILED


def recordings_of(bench: str | Path | Measurements) -> Path | Observed:
    """The recordings of a bench: those measured before, or the folder that holds
    them."""
    return bench.observed if isinstance(bench, Measurements) else Path(bench)


def existing(paths: str | Path | Sequence[str | Path]) -> list[Path]:
    """One path or several as a list; FileNotFoundError for one that is not there."""
    chosen = [Path(p) for p in ([paths] if isinstance(paths, str | Path) else paths)]
    if missing := [path for path in chosen if not path.exists()]:
        raise FileNotFoundError(f"{missing[0]}: no such file or folder")
    return chosen


@contextmanager
def results_in(
    out: str | Path | None, inputs: list[Path], overwrite: bool
) -> Iterator[Results | None]:
    """What writes results into `out`, whole or not at all; None without it. OSError
    where `out` cannot be written."""
    if out is None:
        yield None
        return
    results = Results(Path(out), inputs, overwrite)
    try:
        yield results
    except OSError as error:
        why = error.strerror or error
        raise OSError(f"cannot write to {out}: {why}") from error
    finally:
        results.abandon()


def measured(
    paths: list[Path],
    options: PileOptions,
    *,
    trim: bool,
    seeds: bool,
    results: Results | None,
    progress: bool,
) -> Measurements:
    """What is measured under these paths, also written to `results`. seeds: of photos
    of spread seeds; progress: shown on stderr."""
    entries = tuple(batch.find_all(paths))
    observed = Observed(_folder_of(paths), entries, options, trim)
    unread = tuple(batch.unread_notes(paths, list(entries)))
    if results is not None:
        results.notes += unread

    def one(entry: batch.Entry, tell: batch.Progress) -> Observation:
        if seeds:
            return observe_or_fail(entry, observe_seeds_photo, "seeds")
        return observe_or_fail(entry, partial(observed.observe, progress=tell))

    kept = []
    with _bar(len(entries), progress) as told:
        for observation in batch.measure_each(entries, one, told):
            if results is not None:
                results.add(observation)
            kept.append(_packed(observation))
    if results is not None:
        results.finish()
    folder = None if results is None else results.out
    notes = (*unread, *((o.recording, note) for o in kept for note in o.notes))
    return Measurements(tuple(kept), observed, notes, folder, unread)


@contextmanager
def _bar(total: int, shown: bool) -> Iterator[Callable[[float, batch.Entry], None]]:
    """A bar on stderr; yields what moves it."""
    columns = (
        Words("{task.description}"),
        BarColumn(),
        Words("{task.completed:.0f}/{task.total}"),
        TimeRemainingColumn(),
    )
    console = Terminal(stderr=True)
    with Progress(*columns, console=console, disable=not shown, transient=True) as bar:
        task = bar.add_task("measuring", total=total)
        yield lambda done, entry: bar.update(
            task, completed=done, description=getattr(entry, "id", "?")[:40]
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


def fractions(window_pct: tuple[float, float]) -> tuple[float, float]:
    """Two heights in % as shares; MeasurementError where no line fits between them."""
    from benchtwin.rigs.pile.observe import LEAST_WINDOW  # brings optimisers

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
