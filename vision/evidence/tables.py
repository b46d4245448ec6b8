"""Reads CSV evidence strictly: tracks, light gates, impact times, readings."""

import difflib
import re
import reprlib
import warnings
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd

from benchtwin.bench.language import tr
from benchtwin.bench.rigs import READING_COLUMNS, RIGS
from benchtwin.vision.measurement import MeasurementError, require

_READING_RANGE = {
    "mm": (0.0, 100_000.0),
    "deg": (0.0, 90.0),
    "g": (0.0, 1e7),
    "s": (0.0, 1e5),
}
TRACK_COLUMNS = ("t_s", "x_mm", "y_mm")
TRACK_COLUMNS_PX = ("frame", "x_px", "y_px")
GATE_PLACE = {  # column of a gate's place: height above the plate, or along the path
    rig.name: rig.gate_place for rig in RIGS.values() if rig.gate_place
}
IN_WORDS = ("gate", "note", "repeat")
GATE_EXTRA = ("sd_s", "sd_mm", "gate", "note")
LEAST_GATES = 4  # place, speed, acceleration, and one degree of freedom
SDS = ("sd_mm", "sd_px", "sd_s", "angle_sd_deg")
LEAST_SD, GREATEST_SD = 1e-9, 1e6  # outside, weights overflow and fits do not converge
TRACK_EXTRA = (
    "frame",
    "angle_deg",
    "angle_sd_deg",
    "sd_mm",
    "sd_px",
    "tilt_deg",
    "late",
    "outlier",
    "area_px",
    "t_s",
)
MOST_BYTES = 500_000_000  # ten million rows
LONGEST_LINE = 10_000
SAME_TIME = 1e-6  # of the median step: closer rows have the same time
LARGEST = 1e10  # of any number: seconds since 1970 are fewer
_WITH_POINT = re.compile(r"\s*[+-]?\d*\.\d+(?:[eE][+-]?\d+)?\s*")
_WITH_COMMA = re.compile(r"\s*[+-]?\d*,\d+(?:[eE][+-]?\d+)?\s*")
# 1.234,5: thousands and decimals
_WITH_BOTH = re.compile(r"\s*[+-]?(?:\d+[.']\d+,\d+|\d+[,']\d+\.\d+)\s*")
Range = tuple[float, float]


@dataclass(frozen=True)
class Table:
    """Rows of one CSV file, and notes on what was left out."""

    rows: pd.DataFrame
    notes: tuple[str, ...] = ()


def read_track_csv(path: Path) -> Table:
    """Read track.csv: t_s, x_mm, y_mm (or frame, x_px, y_px) and any of TRACK_EXTRA.
    Rows with a missing position or time are left
    out, rows out of order are sorted; both are noted. Errors: two rows of one time, a
    missing or unknown column, text in place of a number."""
    rows = _read_csv(path)
    there = {*rows.columns}
    pixels = there & {"x_px", "y_px"} and not there & {"x_mm", "y_mm"}
    clock, *places = TRACK_COLUMNS_PX if pixels else TRACK_COLUMNS
    if clock not in there:
        clock = next((c for c in ("t_s", "frame") if c in there), clock)
    needed = (clock, *places)
    rows, notes = _complete(path, rows, needed, TRACK_EXTRA)
    if (back := np.diff(rows[clock]) < 0).any():
        first = rows.index[np.argmax(back) + 1] + 2
        notes.append(
            tr(
                "{}: {} runs backwards at row {}; the rows were put in order",
                path.name,
                clock,
                first,
            )
        )
        rows = rows.sort_values(clock, kind="stable")
    steps = np.diff(rows[clock])
    same = np.append(
        False, steps <= (SAME_TIME * np.median(steps) if steps.size else 0)
    )
    _require_each(path, rows, clock, ~same, tr("; keep one"), tr("two rows for "))
    require(
        len(rows) >= 3,
        tr("{}: {} usable rows; a track needs at least 3", path, len(rows)),
    )
    return Table(rows.reset_index(drop=True), tuple(notes))


