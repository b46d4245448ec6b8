"""The folder that `benchtwin measure` writes: tables, overlays, and a page on which
fifty are looked through in a minute."""

from collections.abc import Iterable, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import replace
from importlib.metadata import version
from pathlib import Path

import numpy as np
import pandas as pd
from jinja2 import Environment, PackageLoader
from PIL import Image

from benchtwin.bench.conditions import MEASURED
from benchtwin.bench.language import spoken, tr
from benchtwin.bench.numbers import stored
from benchtwin.bench.outlets import csv_text
from benchtwin.bench.whole_file import folder_beside
from benchtwin.bench.workbook import WORKBOOK, write_workbook
from benchtwin.vision.measurement import (
    DOUBTFUL,
    FAILED,
    GOOD,
    Observation,
    Quantity,
    worst,
)
from benchtwin.vision.out_folder import check_out, file_name, put_in_place
from benchtwin.vision.summary import Line, as_table, summarise

TABLES = ("bounces", "readings", "seeds")  # of all recordings together, one file each
OWN = (
    "measurements.csv",
    "summary.csv",
    "notes.csv",
    WORKBOOK,
    *(f"{name}.csv" for name in TABLES),
    "overlays",
    "tracks",
)
METHODS = {  # what the workbook says of its columns
    "unit": "of every number of the row; 1 where it has none",
    "mean": "of the repeats, unweighted",
    "low, high": (
        "95 % interval of the mean: Student's t on the scatter between the repeats, and"
        " what all recordings of a session have in common, in quadrature"
    ),
    "scatter": "standard deviation between the repeats",
    "measuring": "root mean square of the standard deviations of single readings",
    "common": "standard deviation of what all recordings of a session have in common",
    "value, sd": "value ± 1.96 sd is a 95 % interval",
    "sd_common": "the part of sd that all recordings of one session share",
    "quality": "whether the number means what its name says; reason: why not",
    "outliers": "named, and part of the mean",
}


def _card(file: str, picture: str, observation: Observation) -> dict:
    """What stands under a picture `file`, named `picture` in the observation."""
    first = picture == next(iter(observation.pictures))
    name, quantities = observation.recording, observation.quantities if first else ()
    reasons = (f"{q.name}: {q.reason}" for q in quantities if q.reason)
    return {
        "file": file,
        "rig": observation.rig,
        "lines": [q.in_words for q in quantities if q.quality != FAILED],
        "title": name if first else f"{name}: {picture}",
        "quality": worst(quantities) if quantities else GOOD,
        "reasons": tuple(dict.fromkeys(reasons)),
    }


def _contact_sheet(cards: list[dict]) -> str:
    """One HTML page without scripts; it loads the pictures beside it as they come into
    view."""
    loader = PackageLoader("benchtwin.vision.overlay", ".")
    pages = Environment(loader=loader, autoescape=True, trim_blocks=True)
    pages.globals |= {"tr": tr, "language": spoken()}
    kinds = (FAILED, DOUBTFUL, GOOD)
    cards = sorted(cards, key=lambda card: kinds.index(card["quality"]))
    return pages.get_template("contact_sheet.html.j2").render(cards=cards, kinds=kinds)


def row_of(observation: Observation, quantity: Quantity) -> tuple:
    """What MEASURED say of a quantity, but for the overlay."""
    q = quantity
    told = (q.name, q.value, q.sd, q.sd_common, q.unit, q.quality, q.reason)
    return (observation.recording, observation.rig, *told)


