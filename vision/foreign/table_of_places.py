"""Tables of times and places, whoever wrote them: Tracker, MTrack2, Viana, a script, a
spreadsheet.

A table is told by its headings: a time or frame number, and x and y of each object or
lengths alone ("t, x, y", "Zeit (in s)", "x / cm", "X1", "Objekt 1 x-Koordinate").
Lines above the headings may name the objects, a line below them the units; lines that
do not hold a time are passed over, and the table ends where time begins again behind
such; numbers have a point or a comma. Numbers without headings are t and y, or t, x and
y, if something falls freely in them."""

import re
from dataclasses import dataclass
from itertools import zip_longest

import numpy as np

from benchtwin.vision.evidence.tables import TRACK_COLUMNS, TRACK_COLUMNS_PX
from benchtwin.vision.foreign.contents import LEAST_ROWS, Tracked
from benchtwin.vision.foreign.source import (
    LENGTH,
    UNITS,
    Cell,
    Rows,
    Source,
    column,
    heading_and_unit,
)
from benchtwin.vision.foreign.unit_inference import free_fall
from benchtwin.vision.measurement import require

TOOL = "table of places"
CLOCKS = re.compile(
    "t|times?|zeit|temps|tiempo|tempo|tid|tijd|czas|čas|aika|idő|время|时间|時間"
)
COUNTS = re.compile("frames?|step|n|slice|bild|index|nr|no")
HEIGHTS = re.compile(
    "y|h|height|höhe|hoehe|hauteur|altura|altezza|wysokość|hoogte|höjd|højde|høyde"
    "|výška|magasság|высота|高度|高さ|z"
)
ALONG = re.compile(  # lengths of which only their sign tells where up is
    "position|posición|posizione|posição|pos|ort|weg|distance|distancia|distanza"
    "|abstand|displacement|pozycja|položení|afstand|положение|位置"
)
BESIDE_A_NAME = re.compile(
    "obje[kc]?t|objeto|oggetto|track|point|punkt|particle|ball|mass|[abc]"
    "|koordinate|coord|coordinates?|coordonnée|coordenada|coordinata"
    "|centroid|cent(er|re)|of|in|en|em|run|trial|versuch|messung"
)
MOST_ABOVE = 40  # lines above the headings
PLACES = {"x", "y", "length"}
_WAY = re.compile("x")
_MARK = re.compile(r"flag\d*")
_WORDS = re.compile(r"[^\W\d_]+|\d+")


@dataclass(frozen=True)
class Heading:
    """What a column holds: clock, count, x, y, length or "" for anything else; its
    unit."""

    holds: str
    unit: str


def parsed(heading: object) -> Heading:
    """The heading of a column.

    >>> parsed("Zeit (in s)"), parsed("Objekt 1 x-Koordinate"), parsed("X1")
    (Heading(holds='clock', unit='s'), Heading(holds='x', unit=''), \
Heading(holds='x', unit=''))
    >>> parsed("y / cm"), parsed("x_mm"), parsed("Zeit in Sekunden")
    (Heading(holds='y', unit='cm'), Heading(holds='x', unit='mm'), \
Heading(holds='clock', unit='sekunden'))
    >>> parsed("Trial 1 (m)"), parsed("x-Geschwindigkeit").holds
    (Heading(holds='length', unit='m'), '')
    """
    name, unit = heading_and_unit(heading)
    words = [w for w in _WORDS.findall(name) if not w.isdigit()]
    kept = [w for w in words if not BESIDE_A_NAME.fullmatch(w)]
    if len(kept) > 1:  # "position x"
        kept = [w for w in kept if not ALONG.fullmatch(w)]
    if len(kept) > 1:
        return Heading("", unit)
    if not kept:
        return Heading("length" if words and unit in LENGTH else "", unit)
    kinds = {"clock": CLOCKS, "count": COUNTS, "x": _WAY, "y": HEIGHTS, "length": ALONG}
    held = (kind for kind, called in kinds.items() if called.fullmatch(kept[0]))
    return Heading(next(held, ""), unit)


def headings_of(rows: Rows) -> tuple[int, list[Heading]]:
    """Row of the headings and what they say, with the units in a line below; −1 where
    there are none: a time and a place, numbers below; with lengths alone, nothing but
    these and the time."""
    for k, row in enumerate(rows[:MOST_ABOVE]):
        found = _parsed_row(row, rows[k + 1] if k + 1 < len(rows) else [])
        below = (sum(isinstance(c, float) for c in r) >= 2 for r in rows[k + 1 : k + 4])
        held = [h.holds for h in found]
        alone = {*held} - {"clock", "count"}
        place = {"x", "y"} <= alone or (len(alone) == 1 and alone <= PLACES)
        counted = "count" in held and alone != {"length"}  # distances, numbered
        if place and ("clock" in held or counted) and any(below):
            return k, found
    return -1, []


def _parsed_row(row: list[Cell], below: list[Cell]) -> list[Heading]:
    """The headings of a row, with the units in the line below where it holds such."""
    words = [c.strip("()[] ").lower() if isinstance(c, str) else "?" for c in below]
    if not {*words} & UNITS or {*words} - UNITS - {""}:
        words = []
    return [
        (parsed(f"{cell} ({unit})") if unit else parsed(cell))
        if isinstance(cell, str)
        else Heading("", "")
        for cell, unit in zip_longest(row, words[: len(row)], fillvalue="")
    ]


def recognises(source: Source) -> bool:
    """Whether a file is of this kind, by its first lines; no table of ours."""
    if source.is_xml or source.is_packed:
        return False
    own = (TRACK_COLUMNS[1:], TRACK_COLUMNS_PX[1:])
    for head in source.heads:
        at, _ = headings_of(head)
        if at >= 0:
            return not any({*names} <= {*map(str, head[at])} for names in own)
    return bool(_bare(source))


