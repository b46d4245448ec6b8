"""What the commands have in common: folders checked before anything runs, progress, and
a report whose fault costs no result."""

import traceback
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from rich.progress import Progress, SpinnerColumn, TimeElapsedColumn

from benchtwin.bench.exits import FAILED, Misuse, say
from benchtwin.bench.terminal import Terminal, Words

if TYPE_CHECKING:
    from benchtwin.twin.bench_folder import Observed


def check_out(
    out: Path, ours: set[str], what: str, result: str = "", overwrite: bool = True
) -> set[str]:
    """Names of what `out` holds already, all of them in `ours`; `what` would have
    written them.

    FileExistsError where `out` is a file, holds something else, or the file `result`
    that is not to be overwritten."""
    if out.exists() and not out.is_dir():
        raise FileExistsError(f"{out}: is a file; --out names a folder")
    if out.is_dir():
        there = {p.name for p in out.iterdir() if not p.name.startswith(".")}
    else:
        there = set()
    other = f"{out}: holds {{}}; choose another --out"
    if there - ours:
        raise FileExistsError(
            other.format(f"{sorted(there - ours)[0]}, which no {what} wrote")
        )
    if result in there and not overwrite:
        raise FileExistsError(
            other.format(f"a {what} already") + ", or say --overwrite"
        )
    return there


def check_bench(bench: "Path | Observed", out: Path) -> None:
    """FileNotFoundError without a bench folder; Misuse where `out` lies in it, but for
    a folder that is marked as results."""
    from benchtwin.twin.bench_folder import among_results

    if not Path(bench).is_dir():
        what = "is not a folder" if Path(bench).exists() else "no such folder"
        raise FileNotFoundError(f"{bench}: {what}")
    folder, place = Path(bench).resolve(), out.resolve()
    inside = folder in place.parents and not among_results(place, folder)
    if place == folder or inside:
        why = (
            "lies within the bench folder, whose recordings it would be taken for;"
            " choose another"
        )
        raise Misuse(f"--out {out}: {why}")


@contextmanager
def progress_line(quiet: bool) -> Iterator[Callable[[object], None]]:
    """A function that shows what is being done, in a line of the terminal that goes
    away."""
    columns = (SpinnerColumn(), Words("{task.description}"), TimeElapsedColumn())
    console = Terminal(stderr=True)
    with Progress(*columns, console=console, disable=quiet, transient=True) as progress:
        task = progress.add_task("", total=None)
        yield lambda state: progress.update(task, description=str(state))


def print_lines(console: Terminal, *lines: str) -> None:
    """Sentences, each on a line of its own."""
    for line in lines:
        console.print(line, soft_wrap=True)


def reported(write: Callable[[], object], kept: str, verb: str) -> bool:
    """Whether `write` wrote the report; a fault of ours in drawing it costs no more
    than a line that says what is `kept`."""
    try:
        write()
    except OSError:
        raise  # a full disk, no permission: said as such
    except Exception as error:
        place = traceback.extract_tb(error.__traceback__)[-1]
        where = f"{Path(place.filename).name}:{place.lineno}"
        fault = (
            "report.html could not be drawn, a fault of benchtwin, please report it:"
            f" {error!r} in {where}; {kept}"
        )
        say(verb, fault, FAILED)
        return False
    return True
