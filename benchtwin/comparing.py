"""`benchtwin.compare`: our engine beside LAMMPS, on the same piles of the same law."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import pandas as pd
from plotly.graph_objects import Figure

from benchtwin import shown
from benchtwin.blas import on_one_blas_thread
from benchtwin.twin.compare.command import Compared, compare_into
from benchtwin.twin.compare.differences import QUANTITIES, verdict
from benchtwin.twin.compare.rows import PARAMETERS
from benchtwin.twin.parameters import Parameters


@dataclass(frozen=True, eq=False)
class EngineComparison:
    """How two engines differ.

    differences: a row a row of parameters and quantity: means of ours and of LAMMPS,
    their difference with its 95 % interval over packings, and whether that leaves out 0
    (parts). runs: a row a pile. verdict: where the engines part, in words. notes: what
    was converted of the law, and runs that failed. folder: where files were written."""

    differences: pd.DataFrame
    runs: pd.DataFrame = field(repr=False)
    verdict: str
    notes: tuple[str, ...]
    folder: Path

    def plot(self) -> Figure:
        """A panel a quantity: LAMMPS − ours at each row, with its 95 % interval."""
        groups = list(self.differences.groupby("quantity", sort=False))
        figure, places = shown.panels([QUANTITIES[str(name)] for name, _ in groups])
        for (_, rows), place in zip(groups, places, strict=True):
            reach = (rows["high"] - rows["difference"]).replace(np.nan, 0.0)
            drawn = shown.points(rows["row"].map(str), rows["difference"], reach)
            figure.add_trace(drawn, **place)
        figure.add_hline(0.0, line_dash="dot")
        return figure

    def _repr_html_(self) -> str:
        table = self.differences
        cells = pd.DataFrame(
            {
                "row": table["row"],
                "quantity": table["quantity"].map(QUANTITIES),
                "ours": [f"{v:.2f}" for v in table["ours"]],
                "LAMMPS": [f"{v:.2f}" for v in table["lammps"]],
                "difference (95 % interval)": [
                    f"{r.difference:+.2f} ({r.low:+.2f} to {r.high:+.2f})"
                    for r in table.itertuples()
                ],
            }
        )
        return shown.html(
            "Our engine beside LAMMPS", cells, [self.verdict, *self.notes]
        )


@on_one_blas_thread
def compare(
    *,
    out: str | Path,
    rows: Sequence[Mapping[str, float]] = (),
    packings: int = 4,
    settings: Mapping[str, object] | None = None,
    rng: int = 1,
    ranks: int = 1,
    workers: int | None = None,
    scheduler: str | None = None,
    progress: bool = False,
) -> EngineComparison:
    """Compare our engine with LAMMPS: reduced piles of the same law and packings.

    out: folder for tables, a picture and the finished runs. rows: contact parameters by
    name, a mapping a row; none: the soybean paper's optimum. packings: piles of each
    row, with seeds and packing of their own. settings: keys of recording.toml by their
    dotted names, {"pile.fill_height_mm": 40.0}. ranks: processes that share one LAMMPS
    pile. rng, workers, scheduler, progress: as `calibrate` takes them.

    Called again, it goes on where it was stopped. Raises FileExistsError where `out`
    holds something else; ValueError for an unknown name or what cannot be simulated;
    RuntimeError where LAMMPS is not there, or no pile of both was measured."""
    asked = Compared(
        out=Path(out),
        packings=packings,
        settings=settings or {},
        ranks=ranks,
        rng=rng,
        workers=workers,
        scheduler=scheduler,
        quiet=not progress,
    )
    found = compare_into(asked, [_checked(row) for row in rows] or [{}])
    notes = (*found.notes, *found.failed)
    return EngineComparison(
        found.table, found.runs, verdict(found.table), notes, asked.out
    )


def _checked(row: Mapping[str, float]) -> dict[str, float]:
    """A row of parameters; ValueError for a name or a number that is none."""
    if wrong := [name for name in row if name not in PARAMETERS]:
        there = ", ".join(PARAMETERS)
        raise ValueError(f"rows: no parameter {wrong[0]!r}; there are {there}")
    numbers = {name: float(value) for name, value in row.items()}
    Parameters(**numbers)  # type: ignore[arg-type]  # so that it is refused now
    return numbers
