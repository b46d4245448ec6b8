"""Packs a bench and its results into one folder or zip to keep and to publish, with the
hash of every file, the versions that made it, and nothing of the machine."""

import hashlib
import json
import os
import re
import shutil
import tempfile
import unicodedata
import zipfile
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from io import SEEK_END, BufferedIOBase, BytesIO
from pathlib import Path, PurePosixPath

from PIL import Image

from benchtwin.bench.exits import Misuse
from benchtwin.bench.numbers import with_interval
from benchtwin.bench.whole_file import new_folder, whole
from benchtwin.report import draw
from benchtwin.report.template import PAGE, PRINTED
from benchtwin.twin.bench_folder import among_results
from benchtwin.twin.versions import versions

MANIFEST, ABOUT = "pack.json", "README.md"
MOST_LISTED = 16_000_000  # bytes of a manifest: some 80,000 files
SHOWN = 3  # names in a sentence
FORMAT = 1  # of the manifest; to be raised when older programs cannot read it


RUNS = "runs"  # of simulations: large, and computed again by the same command
ZIP = ".zip"
WRITTEN_AT = (1980, 1, 1, 0, 0, 0)  # of every file in a zip: the same content, one file


def stays_within(name: str) -> bool:
    """Whether a file's name stays, on every system, within the folder that it is
    written into, and can be shown."""
    parts = PurePosixPath(name).parts
    clean = not any(c in "\\:" or unicodedata.category(c) in ("Cc", "Cs") for c in name)
    return bool(parts) and clean and ".." not in parts and parts[0] != "/"


def some(names: Sequence[str]) -> str:
    """The first few of some names, and how many more there are."""
    more = len(names) - SHOWN
    return ", ".join(names[:SHOWN]) + (f" and {more} more" if more > 0 else "")


TEXTS = {".json", ".csv", ".html", ".toml", ".md", ".txt", ".svg", ".log", ".in"}
TEXTS |= {".data", ".bodies", ".xml", ".trk"}
PHOTOS = {".jpg", ".jpeg", ".tif", ".tiff", ".png", ".webp"}
GPS = 0x8825  # the EXIF directory of where a photo was taken
HERE = "."  # in the place of a folder that no reader has


class Machine:
    """The folders by which a file can tell of this machine, longest first, and what
    stands for each in a pack. places: {folder: its name in the pack}."""

    def __init__(self, places: Mapping[Path, str]) -> None:
        known = {folder.resolve(): name for folder, name in places.items()}
        around = (Path.cwd(), Path.home(), Path(tempfile.gettempdir()))
        known = dict.fromkeys((p.resolve() for p in around), HERE) | known
        told = {str(folder): name for folder, name in known.items()}
        told |= {json.dumps(text)[1:-1]: name for text, name in told.items()}
        self.known = {text: told[text] for text in sorted(told, key=len, reverse=True)}
        names = "|".join(re.escape(t) for t in self.known if t.strip("/\\"))
        self.folders = re.compile(rf"(?<![\w./\\-])({names})(?![\w-])")

    def cleaned(self, path: Path) -> Path | str:
        """The file, or its text with folders of this machine replaced."""
        text = _text(path)
        if text is None or not self.folders.search(text):
            return path
        return self.folders.sub(lambda found: self.known[found[1]], text)

    def named_in(self, path: Path) -> str:
        """A folder of this machine that a text file names; "" where it names none."""
        found = self.folders.search(_text(path) or "")
        return found[1] if found else ""

    def is_located(self, path: Path) -> bool:
        """Whether a photo says where it was taken."""
        if path.suffix.lower() not in PHOTOS:
            return False
        try:
            with Image.open(path) as photo:
                return bool(photo.getexif().get_ifd(GPS))
        except (OSError, ValueError, SyntaxError):
            return False  # what is no photo says nothing


def _text(path: Path) -> str | None:
    """A text file's content; None of another."""
    if path.suffix.lower() not in TEXTS:
        return None
    try:
        return path.read_bytes().decode("utf8")
    except UnicodeDecodeError:
        return None


RESULT = "result.json"
KINDS = {
    RESULT: "a calibration",
    "diagnosis.json": "a diagnosis",
    "prediction.json": "a prediction",
    "measurements.csv": "measurements",
}


