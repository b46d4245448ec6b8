"""JSON files of a proof: read, and written whole or not at all."""

import json
from pathlib import Path

from benchtwin.bench.whole_file import write_whole


def read_json(file: Path) -> dict:
    """The object that a JSON file holds."""
    return json.loads(file.read_text(encoding="utf8"))


def write_json(file: Path, content: dict, *, indent: int | None = 1) -> None:
    """Write a JSON file, whole or not at all; ValueError for a number that is not
    finite."""
    write_whole(
        file, json.dumps(content, indent=indent, sort_keys=True, allow_nan=False)
    )
