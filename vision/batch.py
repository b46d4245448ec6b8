"""Measure any mix of photos, folders, recordings and bench folders: one Observation each, then the files a user looks at."""

import itertools
import os
import shutil
import tempfile
import traceback
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
from PIL import Image

from vision.evidence.photo import read_photo
from vision.evidence.unusual import questions
from vision.measurement import FAILED, MeasurementError, Observation, Quantity, failed
from vision.overlay.contact_sheet import ContactSheet
from vision.pile.repose import PileOptions, measure_repose
from vision.recording import Recording, find_recordings, unread
from vision.summary import Line, as_table, summarise

COLUMNS = ["recording", "rig", "quantity", "value", "sd", "sd_common", "unit", "quality", "reason", "overlay"]
TABLES = ("bounces", "readings", "seeds")  # of all recordings together, one file each
LEAST_WINDOW = 0.1  # of the crest's height
LONGEST_NAME = 50  # characters of a file name, each four bytes at most
OWN = ("measurements.csv", "summary.csv", "notes.csv", *(f"{name}.csv" for name in TABLES), "overlays", "tracks")
MAIN_QUANTITY = {  # what a recording is made for, when it could not be measured at all
    "pile": ("repose_angle", "deg"),
    "drum": ("flowing_angle", "deg"),
    "drop": ("restitution", "1"),
    "slide": ("slide_angle", "deg"),
    "roll": ("run_out", "mm"),
    "seeds": ("seed_length", "mm"),
    None: ("recording", ""),
}

Progress = Callable[[float], None]


def observe(
    recording: Recording, options: PileOptions | None = None, trim: bool = False, progress: Progress | None = None
) -> Observation:
    """Measure one recording, whatever its rig and evidence; MeasurementError with the reason when nothing can be had.

    options: how pile photos are read; trim: leave out one highest and one lowest of repeated readings; progress: called with
    the fraction done.
    """
    found = _observe(recording, options, trim, progress)
    asked = questions(recording.seed)
    return replace(found, notes=(*found.notes, *asked)) if asked else found


def _observe(recording: Recording, options: PileOptions | None, trim: bool, progress: Progress | None) -> Observation:
    if recording.evidence == "readings.csv":
        from vision.evidence.readings import observe_readings

        return observe_readings(recording, trim)
    if recording.rig is None:
        raise MeasurementError(f"{recording.toml}: rig is missing; it should be drop, slide, roll, pile or drum")
    if recording.rig == "pile":
        return observe_pile(recording, options)
    if recording.rig == "drum":
        from vision.motion.drum import observe_drum

        return observe_drum(recording, progress)
    if recording.evidence == "photos":
        raise MeasurementError(f"{recording.path}: a {recording.rig} is measured on frames, a video or a track, not on a photo")
    from vision.motion.observe_motion import observe_moving

    return observe_moving(recording, progress)


def observe_pile(recording: Recording, options: PileOptions | None = None) -> Observation:
    """The first photo of a pile recording (`split_photos` makes one recording of each)."""
    from vision.overlay.pile import draw_repose

    if recording.evidence != "photos":
        raise MeasurementError(f"{recording.path}: a pile is measured on photos, not on {recording.evidence}")
    image = read_photo(recording.files[0])
    options = options or PileOptions()
    if not options.side and recording.pile.box_mm is not None and recording.pile.cylinder_mm is None:
        options = replace(options, side="right")  # the gate's side; the other leans on the box
    options = _with_stated(options, recording)
    try:
        found = measure_repose(image, recording.camera, options)
    except MeasurementError as error:
        raise MeasurementError(f"{recording.files[0]}: {error}") from error
    return Observation(recording.id, "pile", found.quantities, found.notes, {"pile": draw_repose(image, found)})


def _with_stated(options: PileOptions, recording: Recording) -> PileOptions:
    """Base line, region and window that the recording states, where the options do not say otherwise."""
    pile, typical = recording.pile, PileOptions()
    if options.baseline is None and pile.baseline_px is not None:
        options = replace(options, baseline=pile.baseline_px)
    if options.roi is None and pile.roi_px is not None:
        options = replace(options, roi=pile.roi_px)
    if options.window == typical.window and pile.window_pct is not None:
        low, high = (share / 100 for share in pile.window_pct)
        if high - low < LEAST_WINDOW:
            raise MeasurementError(f"{recording.toml}: [pile] window_pct: two heights in %, at least {100 * LEAST_WINDOW:g} apart")
        options = replace(options, window=(low, high))
    return options


