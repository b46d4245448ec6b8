"""Spoilt files for every reader: what is not read must be refused by an error of ours
that names the file.

    python benchmarks/fuzz.py [MINUTES [FILES …]]
    python benchmarks/fuzz.py 2 track.csv result.json

Ten minutes if nothing is said, shared among the readers of all files.

Hypothesis spoils valid files: cells and lines exchanged for hostile ones, bytes
overwritten, cut out, doubled. A fault is printed with the smallest file that shows it.
"""

import argparse
import sys
import tempfile
import time
import warnings
from pathlib import Path

from fuzz_files import Reader, error_place, readers
from fuzz_outside import outside
from hypothesis import HealthCheck, given, seed, settings
from hypothesis import strategies as st

from benchtwin.vision.measurement import MeasurementError

TOKENS = (
    "",
    " ",
    "0",
    "-1",
    "1",
    "nan",
    "inf",
    "-inf",
    "1e308",
    "-1e308",
    "1e-308",
    "1e400",
    "9" * 30,
    "9" * 400,
    "0x10",
    "1_0",
    "true",
    "1+2j",
    "٣",
    "½",
    "abc",
    '"',
    "'",
    '"""',
    "[",
    "]]",
    "{a={}}",
    "{",
    "[1, 2]",
    "[1.0, 2.0, 3.0]",
    '"drop"',
    '"pile"',
    '"+x"',
    "#",
    "\0",
    "\ufeff",
    "𝄞",
    "2024-01-01",
    "../../x",
    "null",
    '{"value": null}',
    "-",
    "=",
    ",",
    ":",
    "a.b.c",
    "[seed]",
    "[[seed]]",
    '"\\u001b[31m"',
    '"\\u202e[/x]"',
    '"=cmd|1"',
    '"@a"',
    "self",
    "value",
    "9" * 5000,
    '"../../x"',
    '"a/b/../../../c"',
)


@st.composite
def spoilt(draw: st.DrawFn, reader: Reader) -> bytes:
    """The valid file with one to four things done to it."""
    content = reader.valid
    for _ in range(draw(st.integers(1, 4))):
        by_cells = reader.parting and draw(st.integers(0, 5))
        content = (
            draw(spoilt_cell(content, reader.parting))
            if by_cells
            else draw(spoilt_bytes(content))
        )
    return content


@st.composite
def spoilt_cell(draw: st.DrawFn, content: bytes, parting: str) -> bytes:
    """One cell, line or several lines exchanged."""
    lines = content.decode("utf8", "surrogateescape").split("\n")
    at = draw(st.integers(0, len(lines) - 1))
    token = draw(
        st.sampled_from(TOKENS)
        | st.floats().map(repr)
        | st.text(st.characters(codec="utf8"), max_size=8)
    )
    what = draw(
        st.sampled_from(
            ("cell", "cell", "cell", "line", "drop", "double", "swap", "rest", "column")
        )
    )
    cells = lines[at].split(parting)
    which = draw(st.integers(0, len(cells) - 1))
    if what == "cell":
        lines[at] = parting.join([*cells[:which], token, *cells[which + 1 :]])
    elif what == "column":
        lines = [
            parting.join([*(c := line.split(parting))[:which], token, *c[which + 1 :]])
            for line in lines
        ]
    elif what == "swap":
        other = draw(st.integers(0, len(lines) - 1))
        lines[at], lines[other] = lines[other], lines[at]
    else:
        later = lines[at + 1 :]
        lines[at:] = {
            "line": [token, *later],
            "drop": later,
            "double": [lines[at], lines[at], *later],
            "rest": [],
        }[what]
    return "\n".join(lines).encode("utf8", "surrogateescape")


@st.composite
def spoilt_bytes(draw: st.DrawFn, content: bytes) -> bytes:
    """Bytes overwritten, cut out or put in."""
    at = draw(st.integers(0, max(len(content) - 1, 0)))
    gone = draw(st.sampled_from((0, 1, 1, 4, 64, len(content))))
    new = draw(
        st.sampled_from((b"", b"\0", b"\xff\xff\xff\xff", b"\x7f\xff\xff\xff", b"\n"))
        | st.binary(max_size=8)
    )
    return content[:at] + new + content[at + gone :]


def refused(reader: Reader, name: str, content: bytes) -> bool:
    """Whether it was refused, in words that name the file or its folder; any other
    trouble is raised."""
    with (
        tempfile.TemporaryDirectory(prefix="fuzz") as folder,
        warnings.catch_warnings(),
    ):
        warnings.simplefilter("ignore")
        name = name.split(" of ")[0]
        for other, there in {**(reader.others or {}), name: content}.items():
            file = Path(folder) / other
            file.parent.mkdir(parents=True, exist_ok=True)
            file.write_bytes(there)
        try:
            return reader.read(Path(folder) / name) is True
        except MeasurementError as error:
            assert folder in str(error), f"the file is not named: {error}"
            return True
        except ValueError as error:
            if type(error) is not ValueError or "calibrate" not in error_place(error):
                raise
            return True


def attack(name: str, reader: Reader, *, examples: int, rng: int) -> tuple[int, int]:
    """How many spoilt files were tried, and how many of them refused."""
    count = [0, 0]

    @seed(rng)
    @settings(
        max_examples=examples,
        deadline=None,
        database=None,
        suppress_health_check=list(HealthCheck),
    )
    @given(spoilt(reader))
    def one(content: bytes) -> None:
        count[0] += 1
        count[1] += refused(reader, name, content)

    one()
    return count[0], count[1]


def main(minutes: float, files: list[str]) -> None:
    known = readers() | outside()
    if unknown := set(files) - set(known):
        sys.exit(
            f"no such file: {', '.join(sorted(unknown))}; there are {', '.join(known)}"
        )
    asked = [n for n in known if not files or n in files]
    faults = 0
    for name in asked:
        end, tried, no, rng = (
            time.monotonic() + 60 * minutes / len(asked),
            0,
            0,
            int(time.time()),
        )
        while time.monotonic() < end:
            rng += 1
            try:
                done, not_read = attack(name, known[name], examples=100, rng=rng)
            except Exception as error:
                faults += 1
                smallest = "\n".join(getattr(error, "__notes__", []))[:1500]
                print(
                    f"FAULT {name}: {error!r} in {error_place(error)}\n{smallest}",
                    flush=True,
                )
                break
            tried, no = tried + done, no + not_read
        print(f"{name}: {tried} tried, {no} refused", flush=True)
    sys.exit(1 if faults else 0)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("minutes", type=float, nargs="?", default=10.0)
    parser.add_argument("files", nargs="*")
    main(**vars(parser.parse_args()))
