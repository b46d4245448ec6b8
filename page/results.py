"""Reads the results of a bench for the page: explanations, posterior, what to record
next."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd

from benchtwin.bench.numbers import with_interval
from benchtwin.calibrate.procedure import calibration
from benchtwin.calibrate.procedure.next_tests import gain_in_words, worth_it
from benchtwin.calibrate.procedure.words import in_status
from benchtwin.page.folder import read_json
from benchtwin.page.measuring import shorten_paths
from benchtwin.report.draw import name as in_words

DIAGNOSE_AGAIN = "diagnosed by an older version; diagnose again for a verdict in words"
MEASURED, CALIBRATED, DIAGNOSED = "measured", "calibrated", "diagnosed"
SETTLES = "it would settle what is missing"
SHOWS_MORE = "nothing that matters is missing so far; it would show more"
MOST_DRAWS = 1500
MOST_EXPLANATIONS = 8
LEAST_PROBABILITY = 0.005  # of an explanation that is shown


@dataclass(frozen=True)
class Explanation:
    """What may be missing, each effect in words; probability 0 to 1."""

    effects: tuple[str, ...]
    probability: float


@dataclass(frozen=True)
class Explained:
    """A rig's diagnosis: its sentence, and the tone in which it is said (`tone` of
    diagnose.words)."""

    rig: str
    sentence: str
    tone: str
    explanations: tuple[Explanation, ...]
    next_record: str
    matters: bool


@dataclass(frozen=True)
class ToRecord:
    """A thing to record, and what it is good for or why it is to be done again."""

    what: str
    why: str


@dataclass(frozen=True)
class Calibrated:
    """A contact parameter as the last calibration left it, in words."""

    name: str
    value: str
    status: str
    known: bool


@dataclass(frozen=True)
class Cloud:
    """Draws of a posterior (n, k) with the names of their columns."""

    names: tuple[str, ...]
    draws: np.ndarray


def explained(results: Path) -> list[Explained]:
    """The rigs of the last diagnosis, the most probable explanation first."""
    from benchtwin.diagnose.words import missing  # takes seconds to load

    out = []
    rigs = read_json(results / DIAGNOSED / "diagnosis.json").get("rigs", {})
    for rig, found in rigs.items():
        listed = [
            Explanation(
                tuple(missing(e, rig) for e in one["effects"]),
                float(one["probability"]),
            )
            for one in found["explanations"][:MOST_EXPLANATIONS]
            if one["probability"] >= LEAST_PROBABILITY
        ]
        said, tone = found.get("sentence") or DIAGNOSE_AGAIN, found.get("tone", "open")
        then, matters = found["next_record"] or "", found["matters"]
        out.append(Explained(rig, said, tone, tuple(listed), then, matters))
    return out


def calibrated(results: Path) -> list[Calibrated]:
    """The parameters of the last calibration with their 95 % intervals."""
    stated = read_json(results / CALIBRATED / "result.json").get("parameters", {})
    return [
        Calibrated(
            in_words(key),
            with_interval(one["value"], one["low"], one["high"]),
            in_status(one["status"], one["remark"]),
            one["status"] == calibration.CALIBRATED,
        )
        for key, one in stated.items()
    ]


def posterior(results: Path) -> Cloud | None:
    """The draws of the last calibration; None where there are none."""
    table = _table(results / CALIBRATED / "tables" / "posterior.csv")
    if table is None or table.shape[1] < 2:
        return None
    table = table.iloc[:: max(1, len(table) // MOST_DRAWS)]
    return Cloud(tuple(in_words(c) for c in table.columns), table.to_numpy(float))


def next_recordings(results: Path) -> dict[str, list[ToRecord]]:
    """What to record next by what it is for; only headings that have something."""
    gone = read_json(results / CALIBRATED / "result.json").get("not_calibrated") or {}
    lists = {
        "Not calibrated yet": [
            ToRecord(rig, shorten_paths(why)) for rig, why in gone.items()
        ],
        "To narrow the parameters": _tests(
            _table(results / CALIBRATED / "tables" / "next_tests.csv")
        ),
        "To tell explanations apart": [
            ToRecord(
                f"{one.rig}: {one.next_record}", SETTLES if one.matters else SHOWS_MORE
            )
            for one in sorted(explained(results), key=lambda one: not one.matters)
            if one.next_record
        ],
        "To record again": _again(_table(results / MEASURED / "measurements.csv")),
    }
    return {heading: rows for heading, rows in lists.items() if rows}


def _tests(table: pd.DataFrame | None) -> list[ToRecord]:
    if table is None or "pick" not in table:
        return []
    return [
        ToRecord(row.test, gain_in_words(row.variance_left_after, with_others=k > 0))
        for k, row in enumerate(worth_it(table).itertuples())
    ]


def _again(table: pd.DataFrame | None) -> list[ToRecord]:
    """Recordings of which something failed, each with its reason once."""
    if table is None:
        return []
    failed = table[table["quality"] == "failed"].dropna(subset=["reason"])
    return [
        ToRecord(str(name), "; ".join(dict.fromkeys(rows["reason"])))
        for name, rows in failed.groupby("recording", sort=True)
    ]


def _table(path: Path) -> pd.DataFrame | None:
    try:
        return pd.read_csv(path)
    except (OSError, pd.errors.EmptyDataError, pd.errors.ParserError):
        return None
