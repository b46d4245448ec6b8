"""`benchtwin import`: drafts a bench folder from files of other tools."""

from dataclasses import replace
from pathlib import Path

from benchtwin.bench.exits import DONE, FAILED, say
from benchtwin.bench.rigs import RIGS
from benchtwin.vision.foreign import tool_of
from benchtwin.vision.foreign.draft import (
    BENCH_HEADING,
    DRAFTED,
    WRITTEN,
    Draft,
    drafts_of,
    write_bench,
)
from benchtwin.vision.measurement import MeasurementError, require
from benchtwin.vision.out_folder import check_out, file_name, new_folder


def import_command(
    files: list[Path],
    out: Path,
    rig: str,
    track: int | None,
    overwrite: bool,
    quiet: bool,
) -> int:
    """Write the bench folder `out` from `files` (folders: the files of other tools in
    them); returns the exit code."""
    require(not rig or rig in RIGS, f"--rig {rig}: it is one of {', '.join(RIGS)}")
    if missing := [p for p in files if not p.exists()]:
        raise MeasurementError(f"{missing[0]}: no such file or folder")
    found: list[Path] = []
    for path in files:
        inside = sorted(path.iterdir()) if path.is_dir() else [path]
        told = [p for p in inside if p == path or (p.is_file() and tool_of(p))]
        require(told, f"{path}: no file of another tool in this folder")
        found += told
    paths = list(dict.fromkeys(found))
    check_out(out, "a drafted bench", _drafted, overwrite, paths)
    drafts, trouble = _read(paths, rig, track)
    for line in trouble:
        say("import", line, FAILED)
    if not drafts:
        said = f"nothing could be read; {out} is not written"
        return say("import", said, FAILED)
    with new_folder(out, _drafted, overwrite) as part:
        questions = write_bench(part, drafts, trouble)
    if not quiet:
        _show(out, drafts, questions)
    return DONE


def _drafted(path: Path) -> bool:
    """Whether a file or folder of a bench is as this command wrote it, without files of
    the user."""
    if path.name == "bench.toml":
        return path.read_text(encoding="utf8", errors="replace").startswith(
            f"# {BENCH_HEADING}"
        )
    file = path / "recording.toml"
    if not file.is_file() or not (
        match := DRAFTED.match(file.read_text(encoding="utf8", errors="replace"))
    ):
        return False
    return {p.name for p in path.iterdir()} <= {"recording.toml", *WRITTEN, match[1]}


def _read(
    paths: list[Path], rig: str, track: int | None
) -> tuple[list[Draft], list[str]]:
    """The recordings in all files, with unique names, and what could not be read."""
    drafts: list[Draft] = []
    trouble, taken = [], {"bench.toml"}
    for path in paths:
        try:
            found = [draft.with_name() for draft in drafts_of(path, rig, track)]
        except (MeasurementError, OSError) as error:
            trouble.append(str(error))
            continue
        for draft in found:
            drafts.append(replace(draft, name=file_name(draft.name, taken)))
            taken.add(drafts[-1].name.lower())
    return drafts, trouble


def _show(out: Path, drafts: list[Draft], questions: list[str]) -> None:
    for draft in drafts:
        rows = "copied" if draft.table.empty else f"{len(draft.table)} rows"
        print(
            f"{draft.name}: {draft.rig or 'rig not known'}, {draft.evidence} ({rows})"
            f" from {draft.file.name} ({draft.found.tool})"
        )
        for guess in draft.found.guesses:
            print(f"  guessed: {guess}")
    print(
        f"\n{len(questions)} questions; they stand in {out / 'bench.toml'} and beside"
        " each recording:",
        *(f"  {question}" for question in questions),
        f"\nAnswer what you can, then: benchtwin measure {out} --out measured",
        sep="\n",
    )
