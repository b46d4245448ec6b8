"""A whole bench with its results as one zip, to keep or to send."""

import secrets
import zipfile
from contextlib import suppress
from pathlib import Path

from calibrate.export import ENGINES
from page.folder import INCOMING, RESULTS, Folder, Refused
from page.results import CALIBRATED, card_files
from vision.recording import RESULTS_MARK

MOST_AT_ONCE = 4  # older packages are thrown away


def packed_bench(bench: Path, folder: Folder) -> Path:
    """The zip file, in the folder for passing things: all but links and hidden files, and the cards of what is calibrated."""
    place = folder.root / INCOMING
    place.mkdir(exist_ok=True)
    for old in sorted(place.glob("zip-*"), key=lambda p: p.stat().st_mtime)[:-MOST_AT_ONCE]:
        old.unlink(missing_ok=True)
    out = place / f"zip-{secrets.token_hex(8)}"
    with zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED, compresslevel=1) as pack:
        for path in sorted(bench.rglob("*")):
            inside = path.relative_to(bench)
            hidden = any(part.startswith(".") for part in inside.parts) and inside.parts[-1] != RESULTS_MARK
            if path.is_file() and not path.is_symlink() and not hidden:
                pack.write(path, Path(bench.name) / inside)
        for engine in ENGINES if (bench / RESULTS / CALIBRATED / "result.json").is_file() else ():
            with suppress(Refused):  # a result that lacks a parameter has no cards
                for name, text in card_files(bench / RESULTS, engine).items():
                    pack.writestr(f"{bench.name}/{RESULTS}/{CALIBRATED}/export/{engine}/{name}", text)
    return out