def about(name: str, files: Mapping[str, Path | str], runs: bool) -> str:
    """README.md as text. files: what else is in the pack."""
    folders = sorted({"/".join(at.split("/")[:2]) for at in files})
    results = [folder for folder in folders if folder.startswith("results/")]
    lines = [
        f"# {name}: recordings and results",
        "",
        f"Made with benchtwin {versions()['benchtwin']}. `{MANIFEST}` holds the SHA-256"
        " of every file and the versions of all libraries.",
        "",
        f"- `bench/{name}`: the recordings, with what is known of them (`bench.toml`,"
        " `recording.toml`)",
        *(f"- `{folder}`: {_kind(folder, files)}" for folder in results),
        "" if runs else "\nSimulated runs are left out; the commands below make them.",
        "",
        *_parameters(files, results),
        "## To compute it again",
        "",
        f"With benchtwin {versions()['benchtwin']}; options and the seed of the random"
        f" numbers stand in each {RESULT}:",
        "",
        "```sh",
        f"benchtwin measure bench/{name} --out measured",
        f"benchtwin calibrate bench/{name} --out calibrated",
        "```",
        "",
        "## To cite",
        "",
        "benchtwin (CITATION.cff in its repository), and the sources of what was not"
        " measured:",
        "",
        *sorted({f"- {source}" for source in _sources(files, results)}),
        "",
    ]
    return "\n".join(lines)


def _kind(folder: str, files: Mapping[str, Path | str]) -> str:
    there = [what for file, what in KINDS.items() if f"{folder}/{file}" in files]
    return there[0] if there else "results"


def _results(
    files: Mapping[str, Path | str], results: list[str]
) -> Iterator[tuple[str, dict]]:
    """The calibrations among the results; one that cannot be read tells nothing."""
    for folder in results:
        content = files.get(f"{folder}/{RESULT}")
        if content is not None:
            text = content if isinstance(content, str) else content.read_text("utf8")
            try:
                yield folder, json.loads(text)
            except ValueError:
                continue


def _parameters(files: Mapping[str, Path | str], results: list[str]) -> Iterator[str]:
    for folder, result in _results(files, results):
        yield from (f"## Contact parameters, `{folder}`", "")
        yield from ("| parameter | value (95 % interval) | |", "|---|---|---|")
        for key, row in result.get("parameters", {}).items():
            value = with_interval(row["value"], row["low"], row["high"])
            yield f"| {draw.name(key)} | {value} | {row['status']} |"
        rolling = result.get("conventions", {}).get("rolling_means", "")
        yield from ("", f"Rolling friction: {rolling}.", "")


def _sources(files: Mapping[str, Path | str], results: list[str]) -> Iterator[str]:
    for _, result in _results(files, results):
        for material in result.get("materials", {}).values():
            if isinstance(material, dict) and material.get("source"):
                yield str(material["source"])


@dataclass
class Packed:
    """files: {name in the pack: content's path, or its text where it was changed};
    left_out: links, by name; located: photos that say where they were taken."""

    files: dict[str, Path | str] = field(default_factory=dict)
    left_out: list[str] = field(default_factory=list)
    located: list[str] = field(default_factory=list)

    def in_words(self, out: Path) -> list[str]:
        """What stands in `out` now, and what does not."""
        held = (p for p in (out, *out.rglob("*")) if p.is_file())
        size = sum(p.stat().st_size for p in held) / 1e6
        lines = [f"{out}: {len(self.files)} files, {size:.1f} MB"]
        if self.left_out:
            why = "links, and prints of pages that name folders of this machine"
            lines.append(f"left out ({why}): {some(self.left_out)}")
        if self.located:
            where = "where they were taken is in photos (EXIF)"
            lines.append(f"{where}: {some(self.located)}")
        return lines


