"""What the commands have in common: folders that are checked before anything runs, and a report whose fault costs no result."""

import sys
import traceback
from collections.abc import Callable
from pathlib import Path


class Misuse(ValueError):
    """The command was typed wrongly."""


def check_folders(bench: Path, out: Path, ours: set[str], what: str) -> set[str]:
    """Names of what `out` holds already, all of them in `ours`; `what` would have written them ("calibration").

    FileNotFoundError without a bench folder; FileExistsError where `out` is a file or holds something else; Misuse in `bench`,
    but for a folder that is marked as results.
    """
    from twin.bench_folder import among_results

    if not bench.is_dir():
        raise FileNotFoundError(f"{bench}: {'is not a folder' if bench.exists() else 'no such folder'}")
    if out.exists() and not out.is_dir():
        raise FileExistsError(f"{out}: is a file; --out names a folder")
    inside = bench.resolve() in out.resolve().parents and not among_results(out.resolve(), bench.resolve())
    if out.resolve() == bench.resolve() or inside:
        raise Misuse(f"--out {out}: lies within the bench folder, whose recordings it would be taken for; choose another")
    there = {p.name for p in out.iterdir() if not p.name.startswith(".")} if out.is_dir() else set()
    if there - ours:
        raise FileExistsError(f"{out}: holds {sorted(there - ours)[0]}, which no {what} wrote; choose another --out")
    return there


def reported(write: Callable[[], object], kept: str, verb: str) -> bool:
    """Whether `write` wrote the report; a fault of ours in drawing it costs no more than a line that says what is `kept`."""
    try:
        write()
    except OSError:
        raise  # a full disk, no permission: said as such
    except Exception as error:
        place = traceback.extract_tb(error.__traceback__)[-1]
        where = f"{Path(place.filename).name}:{place.lineno}"
        fault = f"report.html could not be drawn, a fault of benchtwin, please report it: {error!r} in {where}; {kept}"
        print(f"benchtwin {verb}: {fault}", file=sys.stderr)
        return False
    return True
