"""A file opened once for all readers: text, tables or XML, with limits against hostile
files."""

import contextlib
import csv
import re
import zipfile
from collections.abc import Sequence
from functools import cached_property
from pathlib import Path
from xml.etree.ElementTree import Element, ParseError

import defusedxml.ElementTree
import numpy as np
from defusedxml.common import DefusedXmlException

from benchtwin.vision.evidence.tables import separators
from benchtwin.vision.foreign.apart import MATLAB, sheets_of
from benchtwin.vision.measurement import MeasurementError, require

MOST_BYTES = 50_000_000  # of a file, and of what is packed in it
MOST_UNPACKED = 10 * MOST_BYTES  # of a workbook
MOST_TABLES = 50  # in a packed file
HEAD = 20_000  # bytes by which a tool is recognised
MOST_HEADING = 60  # lines of them
Cell = str | float
Rows = list[list[Cell]]
_SAYS_UTF8 = re.compile(rb"""\s*<\?xml[^>]*encoding=["']utf-?8["']""", re.IGNORECASE)
_NUMBER = re.compile(r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?")
LARGEST = 2e18  # of any number: nanoseconds since 1970 are 1.8e18
LENGTH = {  # → millimetres
    name: mm
    for mm, names in (
        (
            1.0,
            "mm millimeter millimeters millimetre millimetern millimètres milímetros",
        ),
        (
            10.0,
            "cm centimeter centimetre zentimeter zentimetern centimètres centímetros",
        ),
        (10.0, "centimeters centimetri"),
        (100.0, "dm"),
        (
            1000.0,
            "m meter metre meters metres metern mètre mètres metro metros metri м",
        ),
        (1e-3, "µm μm um micron microns"),
        (1e-6, "nm"),
        (25.4, "in inch inches"),
        (304.8, "ft feet"),
        (914.4, "yd"),
    )
    for name in names.split()
}
TIME = {  # → seconds
    name: seconds
    for seconds, names in (
        (1.0, "s sec secs second seconds sek sekunde sekunden seconde secondes"),
        (1.0, "segundo segundos secondo secondi с"),
        (1e-3, "ms msec millisecond milliseconds millisekunden"),
        (1e-6, "µs μs us"),
        (1e-9, "ns nanoseconds"),
        (60.0, "min minute minutes minuten"),
        (3600.0, "h hour"),
    )
    for name in names.split()
}
PIXELS = ("px", "pixel", "pixels", "pix")
UNITS = {*TIME, *LENGTH, *PIXELS}
FRAMES = ("frame", "frames", "slice", "slices")
_IN_BRACKETS = re.compile(r"(.*?)[\s_]*[\(\[]\s*([^()\[\]]*?)\s*[\)\]]\s*")
# a unit behind its name: "t/s", "x / cm", "y_mm", "x in Metern", "Высота, м"
_BEHIND = re.compile(r"(.+?)(?:\s*/\s*(?:in\s+)?|\s*,\s*|_|\s+)([^\s/,_]+)")
_NOTHING = re.compile("|nan|none|null|-|∞|-?inf", re.IGNORECASE)  # an empty cell


class Source:
    """One file; its properties raise MeasurementError with the file's name where it
    cannot be read as such."""

    def __init__(self, path: Path):
        self.path = path
        size = path.stat().st_size
        require(size != 0, f"{path}: the file is empty (0 bytes)")
        require(
            size <= MOST_BYTES,
            f"{path}: {size / 1e6:.0f} MB; a file of another tool has"
            f" {MOST_BYTES / 1e6:.0f} MB at most",
        )
        with path.open("rb") as file:
            self.head = file.read(HEAD)

    @property
    def is_zip(self) -> bool:
        return self.head.startswith(b"PK\x03\x04")

    @property
    def is_workbook(self) -> bool:
        return self.head.startswith(b"\xd0\xcf\x11\xe0") or (
            self.is_zip and any(n.startswith("xl/") for n in self.members)
        )

    @property
    def is_packed(self) -> bool:
        return self.is_zip and not self.is_workbook

    @property
    def is_xml(self) -> bool:
        return _decoded(self.head[:400]).lstrip("\ufeff \r\n\t").startswith("<")

    @property
    def is_matlab(self) -> bool:
        return self.head.startswith(MATLAB)

    @cached_property
    def is_text(self) -> bool:
        return not (self.is_zip or self.is_xml or self.is_workbook or self.is_matlab)

    @cached_property
    def text(self) -> str:
        """The whole file as text."""
        return _decoded(self.path.read_bytes())

    @cached_property
    def first_lines(self) -> list[str]:
        """The complete lines of the head, as text; none of a binary file."""
        if b"\0" in self.head and not self.head.startswith((b"\xff\xfe", b"\xfe\xff")):
            return []
        lines = _decoded(self.head).splitlines()
        return lines if len(self.head) < HEAD else lines[:-1]

    @cached_property
    def first_rows(self) -> Rows:
        """The cells of the first lines, whatever their decimals; at least one row,
        which may be empty."""
        return table_of(self.first_lines[:MOST_HEADING], strict=False) or [[]]

    @property
    def heads(self) -> list[Rows]:
        """The tables in the file, of a text its first lines alone; none of XML."""
        if self.is_xml:
            return []
        return [self.first_rows] if self.is_text else [*self.sheets.values()]

    @cached_property
    def members(self) -> list[str]:
        """Names of the files in a packed one."""
        try:
            with zipfile.ZipFile(self.path) as archive:
                inside = archive.infolist()
        except Exception as error:  # the library raises many kinds for a damaged file
            raise MeasurementError(
                f"{self.path}: the zip file is damaged or cut short ({error})"
            ) from error
        if (size := sum(m.file_size for m in inside)) > MOST_UNPACKED:
            raise MeasurementError(
                f"{self.path}: it unpacks to {size / 1e6:,.0f} MB; a file of another"
                f" tool has {MOST_UNPACKED / 1e6:.0f} MB at most"
            )
        return [
            m.filename
            for m in inside
            if m.filename and not m.is_dir() and not m.filename.startswith("__MACOSX")
        ]

    def member(self, name: str) -> bytes:
        """What a packed file holds under `name`."""
        try:
            with zipfile.ZipFile(self.path) as archive, archive.open(name) as file:
                content = file.read(MOST_BYTES + 1)
        except Exception as error:
            raise MeasurementError(
                f"{self.path}: {name} in it is damaged or locked ({error})"
            ) from error
        require(
            len(content) <= MOST_BYTES,
            f"{self.path}: {name} unpacks to more than {MOST_BYTES / 1e6:.0f} MB",
        )
        return content

    @cached_property
    def xml(self) -> Element:
        return self.parsed(self.path.read_bytes())

    def number(self, text: str | None, name: str) -> float | None:
        """The finite number that `text` is, None without a text; MeasurementError for
        all else, naming what it stands for."""
        if text is None or not text.strip():
            return None
        with contextlib.suppress(ValueError):
            if np.isfinite(found := float(text)):
                return found
        raise MeasurementError(f"{self.path}: {name} = {text[:30]!r} is not a number")

    def numbers(self, cells: Sequence[str], count: int, wrong: str) -> list[float]:
        """The first `count` cells as numbers, with points or commas; MeasurementError
        that says what is `wrong` where they are none or fewer."""
        try:
            found = [float(cell.replace(",", ".")) for cell in cells[:count]]
        except ValueError:
            found = []
        require(len(found) == count, f"{self.path}: {wrong}")
        return found

    def parsed(self, content: bytes) -> Element:
        """Parsed XML; entities, whose expansion could fill the memory, are refused."""
        try:
            content.decode("utf-8")
        except UnicodeDecodeError:
            # some tools declare UTF-8 and write Windows-1252
            if _SAYS_UTF8.match(content):
                content = content.decode("cp1252", "replace").encode()
        try:
            return defusedxml.ElementTree.fromstring(content, forbid_dtd=False)
        except (
            ParseError,
            DefusedXmlException,
            ValueError,
            LookupError,
            RecursionError,
        ) as error:
            raise MeasurementError(
                f"{self.path}: not valid XML ({str(error) or type(error).__name__})"
            ) from error

    @cached_property
    def sheets(self) -> dict[str, Rows]:
        """The tables in the file by name: sheets of a workbook, vectors of a MATLAB
        file, members of a packed file, or the file's own."""
        if self.is_workbook or self.is_matlab:
            try:
                sheets = sheets_of(self.path)
            except ValueError as error:
                raise MeasurementError(f"{self.path}: {error}") from error
            return {
                k: [[_cell(c, ".") for c in row] for row in rows]
                for k, rows in sheets.items()
            }
        if self.is_zip:
            tables = [
                n for n in self.members if n.lower().endswith((".csv", ".txt", ".tsv"))
            ][:MOST_TABLES]
            return {
                n.rpartition(".")[0]: self._rows(_decoded(self.member(n)))
                for n in tables
            }
        return {self.path.stem: self.rows}

    @cached_property
    def rows(self) -> Rows:
        """The cells of a text table, its numbers as floats."""
        return self._rows(self.text)

    def _rows(self, text: str) -> Rows:
        try:
            return table_of(text.splitlines())
        except ValueError as error:
            raise MeasurementError(f"{self.path}: {error}") from error


def table_of(lines: Sequence[str], *, strict: bool = True) -> Rows:
    """The cells of the lines that are not empty, numbers as floats. ValueError, where
    it is strict, for decimals that are ambiguous or cells that are too long."""
    lines = [line for line in lines if line.strip()]
    few = lines[:200]
    # Tab, semicolon or comma, whichever is in most lines and in those with words
    # (decimal commas are not).
    words = [
        line for line in few if any(c.isalpha() and c not in "eE" for c in line)
    ] or few
    often = (
        c
        for c in ("\t", ";", ",")
        if sum(c in line for line in few) > len(few) / 2
        and any(c in line for line in words)
    )
    by, decimal = separators(next(often, " "), lines)
    if not decimal and strict:
        raise ValueError(
            "numbers with points and with commas, or with thousands marked; save it"
            " with one kind"
        )
    if by == " ":
        return [[_cell(c, decimal) for c in line.split()] for line in lines]
    try:
        rows = list(csv.reader(lines, delimiter=by))
    except csv.Error as error:
        if not strict:
            return []
        raise ValueError(f"not a table ({error})") from error
    return [[_cell(c, decimal) for c in row] for row in rows]


def _decoded(content: bytes) -> str:
    if content.startswith((b"\xff\xfe", b"\xfe\xff")):
        return content.decode("utf-16", "replace")
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        if error.start >= len(content) - 4:  # cut within a letter
            return content.decode("utf-8-sig", "ignore")
        return content.decode("cp1252", "replace")


def _cell(cell: object, decimal: str) -> Cell:
    if isinstance(cell, int | float) and not isinstance(cell, bool):
        return float(cell)
    text = str(cell).strip().lstrip("\ufeff")
    number = text.replace(",", ".") if decimal == "," else text
    return float(number) if _NUMBER.fullmatch(number) and len(number) < 50 else text


def heading_and_unit(heading: object) -> tuple[str, str]:
    """A column's name and its unit, in brackets or behind it, in small letters; ""
    where it has none: "Time (s)" → ("time", "s")."""
    text = str(heading).strip().strip('"').lower()
    if found := _IN_BRACKETS.fullmatch(text):
        return found[1].strip(), found[2].removeprefix("in ").strip()
    behind = _BEHIND.fullmatch(text)
    return (behind[1], behind[2]) if behind and behind[2] in UNITS else (text, "")


def column(path: Path, rows: Rows, at: int, name: str, first_line: int) -> np.ndarray:
    """One column of numbers, NaN for an empty cell; MeasurementError naming column and
    line for words. first_line: of `rows`."""
    values = np.full(len(rows), np.nan)
    for k, row in enumerate(rows):
        cell = row[at] if at < len(row) else ""
        if isinstance(cell, float):
            values[k] = cell
        elif not _NOTHING.fullmatch(cell):
            raise MeasurementError(
                f"{path}: {name} = {cell[:30]!r} in line {first_line + k} is not a"
                " number"
            )
    values[~np.isfinite(values)] = np.nan
    if (wrong := np.flatnonzero(np.abs(np.nan_to_num(values)) > LARGEST)).size:
        raise MeasurementError(
            f"{path}: {name} = {values[wrong[0]]:g} in line {first_line + wrong[0]}"
            " cannot be"
        )
    return values


def need(path: Path, headings: Sequence[str], names: Sequence[str]) -> list[int]:
    """Indices of the columns `names` in `headings`; MeasurementError naming those that
    are missing."""
    if missing := [n for n in names if n not in headings]:
        found = ", ".join(headings)[:200]
        raise MeasurementError(
            f"{path}: column {', '.join(missing)} is missing; found {found}"
        )
    return [headings.index(n) for n in names]
