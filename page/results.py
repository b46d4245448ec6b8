"""Reads the results of a bench for the page."""

import json
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import pandas as pd

from benchtwin.bench.language import tr
from benchtwin.calibrate.statistics.next_test import gain_in_words, worth_it
from benchtwin.page.folder import (
    CALIBRATED,
    DIAGNOSED,
    MEASURED,
    RESULTS,
    Refused,
)
from benchtwin.page.measuring import shorten_paths

SETTLES = "it would settle what is missing"
SHOWS_MORE = "nothing that matters is missing so far; it would show more"
MOST_BYTES = 200_000_000  # of a file of results
SPOILT = (
    *(ArithmeticError, AttributeError, LookupError, TypeError, ValueError),
    *(MemoryError, RecursionError),
)


@dataclass(frozen=True)
class ToRecord:
    """A thing to record, and what it is good for or why it is to be done again."""

    what: str
    why: str


@contextmanager
def read(file: Path) -> Iterator[Path]:
    """A file of results while it is read and understood. Refused, in one sentence,
    where it is not what that command leaves."""
    try:
        if file.is_file() and file.stat().st_size > MOST_BYTES:
            raise ValueError(tr("too large"))
        yield file
    except Refused:
        raise
    except SPOILT as error:
        raise Refused(
            tr(
                "{}/{}/{} cannot be read: damaged, or left by another version. Run that"
                " command again",
                RESULTS,
                file.parent.name,
                file.name,
            )
        ) from error


def json_content(file: Path) -> dict:
    """A JSON file's content, to be called within `read`; nothing where there is none,
    or it is a link."""
    if file.is_symlink() or not file.is_file():
        return {}
    return dict(json.loads(file.read_text(encoding="utf8")))


def next_recordings(results: Path) -> dict[str, list[ToRecord]]:
    """What to record next by what it is for; only headings that have something. Refused
    where a file of it cannot be read."""
    with read(results / CALIBRATED / "result.json") as file:
        gone = [
            ToRecord(str(rig), shorten_paths(why))
            for rig, why in (json_content(file).get("not_calibrated") or {}).items()
        ]
    with read(results / CALIBRATED / "tables" / "next_tests.csv") as file:
        narrowing = _tests(table(file))
    with read(results / MEASURED / "measurements.csv") as file:
        again = _again(table(file))
    with read(results / DIAGNOSED / "diagnosis.json") as file:
        apart = _telling_apart(json_content(file).get("rigs", {}))
    lists = {
        "Not calibrated yet": gone,
        "To narrow the parameters": narrowing,
        "To tell explanations apart": apart,
        "To record again": again,
    }
    return {heading: rows for heading, rows in lists.items() if rows}


def _tests(table: pd.DataFrame | None) -> list[ToRecord]:
    if table is None or "pick" not in table:
        return []
    return [
        ToRecord(
            str(row.test),
            gain_in_words(row.variance_left_after, with_others=k > 0),
        )
        for k, row in enumerate(worth_it(table).itertuples())
    ]


def _telling_apart(rigs: dict[str, dict]) -> list[ToRecord]:
    """What each rig's diagnosis asks for; first what would settle what matters."""
    asked = sorted(rigs.items(), key=lambda entry: not entry[1]["matters"])
    return [
        ToRecord(
            f"{rig}: {f['next_record']}",
            tr(SETTLES) if f["matters"] else tr(SHOWS_MORE),
        )
        for rig, f in asked
        if f["next_record"]
    ]


def _again(table: pd.DataFrame | None) -> list[ToRecord]:
    """Recordings of which something failed, each with its reason once."""
    if table is None:
        return []
    failed = table[table["quality"] == "failed"].dropna(subset=["reason"])
    return [
        ToRecord(str(name), "; ".join(dict.fromkeys(map(str, rows["reason"]))))
        for name, rows in failed.groupby("recording", sort=True)
    ]


def table(path: Path) -> pd.DataFrame | None:
    """The table in a file; None where there is none, or nothing in it."""
    if path.is_symlink() or not path.is_file() or not path.stat().st_size:
        return None
    return pd.read_csv(path)
