"""Angle of a plate from the accelerometer of a phone that lies on it; CSV with a column
of time and three of acceleration.

At rest an accelerometer measures gravity, whose angle to the phone's z axis is that of
the plate."""

import re
from itertools import takewhile
from pathlib import Path

import numpy as np
import pandas as pd

from benchtwin.bench.constants import G_M_S2
from benchtwin.vision.foreign.contents import Asked, Contents
from benchtwin.vision.foreign.source import TIME, Source, column, heading_and_unit
from benchtwin.vision.measurement import require

TOOL = "accelerometer table"
AXES = 3
_AXIS = re.compile(r"(.*?)[ _]?([xyz])")
_TIME = re.compile(r"\bt\b|time|elapsed|timestamp|since")
_SINCE = re.compile(r"since|elapsed")
_KNOWN = {"seconds_elapsed": "s", "seconds": "s"}  # times whose name is their unit
_UNITS = ("g", "m/s^2", "m/s²", "m/s2")
# of the rise: from the start and from the end, between which the rate is fitted
_TURNING = 0.15


def recognises(source: Source) -> bool:
    """Whether a file is of this kind, by its name and its first lines."""
    head = source.first_rows if source.is_text else []
    return (
        len(head) > 2
        and len(_axes(head[0])) == AXES
        and any(_TIME.search(str(h).lower()) for h in head[0])
    )


def read(source: Source) -> Contents:
    """The plate's tilt over the file's times; MeasurementError where no column of time
    says its unit."""
    path, rows = source.path, source.rows
    headings = [str(h).lower() for h in rows[0]]
    axes = _axes(rows[0])
    clocks = [
        k
        for k, h in enumerate(headings)
        if _TIME.search(h)
        and _unit_of_time(h) in TIME
        and any(len(row) > k and isinstance(row[k], float) for row in rows[1:3])
    ]
    require(
        clocks,
        f"{path}: no column of time says its unit; write it behind the name, such"
        " as time (s) or timestamp (ms)",
    )

    def likeness(k: int) -> tuple[int, bool, int]:
        """Of several clocks the one named like the sensor is its own."""
        pairs = zip(headings[k], headings[axes[0]])
        alike = len([*takewhile(lambda pair: pair[0] == pair[1], pairs)])
        return alike, bool(_SINCE.search(headings[k])), -k

    best = max(clocks, key=likeness)
    time = column(path, rows[1:], best, headings[best], 2)
    measured = np.array([column(path, rows[1:], k, headings[k], 2) for k in axes]).T
    if {heading_and_unit(rows[0][k])[1] for k in axes} <= {"g"}:
        measured *= G_M_S2
    return plate_tilt(path, TOOL, time * TIME[_unit_of_time(headings[best])], measured)


def plate_tilt(
    path: Path, tool: str, time: np.ndarray, measured: np.ndarray
) -> Contents:
    """Tilt of a plate from the acceleration of a phone on it: time [s] (n,), measured
    [m/s²] or [g] (n, 3)."""
    known = np.isfinite(time) & np.isfinite(measured).all(axis=1)
    time, measured = time[known], measured[known]
    require(
        len(time) >= 10 and np.ptp(time) > 0,
        f"{path}: {len(time)} rows of acceleration; a tilt needs at least 10",
    )
    order = np.argsort(time, kind="stable")
    time, measured = time[order] - time.min(), measured[order]
    size = float(np.median(np.linalg.norm(measured, axis=1)))
    if 0.8 < size < 1.2:
        measured, size = measured * G_M_S2, size * G_M_S2
    require(
        0.8 * G_M_S2 < size < 1.2 * G_M_S2,
        f"{path}: an acceleration of {size:.3g} m/s² at rest, so gravity is not in"
        " it; record the acceleration with g for a tilt",
    )
    angle = np.degrees(
        np.arctan2(np.hypot(measured[:, 0], measured[:, 1]), np.abs(measured[:, 2]))
    )
    table = pd.DataFrame({"t_s": time, "tilt_deg": angle}).drop_duplicates("t_s")
    keys, up = _rise(table["t_s"].to_numpy(), table["tilt_deg"].to_numpy())
    flat = (
        "the phone lies flat on the plate: its angle is the one between its z axis and"
        " gravity"
    )
    motion = (
        "it holds the plate's angle, no motion of the seeds: put their video or"
        " track.csv into the folder, its tilt_deg on its own clock"
    )
    stopped = (
        f"was the plate stopped when the seeds slid? Then {up:.4g}° is the angle of"
        " sliding: write it to readings.csv as slide_angle_deg"
    )
    sections = {"slide": keys} if keys else {}
    questions = (Asked(motion), Asked(stopped))
    return Contents(
        tool, tilt=table, keys=sections, guesses=(flat,), questions=questions
    )


def _rise(time: np.ndarray, angle: np.ndarray) -> tuple[dict[str, float], float]:
    """Keys start_deg and tilt_rate_deg_s of a plate that is raised steadily (else
    none), and the angle at which it stops."""
    wide = max(1, len(angle) // 100)
    smooth = np.convolve(angle, np.ones(wide) / wide, "valid")
    middle = time[wide // 2 : wide // 2 + len(smooth)]
    start = float(np.median(smooth[: max(3, len(smooth) // 20)]))
    up = float(smooth.max())
    first_rows = int(np.argmax(smooth >= up - _TURNING * (up - start)))
    rising = np.flatnonzero(smooth[: first_rows + 1] < start + _TURNING * (up - start))
    first = int(rising[-1]) if rising.size else 0
    if up - start < 3 or first_rows - first < 5:
        return {}, up
    t, raised = middle[first:first_rows], smooth[first:first_rows]
    fit = np.polyfit(t, raised, 1)
    straight = np.std(raised - np.polyval(fit, t)) < 0.05 * (up - start)
    if not (straight and 0 < fit[0] < 1000):
        return {}, up
    keys = {"tilt_rate_deg_s": float(f"{fit[0]:.4g}")}
    return keys | ({"start_deg": round(start, 2)} if 0 <= start < 80 else {}), up


def _axes(headings: list) -> list[int]:
    """Columns of acceleration along x, y and z; [] unless there is one of each."""
    found: dict[str, dict[str, int]] = {}
    # x, y, z of Sensor Logger; elsewhere they are places
    bare = ("a", "") if "seconds_elapsed" in headings else ("a",)
    for k, heading in enumerate(headings):
        name, unit = heading_and_unit(heading)
        axis = _AXIS.fullmatch(name)
        if axis and (
            unit in _UNITS
            or axis[1] in bare
            or any(word in name for word in ("acc", "gf", "grav"))
        ):
            found.setdefault(axis[1], {})[axis[2]] = k
    whole = [axes for axes in found.values() if len(axes) == AXES]
    return [whole[0][axis] for axis in "xyz"] if whole else []


def _unit_of_time(heading: str) -> str:
    name, unit = heading_and_unit(heading)
    return unit or _KNOWN.get(name, "")