def read(source: Source) -> Tracked:
    """The tracks of all tables, with the units that their headings name. A single
    length is the height, or the way where it is called x."""
    path = source.path
    tracks: list[tuple[str, np.ndarray]] = []
    units: list[tuple[str, str]] = []
    alone: set[str] = set()
    bare = _bare(source)
    for sheet, rows in source.sheets.items():
        rows = rows if bare else _without_marks(rows)
        at, headings = (0, bare) if bare else headings_of(rows)
        if at >= 0:
            name = sheet if len(source.sheets) > 1 else ""
            tracks += _tracks(source, name, rows, at, headings)
            units.append(_units(source, headings))
            alone |= {h.holds for h in headings} & PLACES
    require(units, f"{path}: no heading names a time and a place")
    time_unit, length_unit = (_one_unit(source, {*unit}) for unit in zip(*units))
    guesses, one_length = [], not {"x", "y"} <= alone
    if bare:
        held = ", ".join("t" if h.holds == "clock" else h.holds for h in bare)
        guesses.append(f"no headings: the {len(bare)} columns are {held}")
    if one_length:
        guesses.append(
            "one length a row: taken as the "
            + ("way x along a straight line" if "x" in alone else "height y")
        )
    several = one_length or len(units) > 1
    return Tracked(tracks, time_unit, length_unit, guesses=guesses, repeats=several)


def _bare(source: Source) -> list[Heading]:
    """What the columns of a text without headings hold; [] unless time runs in the
    first and something falls freely in the last."""
    head = source.first_rows
    wide = len(head[0])
    numbers = all(len(r) == wide and all(isinstance(c, float) for c in r) for r in head)
    if not (source.is_text and wide in (2, 3) and len(head) >= LEAST_ROWS and numbers):
        return []
    rows = [r for r in source.rows if len(r) == wide and isinstance(r[0], float)]
    time, *places = (column(source.path, rows, k, "a place", 1) for k in range(wide))
    across = places[0] if wide == 3 else np.zeros(len(rows))
    runs = (np.diff(time) > 0).all()
    if not runs or free_fall(time, across, places[-1]) is None:
        return []
    names = ("clock", "y") if wide == 2 else ("clock", "x", "y")
    return [Heading(name, "") for name in names]


def _tracks(
    source: Source, sheet: str, rows: Rows, at: int, headings: list[Heading]
) -> list[tuple[str, np.ndarray]]:
    """The tracks of one table; sheet: its name, "" where it is the only one."""
    path = source.path
    first = at + any(isinstance(cell, str) for cell in rows[at])
    above = [r for r in rows[:at] if r and not str(r[0]).startswith("#")]
    names = [str(cell).strip() for cell in above[-1]] if above else []  # of the tracks
    times, xs = _columns(headings, "clock", "count"), _columns(headings, "x")
    numbers = _of_numbers(rows[first:], times)
    ys = _columns(headings, "y") or ([] if xs else _columns(headings, "length"))
    require(
        not xs or not ys or len(xs) == len(ys),
        f"{path}: {len(xs)} columns x and {len(ys)} columns y; each track has one"
        " of both",
    )
    tracks = []
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
        named = " ".join(filter(None, (sheet, name)))
        tracks.append((named, np.column_stack([t, x, y])))
    return tracks


def _without_marks(rows: Rows) -> Rows:
    """Rows without columns of marks ("Flag1"), where white space parts the cells, so
    that empty marks are not there and full ones ("*") move what follows."""
    at, _ = headings_of(rows)
    heads = [str(c).lower() for c in rows[at]] if at >= 0 else []
    marks = [k for k, head in enumerate(heads) if _MARK.fullmatch(head)]
    if not marks or any("" in row for row in rows[at:]):
        return rows
    plain = [[c for c in row if c != "*"] for row in rows]
    plain[at] = [c for k, c in enumerate(rows[at]) if k not in marks]
    return plain


def _of_numbers(rows: Rows, times: list[int]) -> Rows:
    """The rows that have a time (in one of the columns `times`), up to where time
    begins again behind others: there another table follows."""
    out: Rows = []
    last, other = -np.inf, False
    for row in rows:
        told = [c for k in times if k < len(row) and isinstance(c := row[k], float)]
        if not told:
            other = True
            continue
        if other and told[0] <= last:
            break
        out.append(row)
        last, other = told[0], False
    return out


def _units(source: Source, headings: list[Heading]) -> tuple[str, str]:
    """Units of time and length of one table, "" where it names none."""
    clocks = _columns(headings, "clock") or _columns(headings, "count")[:1]
    held = [(headings[t].unit, headings[t].holds) for t in clocks]
    times = {unit or ("frame" if kind == "count" else "") for unit, kind in held}
    places = _columns(headings, "x", "y") or _columns(headings, "length")
    lengths = {headings[c].unit for c in places}
    return _one_unit(source, times), _one_unit(source, lengths)


def _columns(headings: list[Heading], *held: str) -> list[int]:
    return [k for k, h in enumerate(headings) if h.holds in held]


def _one_length(length: np.ndarray, is_x: bool) -> tuple[np.ndarray, np.ndarray]:
    other = np.where(np.isnan(length), np.nan, 0.0)
    return (length, other) if is_x else (other, length)


def _one_unit(source: Source, units: set[str]) -> str:
    require(
        len(units) <= 1,
        f"{source.path}: its columns have several units; x and y of all tracks are"
        " to have one, and t one",
    )
    return units.pop()
