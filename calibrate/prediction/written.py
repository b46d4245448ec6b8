"""A prediction written into its folder."""

import json
from dataclasses import asdict
from pathlib import Path

from benchtwin.bench.outlets import csv_text
from benchtwin.bench.whole_file import write_whole
from benchtwin.calibrate.prediction.beside import Comparison, Measured
from benchtwin.calibrate.prediction.predict import (
    Prediction,
    rows,
)
from benchtwin.twin.versions import versions

# what a prediction leaves in its folder
OURS = {"runs", "predicted.csv", "runs.csv", "prediction.json", "prediction.html"}
INTERVAL = "95 %: low to high of a single packing, mean_low to mean_high of their mean"


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