def read_gates(path: Path, rig: str) -> Table:
    """Read gates.csv: place of each light gate (x_mm along the path; y_mm, up, of a
    drop), t_s of the seed's centre, sd_s, sd_mm. Rows are sorted by time; gates that
    did not fire (empty cells) are left out and noted. Errors: fewer than LEAST_GATES,
    two passages at one time or of one gate, a seed that turns back, an sd that is not
    positive."""
    where, rows = GATE_PLACE[rig], _read_csv(path)
    rows, notes = _complete(path, rows, (where, "t_s"), GATE_EXTRA)
    rows = rows.sort_values("t_s", kind="stable")
    place = rows[where].to_numpy()
    first = np.append(True, np.diff(rows["t_s"]) > 0)
    _require_each(path, rows, "t_s", first, tr("; keep one"), tr("two gates at "))
    require(
        len(rows) >= LEAST_GATES,
        tr(
            "{}: {} passages; a {} past light gates needs at least {}",
            path,
            len(rows),
            rig,
            LEAST_GATES,
        ),
    )
    wrong = np.diff(place) * np.sign(place[-1] - place[0]) <= 0
    if rig == "drop":  # it passes some gates twice
        wrong = (np.diff(place) > 0) & (
            np.arange(1, len(place)) <= int(np.argmin(place))
        )
    order = tr(" is out of its order; a seed passes the gates one after the other")
    _require_each(path, rows, where, np.append(True, ~wrong), order)
    return Table(rows.reset_index(drop=True), tuple(notes))


def read_impacts_csv(path: Path) -> Table:
    """Read impacts.csv: at least two rows of t_s, strictly increasing, and sd_s if
    known."""
    rows, notes = _complete(path, _read_csv(path), ("t_s",), ("sd_s",))
    later = np.append(True, np.diff(rows["t_s"]) > 0)
    _require_each(path, rows, "t_s", later, tr(" does not increase"))
    require(
        len(rows) >= 2,
        tr("{}: {} impact times; an interval needs two", path, len(rows)),
    )
    return Table(rows.reset_index(drop=True), tuple(notes))


def read_readings(path: Path) -> Table:
    """Read readings.csv: columns of READING_COLUMNS, a row for each repeat, and what a
    row states of its own (`Rig.by_row`, `Rig.in_turn`); impossible values are an
    error."""
    rows = _read_csv(path)
    columns = [c for c in rows.columns if c in READING_COLUMNS]
    require(
        columns,
        tr(
            "{}: no column of readings; expected one of {}, found {}",
            path,
            ", ".join(READING_COLUMNS),
            ", ".join(rows.columns),
        ),
    )
    rigs = [RIGS[READING_COLUMNS[c][0]] for c in columns]
    own = {c for rig in rigs for c in (*rig.by_row, *rig.in_turn) if c in rows}
    _check_columns(path, rows, columns, ("repeat", "note", *own))
    notes: list[str] = []
    for column in columns:
        missing = rows.index[rows[column].isna()]
        if len(missing):
            notes.append(
                tr(
                    "{}: {} is empty in row {}; left out",
                    path.name,
                    column,
                    ", ".join(str(i + 2) for i in missing),
                )
            )
        low, high = _READING_RANGE[READING_COLUMNS[column][2]]
        right = ~((rows[column] <= low) | (rows[column] >= high))
        if column in RIGS[READING_COLUMNS[column][0]].zeros:
            right |= rows[column] == 0
        _require_each(
            path,
            rows,
            column,
            right,
            tr("; it should lie between {:g} and {:g}", low, high),
        )
        require(
            rows[column].notna().sum() != 0, tr("{}: {} holds no numbers", path, column)
        )
    return Table(rows, tuple(notes))


