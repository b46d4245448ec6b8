"""Files that appear whole or not at all."""

import secrets
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path


@contextmanager
def whole(file: Path) -> Iterator[Path]:
    """A place beside `file` to write to, which takes the place of `file` at once when
    all is written: whoever reads it, or stops us, finds the old or the new one. OSError
    where it cannot be written."""
    part = file.with_name(f".{file.name}.{secrets.token_hex(4)}.part")
    try:
        yield part
        part.replace(file)
    finally:
        part.unlink(missing_ok=True)


def write_whole(file: Path, text: str) -> None:
    """Write a text file, whole or not at all."""
    with whole(file) as part:
        part.write_text(text, encoding="utf8")
