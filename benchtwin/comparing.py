"""What `benchtwin.compare` finds: our engine beside LAMMPS, on the same
piles of the same law."""

from dataclasses import dataclass, field
from pathlib import Path

import pandas as pd
from plotly.graph_objects import Figure

from benchtwin import shown
from benchtwin.bench.exits import DONE
from benchtwin.bench.terminal import Terminal
from benchtwin.report.draw import BLUE, GREY, RED
from benchtwin.twin.command import print_lines
from benchtwin.twin.compare import QUANTITIES, paired
from benchtwin.twin.engine import LAMMPS, OURS


@dataclass(frozen=True, eq=False)
class EngineComparison:
    """How two engines differ.

    differences: a row a row of parameters and quantity: means of ours and of LAMMPS,
    their difference with its 95 % interval over packings, and whether that leaves out 0
    (parts). runs: a row a pile. verdict: where the engines part, in words. notes: what
    was converted of the law. failed: runs that failed, and why. folder: where files
    were written."""

    differences: pd.DataFrame
    runs: pd.DataFrame = field(repr=False)
    verdict: str
    notes: tuple[str, ...]
    folder: Path
    failed: tuple[str, ...] = ()

    def plot(self) -> Figure:
        """A panel a quantity: LAMMPS − ours. Grey: a pair of piles of one packing;
        blue: their mean at each row with its 95 % interval, red where that leaves out
        0."""
        groups = list(self.differences.groupby("quantity", sort=False))
        figure, places = shown.panels([QUANTITIES[str(name)] for name, _ in groups])
        for (quantity, rows), place in zip(groups, places, strict=True):
            pairs = paired(self.runs, str(quantity))
            figure.add_scatter(
                x=pairs["row"].map(str),
                y=pairs["lammps"] - pairs["benchtwin"],
                mode="markers",
                marker={"size": 6, "color": GREY},
                text=[f"packing {packing}" for packing in pairs["packing"]],
                **place,
            )
            colours = [RED if parts else BLUE for parts in rows["parts"]]
            figure.add_scatter(
                x=rows["row"].map(str),
                y=rows["difference"],
                mode="markers",
                marker={"size": 9, "color": colours},
                error_y={"array": (rows["high"] - rows["difference"]).fillna(0.0)},
                text=rows["parameters"],
                **place,
            )
        figure.add_hline(0.0, line_dash="dot")
        figure.update_xaxes(type="category")
        return figure

    @property
    def cells(self) -> pd.DataFrame:
        """The differences as they are read."""
        table = self.differences
        apart = [
            f"{r.difference:+.2f}"
            + (f" ({r.low:+.2f} to {r.high:+.2f})" if r.pairs > 1 else "")
            for r in table.itertuples()
        ]
        return pd.DataFrame(
            {
                "row": table["row"] + " " + table["parameters"],
                "quantity": table["quantity"].map(QUANTITIES),
                "pairs": table["pairs"],
                "ours": [f"{v:.2f}" for v in table["ours"]],
                "LAMMPS": [f"{v:.2f}" for v in table["lammps"]],
                "difference (95 % interval)": apart,
                "": table["parts"].map({True: "apart", False: ""}),
            }
        )

    def _repr_html_(self) -> str:
        notes = [self.verdict, *self.notes, *self.failed]
        return shown.html("Our engine beside LAMMPS", self.cells, notes)

    def tell(self, *, quiet: bool) -> int:
        """Print this as the command does, and return its exit code."""
        if not quiet:
            console, out = Terminal(), self.folder
            shown.in_terminal(self.cells, console)
            took = self.runs.groupby("engine")["seconds"].mean()
            seconds = f"ours {took[OURS]:.0f}, LAMMPS {took[LAMMPS]:.0f}"
            print_lines(
                console,
                *(*self.failed, self.verdict, f"seconds a pile: {seconds}"),
                f"picture: {out / 'compared.html'}; table: {out / 'compared.csv'}",
            )
        return DONE
