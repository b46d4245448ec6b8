"""Everything under some paths measured, one recording after another, and written into
a folder where one is named."""

import os
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from functools import partial
from pathlib import Path

from rich.progress import BarColumn, TimeRemainingColumn
from rich.progress import Progress as Bar

from benchtwin.bench.language import tr
from benchtwin.bench.terminal import Terminal, Words
from benchtwin.measure.batch import (
    Entry,
    Progress,
    find_all,
    measure_each,
    unread_notes,
)
from benchtwin.measure.observe import observe_or_fail, observe_seeds_photo
from benchtwin.measure.observed import Observed, PackedPictures
from benchtwin.vision.measurement import Observation
from benchtwin.vision.pile.repose import PileOptions
from benchtwin.vision.results import Results

Notes = tuple[tuple[str, str], ...]


def existing(paths: str | Path | Sequence[str | Path]) -> list[Path]:
    """One path or several as a list; FileNotFoundError for one that is not there."""
    chosen = [Path(p) for p in ([paths] if isinstance(paths, str | Path) else paths)]
    if missing := [path for path in chosen if not path.exists()]:
        raise FileNotFoundError(tr("{}: no such file or folder", missing[0]))
    return chosen


@contextmanager
def results_in(
    out: str | Path | None, inputs: list[Path], notes: Notes, overwrite: bool
) -> Iterator[Callable[[Observation], None]]:
    """What adds an observation to the results in `out`, which appear whole or not at
    all when the block ends; nothing is written without it. OSError where `out` cannot
    be written."""
    if out is None:
        yield lambda observation: None
        return
    results = Results(Path(out), inputs, overwrite)
    results.notes += notes
    try:
        yield results.add
        results.finish()
    except OSError as error:
        why = error.strerror or error
        raise OSError(tr("cannot write to {}: {}", out, why)) from error
    finally:
        results.abandon()


def observed_under(
    paths: list[Path], options: PileOptions | None, trim: bool
) -> tuple[Observed, Notes]:
    """The recordings under these paths, not looked at yet, and notes on files that are
    not read."""
    entries = find_all(paths)
    observed = Observed(_folder_of(paths), tuple(entries), options, trim)
    return observed, tuple(unread_notes(paths, entries))


def measured(
    observed: Observed, *, seeds: bool, progress: bool
) -> Iterator[Observation]:
    """What is measured on each recording. seeds: of photos of spread seeds; progress:
    shown on stderr."""

    def one(entry: Entry, tell: Progress) -> Observation:
        if seeds:
            return observe_or_fail(entry, observe_seeds_photo, "seeds")
        return observe_or_fail(entry, partial(observed.observe, progress=tell))

    with _bar(len(observed.entries), progress) as told:
        for found in measure_each(observed.entries, one, told):
            yield _packed(found)


@contextmanager
def _bar(total: int, shown: bool) -> Iterator[Callable[[float, Entry], None]]:
    """A bar on stderr; yields what moves it."""
    columns = (
        Words("{task.description}"),
        BarColumn(),
        Words("{task.completed:.0f}/{task.total}"),
        TimeRemainingColumn(),
    )
    console = Terminal(stderr=True)
    with Bar(*columns, console=console, disable=not shown, transient=True) as bar:
        task = bar.add_task("measuring", total=total)
        yield lambda done, entry: bar.update(
            task, completed=done, description=getattr(entry, "id", "?")[:40]
        )


def _packed(observation: Observation) -> Observation:
    """Megabytes a recording become a tenth; those kept by an `Observed` are packed."""
    if isinstance(observation.pictures, PackedPictures):
        return observation
    return replace(observation, pictures=PackedPictures(observation.pictures))


def _folder_of(paths: Sequence[Path]) -> Path:
    """The one path, or the folder that holds all of them."""
    if len(paths) == 1:
        return paths[0]
    return Path(os.path.commonpath([path.resolve() for path in paths] or [Path.cwd()]))