def pack(bench: Path, results: Sequence[Path], out: Path, runs: bool = False) -> Packed:
    """Write bench/NAME, results/NAME for each folder of results, README.md and
    pack.json into the folder `out`, or the zip where its name ends so; it appears whole
    or not at all.

    runs: the simulations of results, too. Raises FileNotFoundError for a folder that
    is not there, FileExistsError where `out` is, Misuse for a bench whose own files
    name folders of this machine, OSError where it cannot be written."""
    for folder in (bench, *results):
        if not folder.is_dir():
            raise FileNotFoundError(f"{folder}: no such folder")
    if os.path.lexists(out):
        raise FileExistsError(f"{out}: is there already; choose another --out")
    for folder in (bench, *results):
        if folder.resolve() in (out.resolve(), *out.resolve().parents):
            raise Misuse(f"--out {out}: lies within {folder}, which is packed")
    gathered = _gathered(bench, results, runs)
    out.parent.mkdir(parents=True, exist_ok=True)
    if out.suffix == ZIP:
        with whole(out) as part:
            _as_zip(part, gathered.files)
    else:
        with new_folder(out) as part:
            _as_folder(part, gathered.files)
    return gathered


def _gathered(bench: Path, results: Sequence[Path], runs: bool) -> Packed:
    places = {bench: f"bench/{bench.resolve().name}"}
    for folder in results:
        name = f"results/{folder.resolve().name}"
        if name in places.values():
            raise Misuse(f"two folders of results are called {folder.name}")
        places[folder] = name
    machine, found = Machine(places), Packed()
    for folder, name in places.items():
        for inside, path in _walk(folder, found):
            if folder == bench and among_results(path, bench):
                continue
            if folder != bench and RUNS in inside.parts[:-1] and not runs:
                continue
            at = f"{name}/{inside.as_posix()}"
            if not stays_within(at):
                raise Misuse(f"{path}: a name that not every system can have")
            if path.name == PRINTED and _changed(machine, path.with_name(PAGE)):
                found.left_out.append(str(path))  # a print cannot be changed
                continue
            found.files[at] = path if folder == bench else machine.cleaned(path)
            if folder == bench:
                if named := machine.named_in(path):
                    raise Misuse(
                        f"{path}: names {named}, a place on this machine; name it from"
                        " the bench's folder on"
                    )
                found.located += [at] if machine.is_located(path) else []
    found.files[ABOUT] = about(bench.resolve().name, found.files, runs)
    found.files[MANIFEST] = _manifest(found.files)
    return found


def _changed(machine: Machine, page: Path) -> bool:
    return page.is_file() and isinstance(machine.cleaned(page), str)


def _walk(folder: Path, found: Packed) -> Iterator[tuple[Path, Path]]:
    """Files of a folder by their place in it; hidden ones are no part of it, links are
    named."""
    for path in sorted(folder.rglob("*")):
        inside = path.relative_to(folder)
        hidden = any(part.startswith(".") for part in inside.parts)
        if path.is_symlink():
            found.left_out.append(str(path))
        elif path.is_file() and not hidden:
            yield inside, path


def _manifest(files: Mapping[str, Path | str]) -> str:
    rows = {}
    for at, content in sorted(files.items()):
        with stream_of(content) as stream:
            hashed, size = (
                hashlib.file_digest(stream, "sha256").hexdigest(),
                stream.seek(0, SEEK_END),
            )
        rows[at] = {"bytes": size, "sha256": hashed}
    told = {"format": FORMAT, "versions": versions(), "files": rows}
    text = json.dumps(told, indent=1, ensure_ascii=False)
    if len(text.encode()) > MOST_LISTED:
        raise Misuse(f"{len(rows):,} files are too many for one pack")
    return text


def stream_of(content: Path | str) -> BufferedIOBase:
    """A file's bytes, of films too large for the memory, too."""
    return BytesIO(content.encode()) if isinstance(content, str) else content.open("rb")


def _as_folder(part: Path, files: Mapping[str, Path | str]) -> None:
    for at, content in files.items():
        place = part / at
        place.parent.mkdir(parents=True, exist_ok=True)
        with stream_of(content) as source, place.open("wb") as target:
            shutil.copyfileobj(source, target)


def _as_zip(part: Path, files: Mapping[str, Path | str]) -> None:
    with zipfile.ZipFile(part, "w", zipfile.ZIP_DEFLATED) as held:
        for at, content in sorted(files.items()):
            told = zipfile.ZipInfo(at, WRITTEN_AT)
            told.compress_type = zipfile.ZIP_DEFLATED
            entry = held.open(told, "w", force_zip64=True)
            with stream_of(content) as source, entry as target:
                shutil.copyfileobj(source, target)
