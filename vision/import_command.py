"""`benchtwin import` as a person meets it: files of other tools in, a drafted bench folder out, whole or not at all."""

import shutil
import sys
import tempfile
from dataclasses import replace
from pathlib import Path

from vision.foreign import tool_of
from vision.foreign.draft import DRAFTED, OF_ALL, WRITTEN, Draft, drafts_of, write_bench
from vision.measurement import MeasurementError
from vision.recording import RIGS

DONE, NOTHING, MISUSED = 0, 1, 2


def import_command(files: list[Path], out: Path, rig: str, track: int | None, overwrite: bool, quiet: bool) -> int:
    """Write the bench folder `out` from `files` (folders: the files of other tools in them); returns the exit code."""
    try:
        if rig and rig not in RIGS:
            raise MeasurementError(f"--rig {rig}: it is one of {', '.join(RIGS)}")
        paths = _files(files)
        _check_out(out, overwrite, paths)
    except (MeasurementError, OSError) as error:
        print(f"benchtwin import: {error}", file=sys.stderr)
        return MISUSED
    drafts, trouble = _read(paths, rig, track)
    for line in trouble:
        print(f"benchtwin import: {line}", file=sys.stderr)
    if not drafts:
        print(f"benchtwin import: nothing could be read; {out} is not written", file=sys.stderr)
        return NOTHING
    try:
        questions = _write(out, drafts, trouble)
    except OSError as error:
        print(f"benchtwin import: cannot write to {out}: {error.strerror or error}", file=sys.stderr)
        return MISUSED
    if not quiet:
        _show(out, drafts, questions)
    return DONE


def _files(paths: list[Path]) -> list[Path]:
    if missing := [p for p in paths if not p.exists()]:
        raise MeasurementError(f"{missing[0]}: no such file or folder")
    found = []
    for path in paths:
        inside = sorted(p for p in path.iterdir() if p.is_file() and tool_of(p)) if path.is_dir() else [path]
        if not inside:
            raise MeasurementError(f"{path}: no file of another tool in this folder")
        found += inside
    return list(dict.fromkeys(found))


def _check_out(out: Path, overwrite: bool, paths: list[Path]) -> None:
    """Nothing but a bench that this command drafted may be replaced, and nothing that is to be read."""
    if out.exists() and not out.is_dir():
        raise MeasurementError(f"{out}: is a file; --out names a folder")
    there = sorted(out.iterdir()) if out.is_dir() else []
    if there and not overwrite:
        raise MeasurementError(f"{out}: exists and is not empty; choose another --out, or say --overwrite")
    for path in there:
        if not _drafted(path):
            raise MeasurementError(f"{out}: holds something else than a drafted bench ({path.name}); it is not overwritten")
    if inside := [p for p in paths if p.resolve().is_relative_to(out.resolve())]:
        raise MeasurementError(f"{out}: holds {inside[0]}, which is to be read; choose another --out")


def _drafted(path: Path) -> bool:
    """Whether a part of a bench is as this command wrote it: no file of the user's lies in it."""
    if path.name == "bench.toml":
        return path.read_text(encoding="utf8", errors="replace").startswith(f"# {OF_ALL}")
    file = path / "recording.toml"
    if not file.is_file() or not (said := DRAFTED.match(file.read_text(encoding="utf8", errors="replace"))):
        return False
    return {p.name for p in path.iterdir()} <= {"recording.toml", *WRITTEN, said[1]}


def _read(paths: list[Path], rig: str, track: int | None) -> tuple[list[Draft], list[str]]:
    """The recordings in all files, each with a name of its own, and what could not be read."""
    drafts: list[Draft] = []
    trouble, taken = [], {"bench.toml"}
    for path in paths:
        try:
            found = list(drafts_of(path, rig, track))
        except (MeasurementError, OSError) as error:
            trouble.append(str(error))
            continue
        for draft in found:
            stem = "".join(c if c.isalnum() or c in "-_. " else "_" for c in draft.name)[:50].strip(". ") or "recording"
            name, number = stem, 2
            while name.lower() in taken:
                name, number = f"{stem}-{number}", number + 1
            taken.add(name.lower())
            drafts.append(replace(draft, name=name))
    return drafts, trouble


def _write(out: Path, drafts: list[Draft], trouble: list[str]) -> list[str]:
    """Write beside `out`, then put it in place: whole or not at all."""
    out.parent.mkdir(parents=True, exist_ok=True)
    part = Path(tempfile.mkdtemp(prefix=f".{out.name}-", dir=out.parent))
    old = part.with_name(f"{part.name}-old")
    try:
        questions = write_bench(part, drafts, trouble)
        part.chmod(0o755)
        if out.is_dir():
            out.replace(old)
        part.replace(out)
    finally:
        if old.is_dir() and not out.exists():
            old.replace(out)
        for folder in (part, old):
            shutil.rmtree(folder, ignore_errors=True)
    return questions


def _show(out: Path, drafts: list[Draft], questions: list[str]) -> None:
    for draft in drafts:
        rows = "copied" if draft.table is None else f"{len(draft.table)} rows"
        print(f"{draft.name}: {draft.rig or 'rig not known'}, {draft.evidence} ({rows}) from {draft.file.name} ({draft.tool})")
        for guess in draft.guesses:
            print(f"  guessed: {guess}")
    print(f"\n{len(questions)} questions; they stand in {out / 'bench.toml'} and beside each recording:")
    for question in questions:
        print(f"  {question}")
    print(f"\nAnswer what you can, then: benchtwin measure {out} --out measured")
