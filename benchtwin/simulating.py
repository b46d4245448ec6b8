"""What `benchtwin.simulate` leaves: recordings of a simulated rig, measured like the
bench's own."""

import json
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import pandas as pd
from plotly.graph_objects import Figure

from benchtwin import shown
from benchtwin.measuring import Measurements
from benchtwin.recording_commands import measure
from benchtwin.twin.campaign.results import Measurement
from benchtwin.twin.run import RECORD


@dataclass(frozen=True, eq=False)
class Simulations:
    """Simulated recordings. folder: the bench folder that holds them; names: theirs."""

    folder: Path
    names: tuple[str, ...]

    @cached_property
    def measured(self) -> Measurements:
        """What is measured on them, as if they came from the bench."""
        return measure([self.folder / name for name in self.names])

    @property
    def truth(self) -> pd.DataFrame:
        """A row a recording: what the simulation itself knows of the answer, units at
        the end of the columns' names."""
        return pd.DataFrame(
            [{"recording": name} | _truth(self.folder / name) for name in self.names]
        )

    def plot(self) -> Figure:
        """What is measured on each recording, as `Measurements.plot`, and beside it as
        grey crosses what the simulation itself knows of it."""
        figure, truth = self.measured.plot(), self.truth.set_index("recording")
        table = self.measured.quantities.dropna(subset="value")
        groups = table.groupby(["rig", "quantity", "unit"], sort=False)
        for k, ((_, quantity, unit), rows) in enumerate(groups):
            column = Measurement(quantity, 0.0, 0.0, unit).column()
            name = column if column in truth else quantity
            if name in truth:
                known = [truth[name].get(r) for r in rows["recording"]]
                cross = {"symbol": "x-thin", "size": 12, "line": {"width": 2}}
                at = {"x": rows["recording"], "y": known, "mode": "markers"}
                place = {"row": 1 + k // 2, "col": 1 + k % 2}
                figure.add_scatter(**at, marker=cross, **place)
        return figure

    def _repr_html_(self) -> str:
        cells = self.truth.map(lambda v: f"{v:.4g}" if isinstance(v, float) else v)
        return self.measured._repr_html_() + shown.html("The simulation knows", cells)


def _truth(recording: Path) -> dict[str, float | None]:
    truth: dict[str, float | None] = json.loads(
        (recording / RECORD).read_text(encoding="utf8")
    )["truth"]
    return truth