def read_numbers(
    path: Path, needed: Mapping[str, Range], optional: Mapping[str, Range] | None = None
) -> pd.DataFrame:
    """Read the columns `needed` and those of `optional` that are there, {name: (least,
    greatest)}, of a CSV table of numbers. MeasurementError naming file, column and row
    where a column is missing or comes twice, or a cell is empty, no number or outside
    its range."""
    rows = _read_csv(path)
    _check_present(path, rows, needed)
    ranges = {**(optional or {}), **needed}
    rows = rows[[c for c in rows if c in ranges]].copy()
    _to_numbers(path, rows, rows.columns)
    for column in rows:
        low, high = ranges[column]
        limits = tr("it should lie between {:g} and {:g}", low, high)
        if len(empty := rows.index[rows[column].isna()]):
            raise MeasurementError(
                tr(
                    "{}: {} is empty or not finite in row {}; {}",
                    path,
                    column,
                    empty[0] + 2,
                    limits,
                )
            )
        _require_each(
            path, rows, column, rows[column].between(low, high), f"; {limits}"
        )
    return rows


def _read_csv(path: Path) -> pd.DataFrame:
    size = path.stat().st_size
    require(size != 0, tr("{}: the file is empty (0 bytes)", path))
    require(
        size <= MOST_BYTES,
        tr(
            "{}: {:.0f} MB; a table has {:.0f} MB at most",
            path,
            size / 1e6,
            MOST_BYTES / 1e6,
        ),
    )
    with path.open("rb") as file:
        require(
            not any(
                len(line) > LONGEST_LINE
                for line in iter(lambda: file.readline(LONGEST_LINE + 1), b"")
            ),
            tr(
                "{}: not a CSV table (a line of more than {:,} characters)",
                path,
                LONGEST_LINE,
            ),
        )
    column, decimal = _separators_of(path)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error", pd.errors.ParserWarning)
            rows = pd.read_csv(
                path,
                sep=column,
                decimal=decimal,
                skipinitialspace=True,
                comment="#",
                index_col=False,
            )
    except pd.errors.ParserWarning as error:
        message = tr(
            "its rows hold more fields than its heading names; commas separate columns,"
            " numbers have points"
        )
        raise MeasurementError(f"{path}: {message}") from error
    except (
        ValueError,
        OverflowError,
    ) as error:  # pandas' own errors and wrong characters among them
        raise MeasurementError(
            tr("{}: not a CSV table ({})", path, (str(error).splitlines() or [""])[0])
        ) from error
    rows.columns = [str(c).strip() for c in rows.columns]
    if twice := [c for c in rows if f"{c}.1" in rows]:  # pandas' name for the second
        raise MeasurementError(tr("{}: column {} comes twice", path, twice[0]))
    require(not rows.empty, tr("{}: a heading but no rows", path))
    return rows


def separators(heading: str, lines: Sequence[str]) -> tuple[str, str]:
    """What separates the columns of a `heading` (tab, semicolon or comma, " " for white
    space), and the decimal mark in the `lines` below it ("" where it is ambiguous)."""
    column = next((c for c in ("\t", ";", ",") if c in heading), " ")
    if column == ",":
        return ",", "."
    cells = [
        cell.strip('"')
        for line in lines
        for cell in (line.split() if column == " " else line.split(column))
    ]
    point, comma, both = (
        any(kind.fullmatch(cell) for cell in cells)
        for kind in (_WITH_POINT, _WITH_COMMA, _WITH_BOTH)
    )
    return column, "" if both or (point and comma) else "," if comma else "."


def _separators_of(path: Path) -> tuple[str, str]:
    """Separator and decimal mark of a file; MeasurementError where they are
    ambiguous."""
    with path.open(encoding="utf-8-sig", errors="replace") as file:
        lines = [line for line in file if line.strip() and not line.startswith("#")]
    column, decimal = separators(lines[0], lines[1:]) if lines else (",", ".")
    require(
        decimal,
        tr(
            "{}: its columns are separated by {!r}, its numbers written in two"
            " ways; save it with commas, and points in its numbers",
            path,
            column,
        ),
    )
    return ";" if column == " " else column, decimal  # " ": a single column


