"""Reads workbooks (.xls, .xlsx) with calamine in a separate process.

A cell in the last row and column, or a damaged file, can need more memory than there is
and so end the process. This module imports nothing of benchtwin, so that the process
starts fast."""

import contextlib
import io
import json
import subprocess
import sys
from pathlib import Path

from python_calamine import CalamineWorkbook

MOST_CELLS = 2_000_000
MOST_MEMORY = 2_000_000_000  # bytes
LONGEST_S = 60.0


def sheets_of(path: Path) -> dict[str, list[list[object]]]:
    """The cells of every sheet by its name: numbers, and text for all else. ValueError
    where the file is damaged or too large."""
    command = [sys.executable, "-I", __file__, str(path.resolve())]
    try:
        done = subprocess.run(
            command, capture_output=True, timeout=LONGEST_S, check=False
        )
    except subprocess.TimeoutExpired as error:
        raise ValueError(f"the workbook was not read in {LONGEST_S:.0f} s") from error
    if done.returncode:
        message = done.stdout.decode("utf8", "replace").strip()
        raise ValueError(
            message or "the workbook is damaged, or its cells are spread too wide"
        )
    return json.loads(done.stdout)


def _print_sheets(path: str) -> None:
    """Print the sheets as JSON; or one line with what is wrong, and exit code 1."""
    with contextlib.suppress(ImportError, ValueError, OSError):  # not on every system
        import resource

        resource.setrlimit(resource.RLIMIT_AS, (MOST_MEMORY, MOST_MEMORY))
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    try:
        book, found, cells = _opened(path), {}, 0
        for name in book.sheet_names:
            sheet = book.get_sheet_by_name(name)
            cells += (sheet.total_height or 0) * (sheet.total_width or 0)
            if cells > MOST_CELLS:
                sys.exit(_fail(f"the workbook has more than {MOST_CELLS:,} cells"))
            found[name] = [
                [c if isinstance(c, int | float | str) else str(c) for c in row]
                for row in sheet.to_python()
            ]
    except Exception as error:
        sys.exit(_fail(f"the workbook is damaged ({str(error)[:200]})"))
    sys.stdout.buffer.write(json.dumps(found).encode())


def _opened(path: str) -> CalamineWorkbook:
    """The workbook, of the kind that its content is, whatever its name."""
    return CalamineWorkbook.from_filelike(io.BytesIO(Path(path).read_bytes()))


def _fail(line: str) -> int:
    sys.stdout.buffer.write(line.encode("utf8", "replace"))
    return 1


if __name__ == "__main__":
    _print_sheets(sys.argv[1])
