"""Files of other tools, read as they are: a tool a file, each of which tells its files by what they hold.

Adding one: `TOOL`, its name; `holds(source)`, whether a file is its own; `read(source)`, what it says; a line in READERS.
"""

from functools import lru_cache
from pathlib import Path
from types import ModuleType

from vision.foreign import accelerometer, kinovea, manual_tracking, mtrackj, phyphox, tracker, tracker_table, trackmate
from vision.foreign.found import Found
from vision.foreign.source import Source
from vision.measurement import MeasurementError

READERS: tuple[ModuleType, ...] = (tracker, trackmate, mtrackj, kinovea, manual_tracking, phyphox, accelerometer, tracker_table)
SUFFIXES = (".trk", ".trz", ".txt", ".csv", ".tsv", ".dat", ".xml", ".mdf", ".xls", ".xlsx", ".zip", ".kva")


SURE = (".trk", ".trz", ".mdf", ".kva")  # written by one tool only: such a file is never passed over


def tool_of(path: Path) -> str:
    """The tool whose file this is, by what it holds; "" where it is none's, or damaged so that nothing tells."""
    suffix = path.suffix.lower()
    if suffix not in SUFFIXES:
        return ""
    try:
        _, reader = _opened(*_version(path))
    except (MeasurementError, OSError):
        reader = None
    return reader.TOOL if reader else "a damaged file" if suffix in SURE else ""


def read_foreign(path: Path) -> Found:
    """What a file of another tool says. MeasurementError naming the file and what is wrong in it, or that no tool is known to write it."""
    return _read(*_version(path))


@lru_cache(maxsize=64)
def _read(path: Path, time: int, size: int) -> Found:
    source, reader = _opened(path, time, size)
    if reader is None:
        raise MeasurementError(f"{path}: no tool is known to write such a file (docs/import.md lists those that are read)")
    return reader.read(source)


@lru_cache(maxsize=2)
def _opened(path: Path, time: int, size: int) -> tuple[Source, ModuleType | None]:
    source = Source(path)
    return source, _reader(source)


def _version(path: Path) -> tuple[Path, int, int]:
    """A file as it is now: what is read is kept, and read anew where the file has changed."""
    stat = path.stat()
    return path, stat.st_mtime_ns, stat.st_size


def _reader(source: Source) -> ModuleType | None:
    return next((reader for reader in READERS if reader.holds(source)), None)