def _require_each(
    path: Path, rows: pd.DataFrame, column: str, is_right, after: str, before: str = ""
) -> None:
    """MeasurementError for the first row that is not right, with its value and line."""
    if not (right := np.asarray(is_right)).all():
        at = int(np.argmin(right))
        value = tr(
            "{} = {:g} in row {}", column, rows[column].iloc[at], rows.index[at] + 2
        )
        raise MeasurementError(f"{path}: {before}{value}{after}")


def _check_present(path: Path, rows: pd.DataFrame, needed: Iterable[str]) -> None:
    if absent := [c for c in needed if c not in rows]:
        raise MeasurementError(
            tr(
                "{}: column {} is missing; expected {}, found {}",
                path,
                ", ".join(absent),
                ", ".join(needed),
                ", ".join(rows.columns),
            )
        )


def _check_columns(
    path: Path, rows: pd.DataFrame, needed: Sequence[str], extra: Sequence[str]
) -> None:
    """MeasurementError where a column is missing or unknown, or holds words."""
    _check_present(path, rows, needed)
    if unknown := [
        c
        for c in rows
        if c not in needed and c not in extra and c not in READING_COLUMNS
    ]:
        known = (*needed, *extra)
        near = difflib.get_close_matches(unknown[0], known, n=1, cutoff=0.6)
        hint = (
            tr("did you mean {}?", near[0])
            if near
            else tr("known are {}", ", ".join(known))
        )
        raise MeasurementError(tr("{}: unknown column {}; {}", path, unknown[0], hint))
    _to_numbers(path, rows, [c for c in rows if c not in IN_WORDS])


def _check_sds(path: Path, rows: pd.DataFrame) -> None:
    """MeasurementError for a stated sd outside LEAST_SD to GREATEST_SD; an empty cell
    is unknown."""
    limits = tr(
        "; it should be above 0 and no less than {:g}, at most {:g}",
        LEAST_SD,
        GREATEST_SD,
    )
    for column in (c for c in SDS if c in rows):
        right = rows[column].isna() | rows[column].between(LEAST_SD, GREATEST_SD)
        _require_each(path, rows, column, right, limits)


def _to_numbers(path: Path, rows: pd.DataFrame, columns: Iterable[str]) -> None:
    """Convert the columns to floats, NaN where they are not finite."""
    for column in columns:
        values, long = rows[column], rows[column].dtype == object  # integers
        numbers = pd.to_numeric(values.astype(str) if long else values, errors="coerce")
        finite = numbers.where(np.isfinite(numbers)).astype(float)
        words = ((finite if long else numbers).isna() & values.notna()).to_numpy()
        if words.any():
            row = int(np.argmax(words))
            raise MeasurementError(
                tr(
                    "{}: {} = {} in row {} is not a number",
                    path,
                    column,
                    reprlib.repr(rows[column].iloc[row]),
                    row + 2,
                )
            )
        rows[column] = finite
        _require_each(
            path, rows, column, ~(rows[column].abs() > LARGEST), tr(" cannot be")
        )


def _complete(
    path: Path, rows: pd.DataFrame, columns: Sequence[str], extra: Sequence[str]
) -> tuple[pd.DataFrame, list[str]]:
    """The rows with a finite value in `columns`, those left out told by line number
    (the heading being line 1). Errors as of the columns and their sds."""
    _check_columns(path, rows, columns, extra)
    _check_sds(path, rows)
    usable = np.isfinite(rows[[*columns]].to_numpy(dtype=float)).all(axis=1)
    if usable.all():
        return rows, []
    require(usable.any(), tr("{}: no row has numbers in {}", path, ", ".join(columns)))
    lines = [str(i + 2) for i in rows.index[~usable]]
    more = tr(" and {} more", len(lines) - 5) if len(lines) > 5 else ""
    shown = ", ".join(lines[:5]) + more
    return rows[usable], [tr("{}: no number in row {}; left out", path.name, shown)]
