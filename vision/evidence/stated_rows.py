"""Readings whose rows state a key of their rig each: the height of each drop, or which
bounce of one drop was read."""

from dataclasses import replace

import numpy as np
import pandas as pd
from pydantic import ValidationError

from benchtwin.bench.rigs import RIGS
from benchtwin.vision.evidence.tables import Table
from benchtwin.vision.measurement import MeasurementError
from benchtwin.vision.recording import Recording

LEAST_IN_TURN, LEAST_FACTOR = 3, 2.0


def rows_alike(
    recording: Recording, rig: str, table: Table
) -> list[tuple[Recording, pd.DataFrame]]:
    """The rows that state the same, each with the recording as they state it, in the
    order of the table; all rows where none states anything."""
    rows, known = table.rows, RIGS[rig]
    if known.in_turn and known.in_turn[0] in rows:
        rows = _each_from_the_last(recording, rig, rows)
        recording = _stating(recording, rig, {known.in_turn[1]: None}, rows)
    columns = [c for c in known.by_row if c in rows]
    if not columns:
        return [(recording, rows)]
    groups = rows.groupby(columns, dropna=False, sort=False)
    parts = []
    for level, part in groups:
        named = zip(columns, level, strict=True)
        stated: dict[str, float | None] = {
            c: float(v) for c, v in named if np.isfinite(v)
        }
        parts.append((_stating(recording, rig, stated, part), part))
    return parts


def falls_in_turn(values: np.ndarray) -> str:
    """A doubt where readings fall from each to the next to less than a half, which
    repeats of one thing do not; ""."""
    falls = len(values) >= LEAST_IN_TURN and (np.diff(values) < 0).all()
    if not falls or values[0] < LEAST_FACTOR * values[-1]:
        return ""
    return (
        f"each reading is lower than the one before, from {values[0]:g} to"
        f" {values[-1]:g}: no repeats of one thing? Successive bounces need a column"
        " bounce"
    )


def _stating(
    recording: Recording, rig: str, known: dict[str, float | None], rows: pd.DataFrame
) -> Recording:
    """The recording with these keys of its rig's section."""
    section = getattr(recording, rig)
    try:
        told = type(section)(**section.model_dump(exclude_none=True) | known)
    except ValidationError as error:
        wrong = error.errors()[0]
        message = f"{recording.files[0]}: {wrong['loc'][0]} = {wrong['input']} in row"
        raise MeasurementError(
            f"{message} {rows.index[0] + 2}: {wrong['msg']}"
        ) from error
    return replace(recording, **{rig: told})


def _each_from_the_last(
    recording: Recording, rig: str, rows: pd.DataFrame
) -> pd.DataFrame:
    """The rows with the key that each states for the next one, by their number; row 0
    states it for the first. A number that does not rise begins a new series."""
    number, key = RIGS[rig].in_turn
    column = next(iter(RIGS[rig].readings))
    count, value = rows[number].to_numpy(float), rows[column].to_numpy(float)
    if not (np.isfinite(count) & (count >= 0) & (count == np.round(count))).all():
        raise MeasurementError(f"{recording.files[0]}: {number} counts 1, 2, 3 …")
    begins = [getattr(getattr(recording, rig), key) or np.nan]
    if key in rows:
        begins = rows[key].to_numpy(float)
    before = np.full(len(rows), np.nan)
    for k, n in enumerate(count):
        if n == 1:
            before[k] = begins[k % len(begins)]
        if k and count[k - 1] == n - 1:
            before[k] = value[k - 1]
    return rows.assign(**{key: before})[count > 0]
