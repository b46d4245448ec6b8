"""What tells of the machine that made a result: its folders, a photo's place."""

import json
import re
import tempfile
from collections.abc import Mapping
from pathlib import Path

from PIL import Image

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
