"""Recordings split, joined, renamed, moved, removed and put back. Nothing is erased;
what is cut off in the middle is completed by doing it again."""

import filecmp
import itertools
import os
import shutil
from collections.abc import Iterable, Mapping
from contextlib import suppress
from pathlib import Path

import tomlkit

from benchtwin.bench.language import tr
from benchtwin.bench.whole_file import new_folder
from benchtwin.page import toml_file
from benchtwin.page.folder import (
    RESULTS,
    Folder,
    Refused,
    clean_name,
    numbered,
)
from benchtwin.vision.evidence.film_or_photos import numbered_runs
from benchtwin.vision.measurement import MeasurementError
from benchtwin.vision.recording import Recording

REMOVED = ".removed"  # in a bench: what was taken out of it, each in a numbered folder
OF_ONE_PICTURE = ("baseline_px", "roi_px", "window_pct")  # keys of [pile]


def split_into_photos(recording: Recording, folder: Folder) -> list[Path]:
    """A pile for each picture of the recording, named as the picture is; the recording
    as it was is removed."""
    bench = _bench_of(recording.path, folder)
    if recording.evidence not in ("photos", "frames") or len(recording.files) < 2:
        raise Refused(tr("{}: there is nothing to split", recording.id))
    keys, files = _keys(recording, "pile"), recording.files
    made = [_made(bench, f.stem, {f.name: f}, keys, folder) for f in files]
    remove(recording.path, folder)
    return made


def series(
    recording: Recording, entries: Iterable[Recording | MeasurementError]
) -> list[Recording]:
    """The recordings of one photo each, `recording` among them, whose names differ in
    their number alone, in its order; or `recording` itself where it has several."""
    if recording.evidence != "photos":
        return []
    if len(recording.files) > 1:
        return [recording]
    single = {
        e.files[0].name: e
        for e in entries
        if isinstance(e, Recording) and e.evidence == "photos" and len(e.files) == 1
    }
    for names in numbered_runs(single, least=2).values():
        if recording.files[0].name in names:
            return [single[name] for name in names]
    return []


def join_as_film(recordings: list[Recording], folder: Folder) -> Path:
    """A film of the recordings' photos, in the order of their numbers, with the keys of
    the first; the recordings as they were are removed."""
    bench = _bench_of(recordings[0].path, folder)
    files = {f"frames/{f.name}": f for r in recordings for f in r.files}
    runs = numbered_runs([f.name for r in recordings for f in r.files], least=2)
    if len(runs) != 1 or len(next(iter(runs.values()))) != len(files):
        raise Refused(
            tr(
                "the frames of a film have one name and a number each: drop_0001.png,"
                " drop_0002.png, …"
            )
        )
    name = next(iter(runs)).strip("-_ ") or "film"
    if len(recordings) == 1:
        name = f"{recordings[0].path.name}-film"
    made = _made(bench, name, files, _keys(recordings[0], None), folder)
    for recording in recordings:
        remove(recording.path, folder)
    return made


def own_folder(photo: Path, folder: Folder) -> Path:
    """The recording that a photo which lies loose in a folder becomes, so that keys and
    corrections have a place."""
    files, keys = {photo.name: photo}, 'rig = "pile"\n'
    made = _made(photo.parent, photo.stem, files, keys, folder)
    if (made / photo.name).samefile(photo):
        photo.unlink()  # the same file by another name
    else:
        remove(photo, folder)
    return made


def rename(path: Path, name: str, folder: Folder) -> Path:
    """Give a recording another name; Refused where that is taken."""
    bench = _bench_of(path, folder)
    if not name.strip():
        raise Refused(tr("say the new name first"))
    name = clean_name(name)
    if path.is_file() and not name.endswith(path.suffix):
        name += path.suffix
    if name in (RESULTS, "frames"):
        raise Refused(tr("{} is not a name for a recording", name))
    if (bench / name).exists():
        raise Refused(tr("{} exists already; nothing was replaced", name))
    if (file := path / "recording.toml").is_file():
        keys = toml_file.read(file)
        if "id" in keys.content:  # it would be shown in the place of the name
            toml_file.change(keys, {("", "id"): None})
    return _renamed(path, bench / name)


