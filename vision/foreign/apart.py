"""Reads workbooks (.xls, .xlsx; calamine) and MATLAB files (.mat, to version 7; scipy)
in a separate process.

A cell in the last row and column, an array that says it is long, or a damaged file can
need more memory than there is and so end the process. This module imports nothing of
benchtwin, so that the process starts fast."""

import contextlib
import io
import json
import subprocess
import sys
from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

MATLAB = (b"MATLAB 5.0 MAT-file", NEWER := b"MATLAB 7.3 MAT-file")
MOST_CELLS = 2_000_000
MOST_MEMORY = 2_000_000_000  # bytes
LONGEST_S = 60.0
Sheets = Mapping[str, Sequence[Sequence[object]]]


def sheets_of(path: Path) -> Sheets:
    """The cells of every sheet by its name, or the vectors of a MATLAB file as columns:
    numbers, and text for all else. ValueError where the file is damaged or too
    large."""
    command = [sys.executable, "-I", __file__, str(path.resolve())]
    try:
        done = subprocess.run(
            command, capture_output=True, timeout=LONGEST_S, check=False
        )
    except subprocess.TimeoutExpired as error:
        raise ValueError(f"the file was not read in {LONGEST_S:.0f} s") from error
    if done.returncode:
        message = done.stdout.decode("utf8", "replace").strip()
        raise ValueError(
            message or "the file is damaged, or its cells are spread too wide"
        )
    return json.loads(done.stdout)


def _print_sheets(path: str) -> None:
    """Print the sheets as JSON; or one line with what is wrong, and exit code 1."""
    with contextlib.suppress(ImportError, ValueError, OSError):  # not on every system
        import resource

        resource.setrlimit(resource.RLIMIT_AS, (MOST_MEMORY, MOST_MEMORY))
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    raw = Path(path).read_bytes()
    kind = "MATLAB file" if raw.startswith(MATLAB) else "workbook"
    try:
        found = _vectors_of(raw) if raw.startswith(MATLAB) else _cells_of(raw)
        said, failed = json.dumps(found), 0
    except _Refused as error:
        said, failed = str(error).format(kind), 1
    except MemoryError:
        said, failed = f"the {kind} says that it is larger than memory", 1
    except Exception as error:  # the libraries raise many kinds for a damaged file
        said, failed = f"the {kind} is damaged ({str(error)[:200]})", 1
    sys.stdout.buffer.write(said.encode("utf8", "replace"))
    sys.exit(failed)


class _Refused(Exception):
    """What is wrong with a file, in words."""


TOO_LARGE = _Refused(f"the {{}} has more than {MOST_CELLS:,} cells")


def _cells_of(raw: bytes) -> Sheets:
    """The sheets of a workbook, of the kind that its content is, whatever its name."""
    from python_calamine import CalamineWorkbook

    found: dict[str, list[list[object]]] = {}
    book, cells = CalamineWorkbook.from_filelike(io.BytesIO(raw)), 0
    for name in book.sheet_names:
        sheet = book.get_sheet_by_name(name)
        cells += (sheet.total_height or 0) * (sheet.total_width or 0)
        if cells > MOST_CELLS:
            raise TOO_LARGE
        found[name] = [
            [c if isinstance(c, int | float | str) else str(c) for c in row]
            for row in sheet.to_python()
        ]
    return found


def _vectors_of(raw: bytes) -> Sheets:
    """Names and values of the vectors of the commonest length, of variables and of
    fields of a struct, a row for each element."""
    if raw.startswith(NEWER):
        raise _Refused("a MATLAB file of version 7.3; save it with -v7")
    from scipy.io import loadmat

    found = loadmat(io.BytesIO(raw), squeeze_me=True, struct_as_record=False)
    vectors = dict(_vectors({k: v for k, v in found.items() if k[:2] != "__"}))
    lengths = Counter(len(v) for v in vectors.values())
    most = max(lengths, key=lambda n: (lengths[n], n), default=0)
    kept = {name: v for name, v in vectors.items() if len(v) == most}
    if len(kept) * most > MOST_CELLS:
        raise TOO_LARGE
    names: list[object] = [*kept]
    rows = [[float(v) for v in row] for row in zip(*kept.values())]
    return {"vectors": [names, *rows] if kept else []}


def _vectors(held: dict[str, Any]) -> list[tuple[str, Any]]:
    found = []
    for name, value in held.items():
        if fields := getattr(value, "_fieldnames", None):
            found += _vectors({field: getattr(value, field) for field in fields})
        elif getattr(value, "ndim", 0) == 1 and value.size > 1:
            found += [(name, value)] if value.dtype.kind in "iuf" else []
    return found


if __name__ == "__main__":
    _print_sheets(sys.argv[1])
