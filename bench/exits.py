"""How a command ends: exit codes, and the error of one that was typed wrongly."""

import sys

DONE, FAILED, MISUSED = 0, 1, 2


class Misuse(ValueError):
    """The command was typed wrongly."""


def say(verb: str, error: object, code: int) -> int:
    """Print an error as `benchtwin VERB` says it; returns the exit code."""
    print(f"benchtwin {verb}: {error}", file=sys.stderr)
    return code