def observe_seeds_photo(recording: Recording) -> Observation:
    """A photo of spread seeds: mean length and width (sd of the mean, the scale's included), and a row a seed."""
    from vision.shape.photo import observe_seeds

    if recording.evidence != "photos":
        raise MeasurementError(f"{recording.path}: seeds are measured on photos, not on {recording.evidence}")
    grains, overlay = observe_seeds(recording.files[0], recording.camera.mm_per_px, recording.camera.mm_per_px_sd)
    quantities = tuple(
        Quantity(f"seed_{row.quantity}", row.mean, row.mean_sd, row.unit) for row in grains.distribution().itertuples()
    )
    doubt = "in px: no scale is known" if grains.scale is None else getattr(grains.scale, "reason", "")
    if doubt:
        quantities = tuple(q.doubt(doubt) for q in quantities)
    rows = grains.distribution().itertuples()
    spread = [f"{r.quantity}: n = {r.n}, sd {r.sd:.3g}, range {r.min:.3g}–{r.max:.3g} {r.unit}" for r in rows]
    table = grains.table()
    table.insert(0, "recording", recording.id)
    return Observation(recording.id, "seeds", quantities, (*spread, *grains.notes), {"seeds": overlay}, seeds=table)


def split_photos(recording: Recording) -> list[Recording]:
    """A pile recording of several photos as one recording a photo, named recording/photo."""
    if recording.evidence != "photos" or len(recording.files) < 2:
        return [recording]
    return [replace(recording, id=f"{recording.id}/{file.stem}", files=(file,)) for file in recording.files]


def find_all(paths: list[Path]) -> list[Recording | MeasurementError]:
    """Every recording under `paths`, each with an id of its own (a second "pile-01" becomes "bench-b/pile-01")."""
    found: list[Recording | MeasurementError] = []
    met: set[tuple] = set()
    for path in paths:
        for entry in find_recordings(path):
            for one in split_photos(entry) if isinstance(entry, Recording) else [entry]:
                files = tuple(f.resolve() for f in one.files) if isinstance(one, Recording) else (str(one),)
                if files not in met:  # the same evidence named twice counts once
                    met.add(files)
                    found.append(one)
    ids = [r.id for r in found if isinstance(r, Recording)]
    unique = []
    seen: dict[str, int] = {}
    for entry in found:
        if isinstance(entry, Recording) and ids.count(entry.id) > 1:
            entry = replace(entry, id=f"{entry.path.resolve().parent.name}/{entry.id}")
        if isinstance(entry, Recording):
            seen[entry.id] = seen.get(entry.id, 0) + 1
            if seen[entry.id] > 1:
                entry = replace(entry, id=f"{entry.id}-{seen[entry.id]}")
        unique.append(entry)
    return unique


def unread_notes(paths: Sequence[Path], entries: list[Recording | MeasurementError]) -> list[tuple[str, str]]:
    """(folder, note) for every folder with files that nothing here reads, so that none is passed over without a word."""
    missed = {folder: names for path in paths for folder, names in unread(path, entries)}
    return [(folder.name, f"not read: {_listed(names)} (benchtwin does not read it)") for folder, names in missed.items()]


def _listed(names: list[str], most: int = 8) -> str:
    return ", ".join(names[:most]) + (f" and {len(names) - most} more" if len(names) > most else "")


def measure(
    paths: str | Path | Sequence[str | Path], options: PileOptions | None = None, trim: bool = False
) -> Iterator[Observation]:
    """Observations of all recordings under `paths` (one path or several), one after the other.

    What cannot be measured is an Observation whose one quantity has failed and says why. Last comes what only several together say.
    """
    rolls: list[tuple[Recording, Observation]] = []
    for entry in find_all([Path(p) for p in ([paths] if isinstance(paths, str | Path) else paths)]):
        found = observe_or_fail(entry, lambda recording: observe(recording, options, trim))
        yield found
        remember(rolls, entry, found)
    yield from of_all(rolls)


