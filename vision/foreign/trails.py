"""Columns of times and places → trails: gaps left out, rows in order, two rows of one time refused."""

from pathlib import Path

import numpy as np

from vision.foreign.found import Trail
from vision.measurement import MeasurementError

LEAST_ROWS = 3
LARGEST = 1e9  # of a place or time, in any unit


def trail(path: Path, name: str, time: np.ndarray, x: np.ndarray, y: np.ndarray) -> Trail | None:
    """A trail of the rows that are whole; None where fewer than LEAST_ROWS are. x to the right, y up."""
    there = np.isfinite(time) & np.isfinite(x) & np.isfinite(y)
    time, x, y = time[there], x[there], y[there]
    if len(time) < LEAST_ROWS:
        return None
    if max(np.abs(x).max(), np.abs(y).max(), np.abs(time).max()) > LARGEST:
        raise MeasurementError(f"{path}: {name or 'the track'} holds a place or time above {LARGEST:g}, which cannot be")
    order = np.argsort(time, kind="stable")
    time, x, y = time[order], x[order], y[order]
    if (twice := np.flatnonzero(np.diff(time) == 0)).size:
        same = np.append(np.diff(time) == 0, False) & np.append((np.diff(x) == 0) & (np.diff(y) == 0), False)
        if same.sum() < twice.size:
            raise MeasurementError(f"{path}: {name or 'the track'} has two places at the time {time[twice[0]]:g}; keep one")
        time, x, y = time[~same], x[~same], y[~same]
    return Trail(name, time, x, y) if len(time) >= LEAST_ROWS else None


def some(path: Path, found: list[Trail | None]) -> tuple[Trail, ...]:
    """Those that are there; MeasurementError where none is."""
    there = tuple(t for t in found if t is not None)
    if not there:
        raise MeasurementError(f"{path}: no track of {LEAST_ROWS} or more places")
    return there
