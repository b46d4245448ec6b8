"""phyphox: acoustic stopwatch → impact times; acceleration with g → tilt. .xls, .xlsx,
a .zip of CSV, or one CSV, in any language.

The app translates its headings but not its units, so tables are recognised by their
units and the relations of their columns."""

import numpy as np

from benchtwin.vision.foreign.accelerometer import AXES, plate_tilt
from benchtwin.vision.foreign.contents import Contents
from benchtwin.vision.foreign.source import TIME, Rows, Source, column, heading_and_unit
from benchtwin.vision.measurement import MeasurementError, require

TOOL = "phyphox"
_ACCELERATION = ("m/s^2", "m/s²", "m/s2")
ROUNDED_S = 2e-3  # between an interval and the difference of its times, due to rounding
_OTHER = "acoustic stopwatch or acceleration (with g)"


def recognises(source: Source) -> bool:
    """Whether a file is of this kind, by its name and its first lines."""
    names = source.members if source.is_packed else ()
    meta = any(name.split("/")[-2:-1] == ["meta"] for name in names) or (
        source.is_workbook and any(n.startswith("Metadata") for n in source.sheets)
    )
    return meta or any(map(_kind, source.heads))


def read(source: Source) -> Contents:
    """Impact times, or a plate's angle, from the export's sheets."""
    tables = {
        name: rows for name, rows in source.sheets.items() if "meta" not in name.lower()
    }
    kinds = {name: _kind(rows) for name, rows in tables.items()}
    for kind in ("events", "stops", "single"):
        runs = [
            (name if k == 0 else f"{name} {k + 1}", run)
            for name in tables
            if kinds[name] == kind
            for k, run in enumerate(_runs(source, tables[name], kind))
        ]
        heard = [(name, run) for name, run in runs if len(run) > 1]
        if runs:
            named = tuple((n if len(heard) > 1 else "", run) for n, run in heard)
            guess = "times as the phone's microphone heard them"
            return Contents(TOOL, runs=named, guesses=(guess,))
    if name := next((n for n in tables if kinds[n] == "acceleration"), ""):
        rows = tables[name]
        time, *axes = (
            column(source.path, rows[1:], k, str(rows[0][k]), 2) for k in range(4)
        )
        return plate_tilt(source.path, TOOL, time, np.array(axes).T)
    headings = {name: ", ".join(map(str, r[0])) for name, r in tables.items() if r}
    held = "; ".join(f"{name}: {words}"[:120] for name, words in headings.items())
    raise MeasurementError(
        f"{source.path}: no {_OTHER} in it; it holds {held[:300] or 'nothing'}"
    )


def _kind(rows: Rows) -> str:
    """events: times and the intervals after them; stops: a start and many stops;
    single: one start, stop, difference; acceleration."""
    if (
        len(rows) < 2
        or not rows[0]
        or not any(isinstance(cell, float) for cell in rows[1])
    ):
        return ""
    units = [heading_and_unit(heading)[1] for heading in rows[0]]
    numbers = [cell for cell in rows[1] if isinstance(cell, float)]
    axes = units[1 : 1 + AXES]
    if units[0] == "s" and len(axes) == AXES and {*axes} <= {*_ACCELERATION}:
        return "acceleration"
    if units[0] not in TIME or {*units} - {*TIME, ""} or len(numbers) < 2:
        return ""
    if len(rows) == 2 and len(units) == len(numbers) == 3:
        if abs(numbers[1] - numbers[0] - numbers[2]) < 1e-6:
            return "single"
    elif len(rows) == 2 and len(numbers) > 3 and (np.diff(numbers) >= 0).all():
        return "stops"
    following = rows[2][0] if len(rows) > 2 and rows[2] else None
    follows = isinstance(following, float) and (
        abs(following - numbers[0] - numbers[1]) < ROUNDED_S
    )
    return "events" if follows else ""


def _runs(source: Source, rows: Rows, kind: str) -> list[np.ndarray]:
    """Impact times [s] of each run in a table."""
    units = [heading_and_unit(h)[1] for h in rows[0]]
    require(
        {*units} <= {"s", ""},
        f"{source.path}: its times are in {units[0]}; phyphox writes seconds (s)",
    )
    wide = max(len(row) for row in rows)
    columns = [
        column(source.path, rows[1:], k, str(rows[0][k]) if k < len(rows[0]) else "", 2)
        for k in range(wide)
    ]
    if kind == "single":
        return [np.array([columns[0][0], columns[1][0]])]
    if kind == "stops":
        times = np.array([c[0] for c in columns])
        return [times[np.isfinite(times) & (times > 0)]]
    # there may be empty columns between
    runs = []
    stated = [k for k, unit in enumerate(units) if unit]
    for k in (k for k in stated[::2] if k + 1 < wide):
        known = np.isfinite(columns[k]) & np.isfinite(columns[k + 1])
        time, gap = columns[k][known], columns[k + 1][known]
        if len(time):
            # an interval of 0 marks the last event
            last = [time[-1] + gap[-1]] if gap[-1] > 0 else []
            runs.append(np.append(time, last))
    return runs
