"""What `benchtwin.predict` finds: what another system shows, with intervals."""

from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import pandas as pd
from plotly.graph_objects import Figure

from benchtwin import shown
from benchtwin.bench.exits import DONE
from benchtwin.bench.terminal import Terminal
from benchtwin.calibrate.prediction.beside import Comparison, Measured
from benchtwin.calibrate.prediction.predict import (
    DRAWN,
    QUANTITIES,
    Prediction,
    digits,
    intervals,
    rows,
    sign,
)
from benchtwin.calibrate.prediction.written import notes
from benchtwin.report.draw import BLUE, GREY, RED
from benchtwin.twin.command import print_lines


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

    @property
    def cells(self) -> pd.DataFrame:
        """The quantities as they are read."""
        rows = []
        for row in self.quantities.itertuples():
            q = str(row.quantity)
            of = (row.parameter_sd, row.packing_sd)
            sds = (digits(q, v, 1) + sign(q) for v in of)
            rows.append((QUANTITIES[self.details.rig][q], *intervals(row), *sds))
        return pd.DataFrame(rows, columns=[self.details.rig, *COLUMNS])

    def _repr_html_(self) -> str:
        said = [*self.beside["said"], *self.notes]
        return shown.html(f"Predicted {self.details.rig}", self.cells, said)

    def tell(self, *, quiet: bool) -> int:
        """Print this as the command does, and return its exit code."""
        if not quiet:
            console, out = Terminal(), self.folder
            shown.in_terminal(self.cells, console)
            left = f"picture: {out / 'prediction.html'}"
            left += f"; numbers: {out / 'predicted.csv'}"
            print_lines(console, *self.beside["said"], *self.notes, left)
        return DONE


COLUMNS = ("one packing, 95 %", "mean of many, 95 %", "sd by parameters", "by packing")
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
