"""README's output blocks, made anew: what its commands print, and what `make demo`
calibrated.

    .venv/bin/python scripts/readme_numbers.py [DEMO]      → README.md

DEMO (demo-out): the folder in which `make demo` left `calibrated`, which takes minutes
and is not done again."""

import argparse
import contextlib
import io
import json
import os
import re
import shlex
import tempfile
from pathlib import Path

ROOT = Path(__file__).parents[1]
README = ROOT / "README.md"
BLOCK = re.compile(
    r"```sh\n\.venv/bin/benchtwin ((measure|calibrate|diagnose)"
    r" samples/[^#\n]*)[^`]*```\n\n```\n(.*?)```",
    re.S,
)
NUMBER = re.compile(r"\d+(?:\.\d+)?")


def blocks(text: str) -> dict[str, tuple[list[str], str]]:
    """Of measure, calibrate and diagnose: the command's arguments as README gives them,
    and the output shown below it."""
    return {
        verb: (shlex.split(arguments), shown)
        for arguments, verb, shown in BLOCK.findall(text)
    }


def printed(arguments: list[str]) -> str:
    """What `benchtwin` prints with these arguments, run where `samples` is and nothing
    else."""
    from typer.testing import CliRunner

    from benchtwin.command_line import app

    before = Path.cwd()
    with tempfile.TemporaryDirectory() as scratch:
        (Path(scratch) / "samples").symlink_to(ROOT / "samples")
        os.chdir(scratch)
        try:
            result = CliRunner().invoke(app, arguments)
        finally:
            os.chdir(before)
    if result.exit_code:
        raise RuntimeError(result.output)
    return tidy(result.stdout)


def calibrated(result: Path) -> str:
    """What `benchtwin calibrate` printed of the parameters, from its result.json."""
    import pandas as pd

    from benchtwin.bench.terminal import Terminal
    from benchtwin.calibrating import as_read
    from benchtwin.shown import in_terminal

    found = json.loads(result.read_text(encoding="utf8"))["parameters"]
    out = io.StringIO()
    with contextlib.redirect_stdout(out):
        rows = [{"parameter": n, **row} for n, row in found.items()]
        in_terminal(as_read(pd.DataFrame(rows)), Terminal())
    return tidy(out.getvalue())


def tidy(text: str) -> str:
    """Without spaces at the ends of lines and empty lines before and after."""
    return "\n".join(line.rstrip() for line in text.splitlines()).strip("\n") + "\n"


def differences(shown: str, new: str, share: float) -> list[str]:
    """Where two texts differ: in words, or in a number by more than this share of it
    and one of its last digits."""
    if NUMBER.sub("#", " ".join(shown.split())) != NUMBER.sub(
        "#", " ".join(new.split())
    ):
        return [f"the words differ:\n{shown}\n{new}"]
    pairs = zip(NUMBER.findall(shown), NUMBER.findall(new), strict=True)
    return [
        f"{a} is now {b}"
        for a, b in pairs
        if abs(float(a) - float(b)) > share * float(a) + 1.01 * _last_digit(a)
    ]


def _last_digit(number: str) -> float:
    return 10.0 ** -len(number.partition(".")[2])


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("demo", type=Path, nargs="?", default=Path("demo-out"))
    result = parser.parse_args().demo / "calibrated" / "result.json"
    if not result.is_file():
        parser.error(f"{result} is not there; `make demo` makes it")
    text = README.read_text(encoding="utf8")
    for verb, (arguments, shown) in blocks(text).items():
        new = calibrated(result) if verb == "calibrate" else printed(arguments)
        text = text.replace(f"```\n{shown}```", f"```\n{new}```")
    README.write_text(text, encoding="utf8")


if __name__ == "__main__":
    main()
