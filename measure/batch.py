"""Measures any mix of photos, folders, recordings and bench folders."""

import os
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path

from benchtwin.measure.observe import observe, observe_or_fail
from benchtwin.vision.find_recordings import find_recordings, unread_files
from benchtwin.vision.measurement import MeasurementError, Observation
from benchtwin.vision.pile.repose import PileOptions
from benchtwin.vision.recording import Recording

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
        more = f" and {len(names) - MOST_NAMED} more" if len(names) > MOST_NAMED else ""
        named = ", ".join(names[:MOST_NAMED]) + more
        notes.append((folder.name, f"not read: {named} (benchtwin does not read it)"))
    return notes


def measure(
    paths: str | Path | Sequence[str | Path],
    options: PileOptions | None = None,
    trim: bool = False,
) -> Iterator[Observation]:
    """Observations of all recordings under `paths` (one path or several), one after the
    other; those of several together last."""
    chosen = [paths] if isinstance(paths, str | Path) else paths
    entries = find_all([Path(path) for path in chosen])
    yield from measure_each(
        entries, lambda recording: observe(recording, options, trim)
    )


def measure_each(
    entries: Sequence[Recording | MeasurementError],
    observe: Callable[[Recording], Observation],
) -> Iterator[Observation]:
    """`observe(recording)` of each entry, a failed one where it raises; those of
    several together last."""
    rolls: list[tuple[Recording, Observation]] = []
    for entry in entries:
        found = observe_or_fail(entry, observe)
        yield found
        keep_rolls(rolls, entry, found)
    yield from observe_together(rolls)


def keep_rolls(
    rolls: list[tuple[Recording, Observation]],
    entry: Recording | MeasurementError,
    found: Observation,
) -> None:
    """Append a roll to `rolls`, for `observe_together`, without its pictures."""
    if isinstance(entry, Recording) and entry.rig == "roll":
        rolls.append((entry, replace(found, pictures={})))


def observe_together(rolls: list[tuple[Recording, Observation]]) -> list[Observation]:
    """Quantities of several recordings together: the slope of the table under rolls in
    both directions."""
    if not rolls:
        return []
    from benchtwin.vision.motion.plate_slope import plate_slopes

    return plate_slopes(rolls)


def in_order(
    entries: Sequence[Recording | MeasurementError],
    one: Callable[[int, Recording | MeasurementError], Observation],
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
