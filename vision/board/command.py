"""`benchtwin board`: a board to print."""

import sys
from pathlib import Path

from benchtwin.vision.board.sheet import sheet_of, write_board
from benchtwin.vision.measurement import MeasurementError

DONE, MISUSED = 0, 2


def board_command(out: Path, size: str) -> int:
    """Write the board of that size of paper; the exit code."""
    try:
        sheet = sheet_of(size)
        write_board(sheet, out)
    except (MeasurementError, OSError) as error:
        print(f"benchtwin board: {error}", file=sys.stderr)
        return MISUSED
    print(
        f"{out}: print it on {sheet.name} at 100 % and measure its line"
        f" ({sheet.line_mm} mm); docs/filming.md says where it stands"
    )
    return DONE