def remember(rolls: list[tuple[Recording, Observation]], entry: Recording | MeasurementError, found: Observation) -> None:
    """Keep what `of_all` asks of, without its pictures."""
    if isinstance(entry, Recording) and entry.rig == "roll":
        rolls.append((entry, replace(found, pictures={})))


def of_all(rolls: list[tuple[Recording, Observation]]) -> list[Observation]:
    """What only several recordings together say: the slope under rolls that were run both ways."""
    if not rolls:
        return []
    from vision.motion.plate_slope import plate_slopes

    return plate_slopes(rolls)


def observe_or_fail(
    entry: Recording | MeasurementError, observe: Callable[[Recording], Observation], rig: str | None = None
) -> Observation:
    """`observe(entry)`, with any trouble of this one recording turned into a failed quantity of its `rig`."""
    if isinstance(entry, MeasurementError):
        return _failure(entry.recording, rig, str(entry))
    bench = entry.path.resolve().parent.name
    return replace(_observed(entry, observe, rig), bench=bench, session=entry.session, conditions=entry.conditions)


def _observed(entry: Recording, observe: Callable[[Recording], Observation], rig: str | None) -> Observation:
    try:
        return observe(entry)
    except MeasurementError as error:
        reason = str(error)
    except OSError as error:
        reason = f"{error.filename or entry.path}: {error.strerror or error}"
    except MemoryError:
        reason = f"{entry.path}: too large for this machine's memory"
    except Exception as error:  # a fault of ours in one recording must not cost the others
        place = traceback.extract_tb(error.__traceback__)[-1]
        reason = f"{entry.path}: a fault of benchtwin, please report it: {error!r} in {Path(place.filename).name}:{place.lineno}"
    return _failure(entry.id, rig or entry.rig, reason)


def in_order(
    entries: Sequence[Recording | MeasurementError], one: Callable[[int, Recording | MeasurementError], Observation]
) -> Iterator[Observation]:
    """`one(number, entry)` of every entry, in order; photos are worked on ahead, as many at a time as there are processors (8 at
    most: each takes up to 0.5 GB), since most of a photo's work runs outside Python."""
    workers = min(os.cpu_count() or 1, 8)
    begun: dict[int, Future] = {}
    with ThreadPoolExecutor(workers) as pool:
        for i, entry in enumerate(entries):
            for j in range(i, min(i + workers, len(entries))):
                if j not in begun and getattr(entries[j], "evidence", "") == "photos":
                    begun[j] = pool.submit(one, j, entries[j])
            yield begun.pop(i).result() if i in begun else one(i, entry)


def _failure(name: str, rig: str | None, reason: str) -> Observation:
    quantity, unit = MAIN_QUANTITY[rig]
    return Observation(name, rig or "", (failed(quantity, unit, reason),))


