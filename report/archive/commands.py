"""Command lines of `benchtwin pack` and `benchtwin unpack`: words and exit codes."""

from pathlib import Path

from benchtwin.report.archive.pack import Unpackable, pack
from benchtwin.report.archive.unpack import NoPack, Opened, unpack
from benchtwin.twin.command import DONE, FAILED, exit_code
from benchtwin.twin.versions import versions

MISUSES = (FileNotFoundError, FileExistsError, Unpackable, NoPack)
NOTHING = "nothing was written"
SHOWN = 3  # names in a sentence


def pack_command(
    bench: Path, results: list[Path], out: Path, runs: bool, quiet: bool
) -> int:
    """Pack a bench and its results; returns the exit code."""

    def work() -> int:
        packed = pack(bench, results, out, runs)
        if quiet:
            return DONE
        held = (p for p in (out, *out.rglob("*")) if p.is_file())
        size = sum(p.stat().st_size for p in held) / 1e6
        print(f"{out}: {len(packed.files)} files, {size:.1f} MB")
        if packed.left_out:
            why = "links, and prints of pages that name folders of this machine"
            print(f"left out ({why}): {_some(packed.left_out)}")
        if packed.located:
            print(f"where they were taken is in photos (EXIF): {_some(packed.located)}")
        return DONE

    return exit_code("pack", out, work, stopped=NOTHING, misuses=MISUSES)


def _some(names: list[str] | tuple[str, ...]) -> str:
    more = len(names) - SHOWN
    return ", ".join(names[:SHOWN]) + (f" and {more} more" if more > 0 else "")


def unpack_command(packed: Path, out: Path | None, quiet: bool) -> int:
    """Check a pack and copy it into a folder; returns the exit code."""

    def work() -> int:
        opened = unpack(packed, out)
        for line in _said(opened) if not (quiet and opened.whole) else ():
            print(line)
        return DONE if opened.whole else FAILED

    at = out or packed
    return exit_code("unpack", at, work, stopped=NOTHING, misuses=MISUSES)


def _said(opened: Opened) -> list[str]:
    """What a reader of a pack has to know."""
    lines = []
    if opened.missing:
        lines.append(f"missing: {_some(opened.missing)}")
    if opened.changed:
        lines.append(f"not as packed: {_some(opened.changed)}")
    if opened.longer:
        lines.append(f"longer than packed, and not copied: {_some(opened.longer)}")
    if opened.unlisted:
        lines.append(f"not listed, and not copied: {_some(opened.unlisted)}")
    if opened.whole:
        lines.append("every file is as it was packed")
    here = versions()["benchtwin"]
    if opened.version != here:
        lines.append(
            f"packed by benchtwin {opened.version}; this is {here}: its numbers stand,"
            " computed again they may differ"
        )
    others = [
        f"{name} {then} (here {now})"
        for name, (then, now) in opened.other_versions.items()
        if name != "benchtwin"
    ]
    return [*lines, *([f"made with {', '.join(others)}"] if others else [])]
