"""`benchtwin measure`: options, progress, exit code."""

import re
import sys
from functools import partial
from pathlib import Path

import pandas as pd
from rich.progress import BarColumn, Progress, TimeRemainingColumn

from benchtwin.bench.terminal import Terminal, Words
from benchtwin.measure.batch import (
    find_all,
    in_order,
    keep_for_together,
    observe_together,
    unread_notes,
)
from benchtwin.measure.observe import observe, observe_or_fail, observe_seeds_photo
from benchtwin.vision.measurement import MeasurementError, Observation
from benchtwin.vision.pile.repose import PileOptions
from benchtwin.vision.recording import Recording
from benchtwin.vision.results import Results, measured_anything
from benchtwin.vision.terminal import show_results

MEASURED, NOTHING, MISUSED = 0, 1, 2


def measure_command(
    paths: list[Path],
    out: Path,
    window: str,
    roi: str,
    baseline: str,
    trim: bool,
    seeds: bool,
    overwrite: bool,
    quiet: bool,
) -> int:
    """Measure everything under `paths` into the folder `out`; returns the exit code."""
    try:
        options = PileOptions(_window(window), _roi(roi), _baseline(baseline))
        if missing := [p for p in paths if not p.exists()]:
            raise MeasurementError(f"{missing[0]}: no such file or folder")
        results = Results(out, paths, overwrite)
    except (MeasurementError, OSError) as error:
        print(f"benchtwin measure: {error}", file=sys.stderr)
        return MISUSED
    try:
        table = _run(paths, results, options, trim, seeds, quiet)
    except OSError as error:
        print(
            f"benchtwin measure: cannot write to {out}: {error.strerror or error}",
            file=sys.stderr,
        )
        return MISUSED
    except KeyboardInterrupt:
        print(
            f"\nbenchtwin measure: stopped; nothing was written to {out}",
            file=sys.stderr,
        )
        return NOTHING
    finally:
        results.abandon()
    if not quiet:
        show_results(table, results.summary, results.notes, results.not_read, out)
    elif not measured_anything(table):
        print(
            "benchtwin measure: nothing could be measured; the reasons are in"
            f" {out / 'measurements.csv'}",
            file=sys.stderr,
        )
    return MEASURED if measured_anything(table) else NOTHING


def _run(
    paths: list[Path],
    results: Results,
    options: PileOptions,
    trim: bool,
    seeds: bool,
    quiet: bool,
) -> pd.DataFrame:
    entries = find_all(paths)
    results.not_read = unread_notes(paths, entries)
    results.notes += results.not_read
    seen: list[tuple[Recording, Observation]] = []
    bar = (
        Words("{task.description}"),
        BarColumn(),
        Words("{task.completed:.0f}/{task.total}"),
        TimeRemainingColumn(),
    )
    with Progress(
        *bar, console=Terminal(stderr=True), disable=quiet, transient=True
    ) as progress:
        task = progress.add_task("measuring", total=len(entries))

        def one(i: int, entry: Recording | MeasurementError) -> Observation:
            progress.update(task, description=getattr(entry, "id", "?")[:40])
            if seeds:
                return observe_or_fail(entry, observe_seeds_photo, "seeds")

            def advance(share: float) -> None:
                progress.update(task, completed=i + share)

            return observe_or_fail(
                entry, partial(observe, options=options, trim=trim, progress=advance)
            )

        for i, (entry, observation) in enumerate(
            zip(entries, in_order(entries, one), strict=True)
        ):
            results.add(observation)
            keep_for_together(seen, entry, observation)
            progress.update(task, completed=i + 1)
    for together in observe_together(seen):
        results.add(together)
    return results.finish()


def _numbers(text: str, option: str, counts: tuple[int, ...]) -> list[float]:
    try:
        numbers = [float(part) for part in text.split(",")]
    except ValueError:
        numbers = []
    if len(numbers) not in counts or not all(abs(n) < 1e6 for n in numbers):
        wanted = " or ".join(str(c) for c in counts)
        raise MeasurementError(
            f"{option} {text}: expected {wanted} numbers with commas between"
        )
    return numbers


def _window(text: str) -> tuple[float, float]:
    parts = re.fullmatch(r"\s*([\d.]+)\s*%?\s*[-–,:]\s*([\d.]+)\s*%?\s*", text)
    try:
        low, high = (
            (float(part) / 100 for part in parts.groups()) if parts else (0.0, 0.0)
        )
    except ValueError:
        low, high = 0.0, 0.0
    if not 0 <= low < high <= 1 or high - low < 0.1:
        raise MeasurementError(
            f"--window {text}: expected two heights in %, at least 10 apart, such as"
            " 20-80"
        )
    return low, high


def _roi(text: str) -> tuple[int, int, int, int] | None:
    if not text:
        return None
    x, y, width, height = (int(n) for n in _numbers(text, "--roi", (4,)))
    return x, y, width, height


def _baseline(text: str) -> tuple[float, float, float, float] | None:
    if not text:
        return None
    numbers = _numbers(text, "--baseline", (1, 4))
    x1, y1, x2, y2 = (
        numbers if len(numbers) == 4 else (0.0, numbers[0], 1000.0, numbers[0])
    )
    if abs(x2 - x1) < 10 * abs(y2 - y1):
        raise MeasurementError(
            f"--baseline {text}: the two points must lie side by side (X1,Y1,X2,Y2)"
        )
    return x1, y1, x2, y2
