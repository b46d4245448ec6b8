"""What came from outside (names of files, ids, conditions, notes, reasons) on its way
out: one function for the terminal, for tables (CSV), and for comments in TOML and in
other programs' inputs. HTML is escaped by its templates, a workbook's cells are of the
type text."""

import re
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import pandas as pd

LONGEST_COMMENT = 400  # characters
# what moves the cursor, recolours, renames or reverses what is shown, halves of
# surrogate pairs, what XML has no place for; a tab and the end of a line are text
NOT_SHOWN = re.compile(
    "[\x00-\x08\x0b-\x1f\x7f-\x9f\u200e\u200f\u2028-\u202e\u2066-\u2069"
    "\ud800-\udfff\ufffe\uffff]"
)
# where a formula begins for a spreadsheet program: at the front, and, where a cell ends
# at a semicolon or a tab, behind these
FORMULA = re.compile(r"^(?=\s*[=+\-@＝＋－＠])|(?<=[;\t\n])(?=[=+\-@＝＋－＠])")
NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?")


def plain(text: object) -> str:
    """Text that a terminal shows as it is, control characters by their codes.

    >>> plain("a\\x1b[31mb")
    'a\\\\x1b[31mb'
    """
    return NOT_SHOWN.sub(lambda found: ascii(found[0])[1:-1], str(text))


def one_line(text: object) -> str:
    """Text for a comment in TOML: one line of printable characters."""
    return " ".join(plain(text).split())[:LONGEST_COMMENT]


def cell(value: Any) -> Any:
    """A value for a table: before what a spreadsheet program would take for a formula
    stands an apostrophe, numbers stay numbers.

    >>> cell("=1+1"), cell("-1.5e3"), cell(-2.0)
    ("'=1+1", '-1.5e3', -2.0)
    """
    if not isinstance(value, str):
        return value
    return value if NUMBER.fullmatch(value) else FORMULA.sub("'", plain(value))


def csv_text(table: "pd.DataFrame", float_format: str | None = "%.6g") -> str:
    """A table as CSV, with its headings, every cell by `cell`."""
    held = {
        n: column.map(cell) if column.dtype.kind not in "biufcmM" else column
        for n, (_, column) in enumerate(table.items())
    }
    shown = type(table)(held, index=table.index)
    header = [cell(str(name)) for name in table.columns]
    return shown.to_csv(
        index=False, header=header, float_format=float_format, lineterminator="\n"
    )