def move(path: Path, bench: Path, folder: Folder) -> Path:
    """Put a recording into another bench; Refused where its name is taken there."""
    _bench_of(path, folder)
    return _renamed(path, bench / path.name)


def remove(path: Path, folder: Folder) -> Path:
    """Take a recording out of its bench, into REMOVED; returns where it lies now."""
    bench = _bench_of(path, folder)
    place = folder.inside(folder.name_of(bench / REMOVED))
    place.mkdir(exist_ok=True)
    last = max((int(p.name) for p in place.iterdir() if p.name.isdigit()), default=0)
    for number in itertools.count(last + 1):
        with suppress(FileExistsError):  # of another page on the same bench
            (place / f"{number:04d}").mkdir()
            break
    return _renamed(path, place / f"{number:04d}" / path.name)


def removed(bench: Path) -> list[Path]:
    """What was removed from a bench, the last first."""
    with suppress(OSError):
        places = [p for p in (bench / REMOVED).iterdir() if p.name.isdigit()]
        places.sort(key=lambda p: -int(p.name))
        return [one for place in places for one in sorted(place.iterdir())]
    return []


def put_back(path: Path, bench: Path) -> Path:
    """Put what was removed into the bench again, under another name where its own is
    taken meanwhile."""
    target = next(bench / n for n in numbered(path.name) if not (bench / n).exists())
    back = _renamed(path, target)
    with suppress(OSError):
        path.parent.rmdir()
    return back


def _bench_of(path: Path, folder: Folder) -> Path:
    if path.resolve() == folder.root.resolve():
        raise Refused(tr("this is the folder that the page was opened on"))
    return folder.inside(folder.name_of(path.parent))


def _renamed(path: Path, target: Path) -> Path:
    if not path.exists():
        raise Refused(tr("{}: no longer there", path.name))
    if target.exists():
        raise Refused(tr("{} exists already; nothing was replaced", target.name))
    path.rename(target)
    return target


def _made(
    bench: Path, name: str, files: Mapping[str, Path], keys: str, folder: Folder
) -> Path:
    """A recording of these files with these keys; one that was made of them before,
    when this was cut off, is kept."""
    for one in numbered(clean_name(name)):
        target = bench / one
        if target.is_dir() and all(_same(target / n, f) for n, f in files.items()):
            return target
        if not target.exists():
            break
    with new_folder(target) as part:
        for inside, file in files.items():
            (part / inside).parent.mkdir(exist_ok=True)
            _link(folder.inside(folder.name_of(file)), part / inside)
        (part / "recording.toml").write_text(keys, encoding="utf8")
    return target


def _link(file: Path, target: Path) -> None:
    """The same file by another name; a copy where the disk knows no such links."""
    try:
        os.link(file, target)
    except OSError:
        shutil.copy2(file, target)


def _same(one: Path, other: Path) -> bool:
    if not one.is_file():
        return False
    return one.samefile(other) or filecmp.cmp(one, other, shallow=False)


def _keys(recording: Recording, rig: str | None) -> str:
    """recording.toml for what is made of a recording: without what held for its
    pictures as they were."""
    file = recording.path / "recording.toml"
    keys = toml_file.parsed(toml_file.text_of(file), file)
    pile = keys.get("pile", {})
    for place, names in ((pile, OF_ONE_PICTURE), (keys, ("id", "rig", "track"))):
        for name in names:
            place.pop(name, None)
    line = f'rig = "{rig}"' if rig else '# rig = "drop"             # or slide, roll'
    return f"{line}\n{tomlkit.dumps(keys)}"
