"""Command line of `benchtwin export`: options, files written, exit code."""

from pathlib import Path

from benchtwin.calibrate.export import cards, read_result
from benchtwin.twin.command import DONE, FAILED, MISUSED, say


def export_command(
    folder: Path, engine: str, out: Path | None, overwrite: bool, quiet: bool
) -> int:
    """Write an engine's cards of folder/result.json into `out` (folder/export/ENGINE);
    returns the exit code."""
    out = out or folder / "export" / engine
    try:
        texts = cards_for(folder, engine, out, overwrite)
    except (ValueError, OSError) as error:
        return say("export", error, MISUSED)
    try:
        write_cards(texts, out)
    except OSError as error:
        return say(
            "export", f"cannot write to {out}: {error.strerror or error}", FAILED
        )
    if not quiet:
        print("\n".join(str(out / name) for name in texts))
    return DONE


def cards_for(folder: Path, engine: str, out: Path, overwrite: bool) -> dict[str, str]:
    """Texts of an engine's cards by file name; FileExistsError where `out` holds one of
    them and it must not be replaced."""
    texts = cards(read_result(folder), engine)
    there = [name for name in texts if (out / name).exists()]
    if there and not overwrite:
        raise FileExistsError(
            f"{out / there[0]} exists already: name another --out, or say --overwrite"
        )
    return texts


def write_cards(texts: dict[str, str], out: Path) -> None:
    """Write cards into the folder `out`."""
    out.mkdir(parents=True, exist_ok=True)
    for name, text in texts.items():
        (out / name).write_text(text, encoding="utf8")
