"""A comparison of two engines written into its folder."""

import json
from pathlib import Path

import pandas as pd

from benchtwin.bench.outlets import csv_text
from benchtwin.bench.whole_file import write_whole
from benchtwin.twin.compare.differences import verdict
from benchtwin.twin.engine import LAMMPS, Engine
from benchtwin.twin.versions import versions

OURS = {"runs", "compared.csv", "runs.csv", "compared.html", "compared.json"}


def write(out: Path, table: pd.DataFrame, runs: pd.DataFrame, notes: list[str]) -> None:
    """Write what `differences` made of the runs, and the runs, into `out`."""
    write_whole(out / "compared.csv", csv_text(table))
    write_whole(out / "runs.csv", csv_text(runs))
    programs = versions() | {"lammps": Engine(LAMMPS).version}
    told = {"versions": programs, "notes": notes, "verdict": verdict(table)}
    (out / "compared.json").write_text(json.dumps(told, indent=1), encoding="utf8")
