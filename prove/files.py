"""Files of a proof: read, and written whole or not at all. The proof imports nothing
of what it tries, so it has this of its own."""

import json
from pathlib import Path
from tempfile import TemporaryDirectory


def read_json(file: Path) -> dict:
    """The object that a JSON file holds."""
    return json.loads(file.read_text(encoding="utf8"))


def write_json(file: Path, content: dict, *, indent: int | None = 1) -> None:
    """Write a JSON file, whole or not at all; ValueError for a number that is not
    finite."""
    write_whole(
        file, json.dumps(content, indent=indent, sort_keys=True, allow_nan=False)
    )


def write_whole(file: Path, text: str) -> None:
    """Write beside the file, where nobody else has put anything, and put it in
    place."""
    with TemporaryDirectory(prefix=".prove-", dir=file.parent) as folder:
        part = Path(folder) / "part"
        part.write_text(text, encoding="utf8")
        part.replace(file)
