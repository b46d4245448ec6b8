"""Tables of times and places, whoever wrote them: Tracker, MTrack2, Viana, a script.

A table is told by its headings: a time or frame number, and x and y of each object or
one length alone ("t, x, y", "Zeit (in s)", "x / cm", "X1", "Objekt 1 x-Koordinate").
Lines above the headings may name the objects; lines of words among the numbers are
passed over; numbers have a point or a comma."""

import re
from dataclasses import dataclass

import numpy as np
from benchtwin.vision.evidence.tables import TRACK_COLUMNS, TRACK_COLUMNS_PX
from benchtwin.vision.foreign.contents import Contents, PointTrack, point_track
from benchtwin.vision.foreign.source import (
    LENGTH,
    PIXELS,
    TIME,
    Rows,
    Source,
    column,
    name_and_unit,
)
from benchtwin.vision.foreign.unit_inference import infer_units
from benchtwin.vision.measurement import MeasurementError

TOOL = "table of places"
CLOCKS = re.compile("t|times?|zeit|temps|tiempo|tempo|tid|tijd|czas|čas|aika|idő")
COUNTS = re.compile("frames?|step|n|slice|bild|index|nr|no")
HEIGHTS = re.compile("y|h|height|höhe|hoehe|hauteur|altura|altezza|z")
BESIDE_A_NAME = re.compile(
    "obje[kc]?t|objeto|oggetto|track|point|punkt|particle|ball|mass|[abc]"
    "|koordinate|coord|coordinates?|coordonnée|coordenada|coordinata"
    "|position|pos|posición|posizione|ort|centroid|cent(er|re)|of|in"
)
MOST_ABOVE = 40  # lines above the headings
_WAY = re.compile("x")
_WORDS = re.compile(r"[^\W\d_]+|\d+")
_OVER = re.compile(r"(.+?)\s*/\s*(?:in\s+)?(\S+)")  # "t/s", "x / cm"


@dataclass(frozen=True)
class Heading:
    """What a column holds: clock, count, x, y or "" for anything else; its unit."""

    holds: str
    unit: str


def parsed(heading: object) -> Heading:
    """The heading of a column.

    >>> parsed("Zeit (in s)"), parsed("Objekt 1 x-Koordinate"), parsed("X1")
    (Heading(holds='clock', unit='s'), Heading(holds='x', unit=''), \
Heading(holds='x', unit=''))
    >>> parsed("y / cm"), parsed("x_mm"), parsed("x-Geschwindigkeit").holds
    (Heading(holds='y', unit='cm'), Heading(holds='x', unit='mm'), '')
    """
    name, unit = name_and_unit(heading)
    unit = unit.removeprefix("in ").strip()
    if not unit and (over := _OVER.fullmatch(name)):
        name, unit = over[1], over[2]
    bare, _, end = name.rpartition("_")
    if not unit and bare and (end in TIME or end in LENGTH or end in PIXELS):
        name, unit = bare, end
    words = [w for w in _WORDS.findall(name) if not w.isdigit()]
    kept = [w for w in words if not BESIDE_A_NAME.fullmatch(w)]
    if len(kept) != 1:
        return Heading("", unit)
    kinds = {"clock": CLOCKS, "count": COUNTS, "x": _WAY, "y": HEIGHTS}
    held = (kind for kind, called in kinds.items() if called.fullmatch(kept[0]))
    return Heading(next(held, ""), unit)


def heading_row(rows: Rows) -> int:
    """Row of the headings, −1 where there are none: a time and a place, numbers
    below; with one length, nothing but that length and the time."""
    for k, row in enumerate(rows[:MOST_ABOVE]):
        held = [parsed(cell).holds for cell in row if isinstance(cell, str)]
        below = (sum(isinstance(c, float) for c in r) >= 2 for r in rows[k + 1 : k + 4])
        timed = "clock" in held or "count" in held
        place = {"x", "y"} <= {*held} or (len({*held} & {"x", "y"}) == 1 and all(held))
        if timed and place and any(below):
            return k
    return -1


def recognises(source: Source) -> bool:
    """Whether a file is of this kind, by its first lines; no table of ours."""
    if not source.is_text:
        return False
    head = source.first_rows
    at = heading_row(head)
    own = (TRACK_COLUMNS[1:], TRACK_COLUMNS_PX[1:])
    return at >= 0 and not any({*names} <= {*map(str, head[at])} for names in own)


def read(source: Source) -> Contents:
    """The table's tracks, with the units that its headings name. A single length is
    the height, or the way where it is called x."""
    rows, path = source.rows, source.path
    at = heading_row(rows)
    if at < 0:
        raise MeasurementError(f"{path}: no heading names a time and a place")
    headings = [parsed(h) for h in rows[at]]
    numbers = [r for r in rows[at + 1 :] if any(isinstance(c, float) for c in r)]
    above = [row for row in rows[:at] if not str(row[0]).startswith("#")]
    names = [str(cell).strip() for cell in above[-1]] if above else []  # of the tracks
    times, xs, ys = (_columns(headings, *h) for h in (("clock", "count"), "x", "y"))
    if xs and ys and len(xs) != len(ys):
        raise MeasurementError(
            f"{path}: {len(xs)} columns x and {len(ys)} columns y; each track has one"
            " of both"
        )
    tracks: list[PointTrack | None] = []
    for k in range(max(len(xs), len(ys))):
        here = [columns[k] for columns in (xs, ys) if columns]
        left = [t for t in times if t < min(here)] or times
        seconds = [t for t in left if headings[t].holds == "clock"]
        when = (seconds or left)[-1]
        t, *places = (
            column(path, numbers, c, str(rows[at][c]), at + 2) for c in (when, *here)
        )
        x, y = places if len(places) == 2 else _one_length(places[0], bool(xs))
        name = next((n for n in reversed(names[: min(here) + 1]) if n), "")
        tracks.append(point_track(path, name, t, x, y))
    clocks = _columns(headings, "clock") or times[:1]
    held = [(headings[t].unit, headings[t].holds) for t in clocks]
    time_unit = _one_unit(
        path, {unit or ("frame" if kind == "count" else "") for unit, kind in held}
    )
    length_unit = _one_unit(path, {headings[c].unit for c in (*xs, *ys)})
    guesses = []
    if not (xs and ys):
        guesses.append(
            "one length a row: taken as the "
            + ("way x along a straight line" if xs else "height y")
        )
    return infer_units(path, TOOL, tracks, time_unit, length_unit, "", guesses=guesses)


def _columns(headings: list[Heading], *held: str) -> list[int]:
    return [k for k, h in enumerate(headings) if h.holds in held]


def _one_length(length: np.ndarray, is_x: bool) -> tuple[np.ndarray, np.ndarray]:
    other = np.where(np.isnan(length), np.nan, 0.0)
    return (length, other) if is_x else (other, length)


def _one_unit(path: object, units: set[str]) -> str:
    if len(units) > 1:
        raise MeasurementError(
            f"{path}: its columns have several units; x and y of all tracks are to have"
            " one, and t one"
        )
    return units.pop()
