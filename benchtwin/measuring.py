"""What `benchtwin.measure` finds: quantities with standard deviations, as tables."""

from dataclasses import dataclass, field
from html import escape
from pathlib import Path

import numpy as np
import pandas as pd
from plotly.graph_objects import Figure

from benchtwin import shown
from benchtwin.bench.conditions import MEASURED
from benchtwin.bench.exits import DONE, FAILED, say
from benchtwin.bench.language import tr
from benchtwin.bench.numbers import plus_minus
from benchtwin.measure.observed import Observed
from benchtwin.report import draw
from benchtwin.twin.campaign.results import Measurement
from benchtwin.vision.measurement import MeasurementError, Observation
from benchtwin.vision.results import measured_anything, row_of
from benchtwin.vision.summary import as_table, summarise
from benchtwin.vision.terminal import show_results


@dataclass(frozen=True, eq=False)
class Measurements:
    """What was measured on some recordings; `calibrate`, `diagnose` and `audit` take it
    in the place of the bench's folder, and read no recording again.

    observations: one a recording, with its track, bounces and readings as tables, and
    pictures of what was found. folder: where files were written, None where none were;
    unread: notes on files that benchtwin does not read. observed: the recordings
    themselves; its fields may change between versions."""

    observations: tuple[Observation, ...] = field(repr=False)
    observed: Observed = field(repr=False)
    folder: Path | None = None
    unread: tuple[tuple[str, str], ...] = field(default=(), repr=False)

    @property
    def notes(self) -> tuple[tuple[str, str], ...]:
        """(recording, note) of what was assumed or left out."""
        own = ((o.recording, note) for o in self.observations for note in o.notes)
        return (*self.unread, *own)

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
            figure.add_scatter(
                x=rows["recording"].map(escape),
                y=rows["value"],
                error_y={"array": reach, "color": draw.GREY},
                text=rows["reason"].map(escape),
                mode="markers",
                marker={"size": 8, "color": colour},
                **place,
            )
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
            why = tr("the reasons are in {}", out / "measurements.csv")
            say("measure", tr("nothing could be measured; {}", why), FAILED)
        return DONE if found else FAILED


def recordings_of(bench: str | Path | Measurements) -> Path | Observed:
    """The recordings of a bench: those measured before, or the folder that holds
    them."""
    return bench.observed if isinstance(bench, Measurements) else Path(bench)


def fractions(window_pct: tuple[float, float]) -> tuple[float, float]:
    """Two heights in % as shares; MeasurementError where no line fits between them."""
    from benchtwin.rigs.pile.observe import LEAST_WINDOW  # brings optimisers

    low, high = (share / 100 for share in window_pct)
    if not 0 <= low < high <= 1 or high - low < LEAST_WINDOW:
        raise MeasurementError(
            tr(
                "window_pct = {}: two heights in %, at least 10 apart, such as (20,"
                " 80)",
                window_pct,
            )
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