class Results:
    """Writes observations to a folder that appears whole or not at all.
    measurements.csv, summary.csv, results.xlsx and, where there is content, notes.csv,
    bounces.csv, readings.csv, seeds.csv, overlays/ (with a contact sheet, index.html),
    tracks/.
    Conditions that recordings state are columns of every table."""

    def __init__(self, out: Path, inputs: Sequence[Path] = (), overwrite: bool = False):
        self.out, self.overwrite = Path(out), overwrite
        check_out(self.out, "results", _is_own, overwrite, inputs)
        self.open = ExitStack()
        self.part = self.open.enter_context(folder_beside(self.out))
        self.stems: set[str] = set()
        self.rows: list[dict] = []
        self.tables: dict[str, list[pd.DataFrame]] = {name: [] for name in TABLES}
        self.notes: list[tuple[str, str]] = []
        # the notes on files that are not read
        self.not_read: list[tuple[str, str]] = []
        self.observations: list[Observation] = []  # without their pictures and tracks
        self.cards: list[dict] = []  # of the contact sheet
        self.summary: list[Line] = []

    def add(self, observation: Observation) -> None:
        stem = file_name(observation.recording, self.stems)
        self.stems.add(stem.lower())
        overlay = ""
        for i, (name, picture) in enumerate(observation.pictures.items()):
            file = Path("overlays") / (
                f"{stem}.png" if i == 0 else f"{stem}-{name}.png"
            )
            (self.part / "overlays").mkdir(exist_ok=True)
            Image.fromarray(picture).save(self.part / file, compress_level=1)
            overlay = overlay or file.as_posix()
            self.cards.append(_card(file.name, name, observation))
        if observation.track is not None:
            (self.part / "tracks").mkdir(exist_ok=True)
            observation.track.to_csv(
                self.part / "tracks" / f"{stem}.csv", index=False, float_format="%.6g"
            )
        for name, tables in self.tables.items():
            if (table := getattr(observation, name)) is not None and len(table):
                beside = table.copy()
                for condition, value in observation.conditions.items():
                    own = condition not in table
                    beside[condition if own else f"condition_{condition}"] = value
                tables.append(beside)
        self.notes += [(observation.recording, note) for note in observation.notes]
        for q in observation.quantities:
            row = (*row_of(observation, q), overlay)
            self.rows.append({**observation.conditions, **dict(zip(MEASURED, row))})
        self.observations.append(
            replace(observation, pictures={}, track=None, bounces=None, seeds=None)
        )

    def finish(self) -> pd.DataFrame:
        """Write the tables and put the folder in place; returns the measurements."""
        conditions = dict.fromkeys(
            name for row in self.rows for name in row if name not in MEASURED
        )
        table = pd.DataFrame(self.rows, columns=[*MEASURED, *conditions])
        self.summary = summarise(self.observations)
        written = {
            "measurements": table,
            **{
                name: pd.concat(t, ignore_index=True)
                for name, t in self.tables.items()
                if t
            },
        }
        written["summary"] = as_table(self.summary)
        if self.notes:
            written["notes"] = pd.DataFrame(self.notes, columns=["recording", "note"])
        write_workbook(self.part / WORKBOOK, sheets(written))
        written["measurements"] = _rounded(table, ["value"], table["sd"])
        summary = written["summary"]
        half = (summary["high"] - summary["low"]) / 2
        written["summary"] = _rounded(summary, ("mean", "low", "high"), half)
        for name, rows in written.items():
            (self.part / f"{name}.csv").write_text(csv_text(rows), encoding="utf8")
        if (self.part / "overlays").is_dir():
            page = self.part / "overlays" / "index.html"
            sheet = _contact_sheet(self.cards)
            page.write_text(sheet, encoding="utf8", errors="backslashreplace")
        with self.open:
            put_in_place(self.part, self.out, _is_own, self.overwrite)
        return table

    def abandon(self) -> None:
        self.open.close()


def _rounded(
    table: pd.DataFrame, columns: Iterable[str], sd: pd.Series
) -> pd.DataFrame:
    """The table with these columns as text, rounded by the sd of their row."""
    texts = {
        name: [stored(*pair) for pair in zip(table[name], sd, strict=True)]
        for name in columns
    }
    return table.assign(**texts)


def sheets(tables: Mapping[str, pd.DataFrame]) -> dict[str, pd.DataFrame]:
    """The workbook's sheets by name, of the tables by theirs."""
    named = {"summary": "means over repeats"}
    told = [(column, tr(METHODS[column])) for column in METHODS]
    methods = pd.DataFrame(told, columns=["column", "value or method"])
    methods.loc[len(methods)] = ["measured by", f"benchtwin {version('benchtwin')}"]
    return {
        **{
            named.get(name, name): tables[name]
            for name in ("summary", "measurements", "notes")
            if name in tables
        },
        "units and methods": methods,
    }


def _is_own(path: Path) -> bool:
    return path.name in OWN


def measured_anything(table: pd.DataFrame) -> bool:
    """Whether any quantity was measured."""
    return (
        bool(len(table))
        and bool((table["quality"] != FAILED).any())
        and bool(np.isfinite(table["value"]).any())
    )