class Results:
    """Gathers observations into a folder that appears whole or not at all.

    measurements.csv, summary.csv, notes.csv, and where there is something to put in them bounces.csv, readings.csv, seeds.csv,
    overlays/ (with a contact sheet, index.html), tracks/. Conditions that recordings state are columns of every table.
    """

    def __init__(self, out: Path, inputs: Sequence[Path] = (), overwrite: bool = False):
        self.out, self.overwrite = Path(out), overwrite
        if self.out.exists() and not self.out.is_dir():
            raise MeasurementError(f"{self.out}: is a file; --out names a folder")
        there = sorted(p.name for p in self.out.iterdir()) if self.out.is_dir() else []
        if there and not overwrite:
            raise MeasurementError(f"{self.out}: exists and is not empty; choose another --out, or say --overwrite")
        if foreign := [name for name in there if name not in OWN]:
            raise MeasurementError(f"{self.out}: holds something else than results ({foreign[0]}); it is not overwritten")
        for path in inputs:
            if there and path.resolve().is_relative_to(self.out.resolve()):
                raise MeasurementError(f"{self.out}: holds {path}, which is to be measured; choose another --out")
        self.out.parent.mkdir(parents=True, exist_ok=True)
        self.part = Path(tempfile.mkdtemp(prefix=f".{self.out.name}-", dir=self.out.parent))
        self.stems: set[str] = set()
        self.rows: list[dict] = []
        self.tables: dict[str, list[pd.DataFrame]] = {name: [] for name in TABLES}
        self.notes: list[tuple[str, str]] = []
        self.not_read: list[tuple[str, str]] = []  # of the notes, those on files that were left out
        self.observations: list[Observation] = []  # without their pictures and tracks
        self.sheet = ContactSheet()
        self.summary: list[Line] = []

    def add(self, observation: Observation) -> None:
        stem = _file_name(observation.recording, self.stems)
        self.stems.add(stem.lower())
        overlay = ""
        for i, (name, picture) in enumerate(observation.pictures.items()):
            file = Path("overlays") / (f"{stem}.png" if i == 0 else f"{stem}-{name}.png")
            (self.part / "overlays").mkdir(exist_ok=True)
            Image.fromarray(picture).save(self.part / file, compress_level=3)
            overlay = overlay or file.as_posix()
            self.sheet.add(file.name, name, observation)
        if observation.track is not None:
            (self.part / "tracks").mkdir(exist_ok=True)
            observation.track.to_csv(self.part / "tracks" / f"{stem}.csv", index=False, float_format="%.6g")
        for name, tables in self.tables.items():
            if (table := getattr(observation, name)) is not None and len(table):
                tables.append(_with_conditions(table, observation))
        self.notes += [(observation.recording, note) for note in observation.notes]
        for q in observation.quantities:
            row = (observation.recording, observation.rig, q.name, q.value, q.sd, q.sd_common, q.unit, q.quality, q.reason, overlay)
            self.rows.append({**observation.conditions, **dict(zip(COLUMNS, row))})
        self.observations.append(replace(observation, pictures={}, track=None, bounces=None, seeds=None))

    def finish(self) -> pd.DataFrame:
        """Write the tables and put the folder in place; returns the measurements."""
        conditions = dict.fromkeys(name for row in self.rows for name in row if name not in COLUMNS)
        table = pd.DataFrame(self.rows, columns=[*COLUMNS, *conditions])
        self.summary = summarise(self.observations)
        written = {"measurements": table, **{name: pd.concat(t, ignore_index=True) for name, t in self.tables.items() if t}}
        written["summary"] = as_table(self.summary)
        if self.notes:
            written["notes"] = pd.DataFrame(self.notes, columns=["recording", "note"])
        for name, rows in written.items():  # a folder's name need not be text that UTF-8 can say
            rows.to_csv(self.part / f"{name}.csv", index=False, float_format="%.6g", errors="backslashreplace")
        if (self.part / "overlays").is_dir():
            self.sheet.write(self.part / "overlays" / "index.html")
        self.part.chmod(0o755)
        if self.out.is_dir():
            for name in OWN if self.overwrite else ():
                _remove(self.out / name)
            self.out.rmdir()  # fails, and loses nothing, if something has come into it meanwhile
        self.part.replace(self.out)
        return table

    def abandon(self) -> None:
        shutil.rmtree(self.part, ignore_errors=True)


def _with_conditions(table: pd.DataFrame, observation: Observation) -> pd.DataFrame:
    """The table with a column for each condition of its recording; a column of its own comes before one of that name."""
    return table.assign(**{name: value for name, value in observation.conditions.items() if name not in table})


def _remove(path: Path) -> None:
    if path.is_dir() and not path.is_symlink():
        shutil.rmtree(path)
    else:
        path.unlink(missing_ok=True)


def _file_name(name: str, taken: set[str]) -> str:
    """An id as a file name: no folders, nothing a file system minds, none of those `taken` (in small letters)."""
    stem = "".join(c if c.isalnum() or c in "-_. " else "_" for c in name)[:LONGEST_NAME].strip(". ") or "recording"
    numbered = (f"{stem}-{n}" for n in itertools.count(2))
    return stem if stem.lower() not in taken else next(other for other in numbered if other.lower() not in taken)


def measured_anything(table: pd.DataFrame) -> bool:
    """Whether a table of measurements holds at least one finite value that has not failed."""
    return bool(len(table)) and bool((table["quality"] != FAILED).any()) and bool(np.isfinite(table["value"]).any())
