"""The terminal: to it every string is text, whatever stands in it."""

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any, TextIO, cast

from rich.console import Console
from rich.progress import Task, TextColumn
from rich.text import Text

from benchtwin.bench.outlets import plain


class Terminal(Console):
    """A console to which every string is text: no markup, no control characters. Where
    there is no terminal it is 160 characters wide."""

    def __init__(self, *, stderr: bool = False, quiet: bool = False) -> None:
        stream = sys.stderr if stderr else sys.stdout
        raw = stream.stream if isinstance(stream, Gate) else stream
        width = None if raw.isatty() else 160
        super().__init__(file=raw, width=width, quiet=quiet, highlight=False)

    def render_str(self, text: str, **options: Any) -> Text:
        """The string as it is."""
        return super().render_str(
            plain(text), **(options | {"markup": False, "emoji": False})
        )

    def print(self, *objects: Any, **options: Any) -> None:
        """Print; lines that others print while a bar is shown come as Text."""
        told = (plain(o.plain) if isinstance(o, Text) else o for o in objects)
        super().print(*told, **options)


class Words(TextColumn):
    """A column of a progress bar whose text is text."""

    def render(self, task: Task) -> Text:
        """The column's text for a task."""
        return Text(plain(self.text_format.format(task=task)))


class Gate:
    """A stream to which nothing goes that a terminal does not show as it is."""

    def __init__(self, stream: Any) -> None:
        self.stream = stream

    def write(self, text: str) -> int:
        """Write the text as `plain` has it; TypeError for bytes, by which click tells
        streams of text."""
        if not isinstance(text, str):
            raise TypeError(f"text was expected, not {type(text).__name__}")
        self.stream.write(plain(text))
        return len(text)

    def __getattr__(self, name: str) -> Any:
        return getattr(self.stream, name)


@contextmanager
def gated() -> Iterator[None]:
    """While open, all that is printed goes through gates, whoever prints it."""
    before = sys.stdout, sys.stderr
    sys.stdout, sys.stderr = (cast(TextIO, Gate(stream)) for stream in before)
    try:
        yield
    finally:
        sys.stdout, sys.stderr = before
