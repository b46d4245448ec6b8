"""Tables of t, x, y as Tracker exports or copies them, or written alike by hand or
script.

Tracker's rows: "#multi:" before several tracks, a row of their names, the headings (t,
x, y, …; the time once or once a track), then numbers separated by tab, comma, semicolon
or space, with a point or a comma. It names no units."""

from benchtwin.vision.evidence.tables import TRACK_COLUMNS, TRACK_COLUMNS_PX
from benchtwin.vision.foreign.contents import Contents, PointTrack, point_track
from benchtwin.vision.foreign.source import (
    LENGTH,
    PIXELS,
    TIME,
    Source,
    column,
    heading_row,
    name_and_unit,
)
from benchtwin.vision.foreign.unit_inference import infer_units
from benchtwin.vision.measurement import MeasurementError

TOOL = "Tracker table"
_TIMES = ("t", "time", "frame", "step", "n")
_PLACES = ("x", "y")


def recognises(source: Source) -> bool:
    """Whether a file is of this kind, by its name and its first lines."""
    if not source.is_text:
        return False
    head = source.first_rows
    row = heading_row(head)
    if (
        row < 0
        or row + 1 >= len(head)
        or {*TRACK_COLUMNS[1:]} <= set(head[row])
        or {*TRACK_COLUMNS_PX[1:]} <= set(head[row])
    ):
        return False
    names = [parsed(h)[0] for h in head[row]]
    return (
        any(n in _TIMES for n in names)
        and all(n in names for n in _PLACES)
        and isinstance(head[row + 1][0], float)
    )


def parsed(heading: object) -> tuple[str, str]:
    """Name and unit of a heading: "x", "x (cm)", "x_cm", "t [ms]"."""
    name, unit = name_and_unit(heading)
    bare, _, end = name.rpartition("_")
    if (
        not unit
        and bare in (*_TIMES, *_PLACES)
        and (end in TIME or end in LENGTH or end in PIXELS)
    ):
        return bare, end
    return name, unit


def read(source: Source) -> Contents:
    """The table's tracks, with the units that its headings name."""
    rows = source.rows
    at = heading_row(rows)
    headings = [parsed(h) for h in rows[at]]
    numbers = rows[at + 1 :]
    above = [row for row in rows[:at] if not str(row[0]).startswith("#")]
    names = [str(cell).strip() for cell in above[-1]] if above else []  # of the tracks
    xs, ys = (
        [k for k, (name, _) in enumerate(headings) if name == place]
        for place in _PLACES
    )
    times = [k for k, (name, _) in enumerate(headings) if name in _TIMES]
    if len(xs) != len(ys):
        raise MeasurementError(
            f"{source.path}: {len(xs)} columns x and {len(ys)} columns y; each track"
            " has one of both"
        )
    tracks: list[PointTrack | None] = []
    for x, y in zip(xs, ys):
        left = [t for t in times if t < min(x, y)] or times
        seconds = [t for t in left if headings[t][0] in ("t", "time")]
        when = (seconds or left)[-1]
        t, px, py = (
            column(source.path, numbers, k, headings[k][0], at + 2)
            for k in (when, x, y)
        )
        name = next((n for n in reversed(names[: min(x, y) + 1]) if n), "")
        tracks.append(point_track(source.path, name, t, px, py))
    clocks = [t for t in times if headings[t][0] in ("t", "time")] or times[:1]
    counted = ("frame", "step", "n")
    unit_of_time = {
        headings[t][1] or ("frame" if headings[t][0] in counted else "") for t in clocks
    }
    unit_of_length = {headings[k][1] for k in (*xs, *ys)}
    if len(unit_of_time) > 1 or len(unit_of_length) > 1:
        raise MeasurementError(
            f"{source.path}: its columns have several units; x and y of all tracks are"
            " to have one, and t one"
        )
    time_unit, length_unit = unit_of_time.pop(), unit_of_length.pop()
    return infer_units(source.path, TOOL, tracks, time_unit, length_unit, "")
