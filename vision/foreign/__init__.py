"""Readers of the files of other tools, one module for each tool, which recognises its
files by their contents.

To add one: `TOOL`, its name; `recognises(source)`, whether a file is of that tool;
`read(source)`, its contents, or its tracks as they stand; a line in READERS."""

from functools import lru_cache
from pathlib import Path
from types import ModuleType

from benchtwin.vision.foreign import (
    accelerometer,
    kinovea,
    manual_tracking,
    mtrackj,
    phyphox,
    table_of_heights,
    table_of_places,
    tracker,
    trackmate,
    waveform,
)
from benchtwin.vision.foreign.contents import Contents, Tracked
from benchtwin.vision.foreign.source import Source
from benchtwin.vision.foreign.unit_inference import infer_units
from benchtwin.vision.measurement import MeasurementError

READERS: tuple[ModuleType, ...] = (
    tracker,
    trackmate,
    mtrackj,
    kinovea,
    manual_tracking,
    phyphox,
    accelerometer,
    table_of_heights,
    table_of_places,
    waveform,
)
# suffixes of one tool only: such a file is never ignored
ONE_TOOL = (".trk", ".trz", ".mdf", ".kva")
SUFFIXES = (
    *(*ONE_TOOL, ".txt", ".csv", ".tsv", ".dat"),
    *(".xml", ".xls", ".xlsx", ".zip", ".mat"),
)


def tool_of(path: Path) -> str:
    """The tool whose file this is, by its contents; "" where no tool recognises it."""
    suffix = path.suffix.lower()
    if suffix not in SUFFIXES:
        return ""
    try:
        reader = _reader(*_version(path))
    except (MeasurementError, OSError):
        reader = None
    return reader.TOOL if reader else "a damaged file" if suffix in ONE_TOOL else ""


def read_foreign(path: Path) -> Contents:
    """Contents of a file of another tool; MeasurementError naming the file and what is
    wrong, or that no tool recognises it."""
    return _read(*_version(path))


@lru_cache(maxsize=64)
def _read(path: Path, time: int, size: int) -> Contents:
    reader = _reader(path, time, size)
    if reader is None:
        raise MeasurementError(
            f"{path}: no tool is known to write such a file (docs/import.md lists those"
            " that are read)"
        )
    found = reader.read(_opened(path, time, size))
    if isinstance(found, Tracked):
        return infer_units(path, reader.TOOL, found)
    return found


@lru_cache(maxsize=5000)  # a folder is looked through more than once
def _reader(path: Path, time: int, size: int) -> ModuleType | None:
    source = _opened(path, time, size)
    return next((reader for reader in READERS if reader.recognises(source)), None)


@lru_cache(maxsize=2)
def _opened(path: Path, time: int, size: int) -> Source:
    return Source(path)


def _version(path: Path) -> tuple[Path, int, int]:
    """Cache key of a file: it is read again where it has changed."""
    stat = path.stat()
    return path, stat.st_mtime_ns, stat.st_size
