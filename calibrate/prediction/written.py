"""A prediction written into its folder, and in the terminal."""

import json
from collections.abc import Iterable
from dataclasses import asdict
from pathlib import Path

from rich.table import Table

from benchtwin.bench.outlets import csv_text
from benchtwin.bench.terminal import Terminal
from benchtwin.bench.whole_file import write_whole
from benchtwin.calibrate.prediction.beside import Comparison, Measured
from benchtwin.calibrate.prediction.predict import (
    QUANTITIES,
    Prediction,
    digits,
    intervals,
    rows,
    sign,
)
from benchtwin.twin.command import print_lines
from benchtwin.twin.versions import versions

# what a prediction leaves in its folder
OURS = {"runs", "predicted.csv", "runs.csv", "prediction.json", "prediction.html"}
INTERVAL = "95 %: low to high of a single packing, mean_low to mean_high of their mean"
COLUMNS = ("one packing, 95 %", "mean of many, 95 %", "sd by parameters", "by packing")


def write(
    out: Path,
    found: Prediction,
    seen: Measured | None,
    compared: list[Comparison],
    description: dict,
    *,
    calibrated: Path,
    seed: int,
) -> None:
    """Write a prediction and what it was compared with into `out`. calibrated: where
    its calibration lies; seed: of the random numbers."""
    table = rows(found)
    quantities = table.drop(columns="rig").set_index("quantity")
    content = {
        "schema": 1,
        "rig": found.rig,
        "described": description,
        "interval": INTERVAL,
        "quantities": quantities.to_dict("index"),
        "beside": [asdict(c) for c in compared],
        "recordings": list(seen.recordings) if seen else [],
        "calibrated": str(calibrated),
        "notes": notes(found, seen),
        "random_seed": seed,
        "versions": versions(),
    }
    out.mkdir(parents=True, exist_ok=True)
    write_whole(out / "predicted.csv", csv_text(table))
    write_whole(out / "runs.csv", csv_text(found.runs))
    text = json.dumps(
        content, indent=1, ensure_ascii=False, allow_nan=False, default=float
    )
    write_whole(out / "prediction.json", text)


def notes(found: Prediction, seen: Measured | None) -> list[str]:
    """What was assumed or left out, of the runs and of the recordings beside them."""
    return [*found.notes, *(seen.notes if seen else ())]


def show(found: Prediction, said: Iterable[str], out: Path) -> None:
    """The prediction in the terminal, what is said of it, and where to look."""
    console, shown = Terminal(), Table(box=None, pad_edge=False)
    shown.add_column(found.rig)
    for heading in COLUMNS:
        shown.add_column(heading, justify="right")
    for r in rows(found).itertuples():
        q = str(r.quantity)
        shown.add_row(
            QUANTITIES[found.rig][q],
            *intervals(r),
            *(digits(q, v, 1) + sign(q) for v in (r.parameter_sd, r.packing_sd)),
        )
    console.print(shown)
    written = f"picture: {out / 'prediction.html'}; numbers: {out / 'predicted.csv'}"
    print_lines(console, *said, written)
