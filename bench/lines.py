"""Sentences said of recordings."""

from collections.abc import Iterable


def one_a_reason(said: Iterable[tuple[str, str]]) -> tuple[str, ...]:
    """(recording, what is said of it) → a line for each thing that is said, with all
    recordings of which it is."""
    who: dict[str, list[str]] = {}
    for recording, line in said:
        who.setdefault(line, []).append(recording)
    return tuple(f"{', '.join(names)}: {line}" for line, names in who.items())
