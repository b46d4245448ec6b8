"""`benchtwin prove`: the proof run, and its table in the terminal."""

import secrets
from pathlib import Path

import numpy as np
from rich.console import Console
from rich.table import Table

from benchtwin.prove.report import number, write_all
from benchtwin.prove.run import SOLVER, KeyMismatch, Settings, prove, seed_of
from benchtwin.prove.score import table

PROOF_FILES = {  # what a proof leaves in its folder
    "cases",
    "solutions",
    "hashes.json",
    "keys.json",
    "submitted.json",
    "prove.json",
    "cases.csv",
    "report.html",
    "report.pdf",
}


def prove_command(
    out: Path,
    cases: int,
    rng: int | None,
    *,
    workers: int,
    limit_s: float,
    solver: str = SOLVER,
    keep_frames: bool = False,
    quiet: bool = False,
) -> int:
    """Exit code 0: proved and scored, whatever the scores; 1: stopped or impossible; 2:
    misused."""
    console = Console(quiet=quiet, highlight=False)
    errors = Console(stderr=True, highlight=False)
    if cases < 1 or workers < 1:
        errors.print("benchtwin prove: --cases and --workers must be at least 1")
        return 2
    if out.exists() and not (
        out.is_dir()
        and {p.name for p in out.iterdir() if not p.name.startswith(".")} <= PROOF_FILES
    ):
        errors.print(
            f"benchtwin prove: {out}: holds what no proof wrote, or is a file; choose"
            " another --out"
        )
        return 2
    seed = secrets.randbits(32) if rng is None else rng
    try:
        judged = prove(
            Settings(out, cases, seed, workers, solver, limit_s, keep_frames),
            _progress(console),
        )
        seed = seed_of(out)
        rows = table(judged, np.random.default_rng(seed))
        write_all(out, judged, rows, seed)
    except KeyMismatch as error:
        errors.print(f"benchtwin prove: {error}")
        return 1
    except OSError as error:
        errors.print(
            f"benchtwin prove: {error.filename or out}: {error.strerror or error}"
        )
        return 1
    except KeyboardInterrupt:
        errors.print(
            "benchtwin prove: stopped. The same command with the same --rng goes on"
            " from here."
        )
        return 1
    printed = Table("score", "target", "found", "", title="All rigs")
    for row in (r for r in rows if r.rig == "all"):
        met = {None: "", True: "met", False: "not met"}[row.met]
        printed.add_row(row.score, row.target, number(row), met)
    console.print(printed)
    console.print(f"Rig by rig, with figures: {out / 'report.html'}")
    return 0


def _progress(console: Console):
    """Prints how far each stage is: every twentieth case, and at its end."""

    def show(stage: str, done: int, total: int, left_s: float) -> None:
        if done == total or done % max(1, total // 20) == 0:
            left = f"{left_s / 60:.0f} min" if left_s > 90 else f"{left_s:.0f} s"
            console.print(
                f"{stage}: {done} of {total}"
                + (f", about {left} left" if done < total else "")
            )

    return show
