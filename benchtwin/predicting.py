"""What `benchtwin.predict` finds: what another system shows, with intervals."""

from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import pandas as pd
from plotly.graph_objects import Figure

from benchtwin import shown
from benchtwin.bench.exits import DONE
from benchtwin.calibrate.prediction.beside import Comparison, Measured
from benchtwin.calibrate.prediction.predict import (
    DRAWN,
    QUANTITIES,
    Prediction,
    intervals,
    rows,
    sign,
)
from benchtwin.calibrate.prediction.written import notes, show
from benchtwin.report.draw import BLUE, GREY, RED


@dataclass(frozen=True, eq=False)
class PredictionSummary:
    """What was predicted.

    quantities: a row a quantity: unit; mean; low, high: 95 % of single packings;
    mean_low, mean_high: 95 % of the mean over packings; parameter_sd, packing_sd.
    beside: a row a quantity that was recorded: its mean, and where that was expected
    (low to high, z). runs: a row a simulated run. notes: what was assumed or left out.
    folder: where files were written. details: its fields may change between
    versions. recorded: readings beside which it stands, by quantity."""

    quantities: pd.DataFrame
    beside: pd.DataFrame
    runs: pd.DataFrame = field(repr=False)
    notes: tuple[str, ...]
    folder: Path
    details: Prediction = field(repr=False)
    recorded: dict[str, np.ndarray] = field(default_factory=dict, repr=False)

    def plot(self) -> Figure:
        """A panel a quantity: runs at drawn parameters (grey), 95 % of single packings
        and of their mean (blue), the recordings (red)."""
        names = QUANTITIES[self.details.rig]
        table = self.quantities
        titles = [f"{names[q]} ({sign(q).strip()})" for q in table["quantity"]]
        figure, places = shown.panels(titles)
        for row, place in zip(table.itertuples(), places, strict=True):
            runs = self.runs.loc[self.runs["kind"] == DRAWN, row.quantity].dropna()
            points = [
                ("runs", runs, [], GREY),
                ("one packing", [row.mean], [row.high - row.mean], BLUE),
                ("mean of many", [row.mean], [row.mean_high - row.mean], BLUE),
                ("recorded", self.recorded.get(row.quantity, []), [], RED),
            ]
            for name, values, half, colour in points:
                at = {"x": [name] * len(values), "y": values, "error_y_array": half}
                look = {"mode": "markers", "marker": {"size": 8, "color": colour}}
                figure.add_scatter(**at, **look, **place)
        return figure

    def _repr_html_(self) -> str:
        names, table = QUANTITIES[self.details.rig], self.quantities
        one, many = zip(*map(intervals, table.itertuples()))
        columns = {"one packing, 95 %": one, "mean of many, 95 %": many}
        cells = pd.DataFrame({"quantity": table["quantity"].map(names), **columns})
        said = [*self.beside["said"], *self.notes]
        return shown.html(f"Predicted {self.details.rig}", cells, said)

    def tell(self, *, quiet: bool) -> int:
        """Print this as the command does, and return its exit code."""
        if not quiet:
            show(self.details, [*self.beside["said"], *self.notes], self.folder)
        return DONE


BESIDE = ["quantity", "measured", "n", "predicted", "low", "high", "z", "said"]


def summary(
    found: Prediction, seen: Measured | None, compared: list[Comparison], folder: Path
) -> PredictionSummary:
    """What a prediction found, as Python shows it."""
    beside = pd.DataFrame([vars(one) for one in compared], columns=BESIDE)
    said = tuple(notes(found, seen))
    recorded = {} if seen is None else seen.values
    return PredictionSummary(
        rows(found), beside, found.runs, said, folder, found, recorded
    )
