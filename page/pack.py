"""A whole bench with its results as one zip, to keep or to send."""

import secrets
import zipfile
from pathlib import Path

from page.folder import INCOMING, Folder

MOST_AT_ONCE = 4  # older packages are thrown away


def packed_bench(bench: Path, folder: Folder) -> Path:
    """The zip file, in the folder for passing things; links and hidden files are left out."""
    place = folder.root / INCOMING
    place.mkdir(exist_ok=True)
    for old in sorted(place.glob("zip-*"), key=lambda p: p.stat().st_mtime)[:-MOST_AT_ONCE]:
        old.unlink(missing_ok=True)
    out = place / f"zip-{secrets.token_hex(8)}"
    with zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED, compresslevel=1) as pack:
        for path in sorted(bench.rglob("*")):
            inside = path.relative_to(bench)
            if path.is_file() and not path.is_symlink() and not any(part.startswith(".") for part in inside.parts):
                pack.write(path, Path(bench.name) / inside)
    return out
