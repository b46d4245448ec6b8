"""Tables as one workbook for spreadsheet programs (.xlsx)."""

import math
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from benchtwin.bench.outlets import plain
from benchtwin.bench.whole_file import whole

if TYPE_CHECKING:
    import pandas as pd
    from openpyxl.worksheet.worksheet import Worksheet

WORKBOOK = "results.xlsx"
LONGEST_TEXT = 32_767  # characters that a cell holds
WIDEST = 60  # characters of a column as it opens


def write_workbook(file: Path, tables: Mapping[str, "pd.DataFrame"]) -> None:
    """A sheet a table, under the table's name of at most 31 characters.

    Numbers stay numbers, of 16 digits; what is not finite is an empty cell; text is
    never a formula. The file appears whole or not at all; OSError where it cannot be
    written."""
    from openpyxl import Workbook

    book = Workbook()
    del book[book.sheetnames[0]]
    for title, table in tables.items():
        _fill(book.create_sheet(title), table)
    with whole(file) as part:
        book.save(part)


def _fill(sheet: "Worksheet", table: "pd.DataFrame") -> None:
    """Headings, bold, that stay in sight; below them the rows."""
    from openpyxl.styles import Font
    from openpyxl.utils import get_column_letter

    rows = [list(table.columns), *table.itertuples(index=False, name=None)]
    for y, row in enumerate(rows, 1):
        for x, value in enumerate(row, 1):
            told = _cell(value)
            cell = sheet.cell(y, x, told)
            if isinstance(told, str):
                cell.data_type = "s"  # "=1+1" is a name, too
            if y == 1:
                cell.font = Font(bold=True)
    sheet.freeze_panes = "A2"
    for x, column in enumerate(zip(*rows, strict=True), 1):
        wide = max(len(str(_cell(value))) for value in column)
        sheet.column_dimensions[get_column_letter(x)].width = min(wide + 2, WIDEST)


def _cell(value: Any) -> str | int | float | bool | None:
    """A value as a cell holds it.

    >>> _cell(float("nan")), _cell(("a", "b")), _cell("a\\x00b")
    (None, 'a; b', 'a\\\\x00b')
    """
    value = value.item() if hasattr(value, "item") else value  # numpy's numbers
    if value is None or isinstance(value, bool | int):
        return value
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if isinstance(value, tuple | list):
        value = "; ".join(map(str, value))
    return plain(value)[:LONGEST_TEXT]
