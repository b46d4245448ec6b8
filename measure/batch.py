"""Measures any mix of photos, folders, recordings and bench folders."""

import os
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path

from benchtwin.bench.language import tr
from benchtwin.bench.rigs import RIGS
from benchtwin.vision.find_recordings import find_recordings, unread_files
from benchtwin.vision.measurement import MeasurementError, Observation
from benchtwin.vision.recording import Recording

Entry = Recording | MeasurementError
Progress = Callable[[float], None]
Seen = list[tuple[Recording, Observation]]
MOST_NAMED = 8  # files in one note


def split_photos(recording: Recording) -> list[Recording]:
    """A pile recording of several photos as a recording for each photo, named
    recording/photo; what may be a film stays whole."""
    if recording.evidence != "photos" or recording.rig is None:
        return [recording]
    if len(recording.files) < 2:
        return [recording]
    return [
        replace(recording, id=f"{recording.id}/{file.stem}", files=(file,))
        for file in recording.files
    ]


def find_all(paths: list[Path]) -> list[Recording | MeasurementError]:
    """All recordings under `paths` with unique ids (a second "pile-01" becomes
    "bench-b/pile-01")."""
    found: dict[
        tuple, Recording | MeasurementError
    ] = {}  # by evidence, which counts once
    for entry in (entry for path in paths for entry in find_recordings(path)):
        for one in split_photos(entry) if isinstance(entry, Recording) else [entry]:
            files: list[Path | str] = [str(one)]
            if isinstance(one, Recording):
                files = [f.resolve() for f in one.files]
            found.setdefault(tuple(files), one)
    times = Counter(
        entry.id for entry in found.values() if isinstance(entry, Recording)
    )
    unique: list[Recording | MeasurementError] = []
    taken: Counter[str] = Counter()
    for entry in found.values():
        if isinstance(entry, Recording):
            if times[entry.id] > 1:
                entry = replace(
                    entry, id=f"{entry.path.resolve().parent.name}/{entry.id}"
                )
            taken[entry.id] += 1
            if taken[entry.id] > 1:
                entry = replace(entry, id=f"{entry.id}-{taken[entry.id]}")
        unique.append(entry)
    return unique


def unread_notes(
    paths: Sequence[Path], entries: list[Recording | MeasurementError]
) -> list[tuple[str, str]]:
    """(folder, note) for every folder with files that are not read."""
    missed = {
        folder: names for path in paths for folder, names in unread_files(path, entries)
    }
    notes = []
    for folder, names in missed.items():
        more = (
            tr(" and {} more", len(names) - MOST_NAMED)
            if len(names) > MOST_NAMED
            else ""
        )
        named = ", ".join(names[:MOST_NAMED]) + more
        notes.append(
            (folder.name, tr("not read: {} (benchtwin does not read it)", named))
        )
    return notes


def measure_each(
    entries: Sequence[Entry],
    observe: Callable[[Entry, Progress], Observation],
    told: Callable[[float, Entry], None] = lambda done, entry: None,
) -> Iterator[Observation]:
    """`observe(entry, progress)` of each entry, in order; what several together give
    comes last. told: called with how many are done, and the entry that is measured."""

    def one(number: int, entry: Entry) -> Observation:
        told(number, entry)
        return observe(entry, lambda share: told(number + share, entry))

    seen: Seen = []
    found = _in_order(entries, one)
    for number, (entry, observation) in enumerate(zip(entries, found, strict=True), 1):
        yield observation
        if isinstance(entry, Recording) and entry.rig and RIGS[entry.rig].together:
            seen.append((entry, replace(observation, pictures={})))
        told(number, entry)
    yield from _together(seen)


def _together(seen: Seen) -> list[Observation]:
    """Quantities of several recordings of one rig together."""
    found: list[Observation] = []
    for name in dict.fromkeys(entry.need_rig() for entry, _ in seen):
        own = [(entry, one) for entry, one in seen if entry.rig == name]
        found += RIGS[name].part("together")(own)
    return found


def _in_order(
    entries: Sequence[Entry], one: Callable[[int, Entry], Observation]
) -> Iterator[Observation]:
    """`one(number, entry)` of every entry, in order; photos are measured ahead in at
    most 8 threads (0.5 GB each)."""
    workers = min(os.cpu_count() or 1, 8)
    begun: dict[int, Future] = {}
    with ThreadPoolExecutor(workers) as pool:
        for i, entry in enumerate(entries):
            for j in range(i, min(i + workers, len(entries))):
                if j not in begun and getattr(entries[j], "evidence", "") == "photos":
                    begun[j] = pool.submit(one, j, entries[j])
            yield begun.pop(i).result() if i in begun else one(i, entry)
