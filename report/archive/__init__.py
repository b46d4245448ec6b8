"""A bench and its results as one folder or zip to keep and to publish, with the hash of
every file, the versions that made it, and nothing of the machine."""

import unicodedata
from collections.abc import Sequence
from pathlib import PurePosixPath

MANIFEST, ABOUT = "pack.json", "README.md"
MOST_LISTED = 16_000_000  # bytes of a manifest: some 80,000 files
SHOWN = 3  # names in a sentence
FORMAT = 1  # of the manifest; to be raised when older programs cannot read it


def stays_within(name: str) -> bool:
    """Whether a file's name stays, on every system, within the folder that it is
    written into, and can be shown."""
    parts = PurePosixPath(name).parts
    clean = not any(c in "\\:" or unicodedata.category(c) in ("Cc", "Cs") for c in name)
    return bool(parts) and clean and ".." not in parts and parts[0] != "/"


def some(names: Sequence[str]) -> str:
    """The first few of some names, and how many more there are."""
    more = len(names) - SHOWN
    return ", ".join(names[:SHOWN]) + (f" and {more} more" if more > 0 else "")
