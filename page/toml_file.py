"""Changes recording.toml and bench.toml key by key: comments are kept, files written
whole, and nothing is overwritten that somebody else changed meanwhile."""

import hashlib
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import tomlkit
from tomlkit.exceptions import TOMLKitError
from tomlkit.items import Table

from benchtwin.bench.whole_file import write_whole
from benchtwin.page.folder import Refused
from benchtwin.vision.evidence.read_keys import MOST_BYTES, validate
from benchtwin.vision.measurement import MeasurementError

OVERTAKEN = (
    "was changed meanwhile, elsewhere. Reload the page; what you changed here is not"
    " saved"
)
BY_HAND = "set by hand on the page"
# (section, key) → value; None takes the key away; section "": above all sections
Changes = dict[tuple[str, str], Any]


@dataclass(frozen=True)
class Keys:
    """A file's keys, and the version of it that they were read from ("" for a file that
    is not there)."""

    path: Path
    version: str
    content: dict


def read(path: Path) -> Keys:
    """The file as it is now; Refused where it is not valid TOML."""
    text = text_of(path)
    return Keys(path, _version(text), parsed(text, path).unwrap())


def text_of(path: Path) -> str:
    """The file's text, "" where there is none; Refused where it is no file of keys."""
    if not path.is_file():
        return ""
    if path.stat().st_size > MOST_BYTES:
        raise Refused(f"{path.name}: too large for a file of keys")
    try:
        return path.read_text(encoding="utf-8-sig")
    except UnicodeDecodeError as error:
        raise Refused(f"{path.name}: not UTF-8 text (byte {error.start})") from error


def any_text(path: Path) -> str:
    """What can be shown of a file, whatever it holds."""
    return path.read_bytes()[:MOST_BYTES].decode("utf8", "replace")


def write_text(path: Path, text: str, seen: str) -> None:
    """Replace the whole file; Refused where the text is not TOML, or where the file is
    another by now than was `seen`."""
    parsed(text, path)
    if any_text(path) != seen:
        raise Refused(f"{path.name} {OVERTAKEN}")
    write_whole(path, text)


def change(keys: Keys, changes: Changes, *, by_hand: bool = False) -> Keys:
    """Write the changes into the file; Refused where it has changed since `keys` was
    read, or where something in it would be wrong that was not."""
    text = text_of(keys.path)
    if _version(text) != keys.version:
        raise Refused(f"{keys.path.name} {OVERTAKEN}")
    document = parsed(text, keys.path)
    wrong = _wrong(document, keys.path)
    for (section, key), value in changes.items():
        _set(document, section, key, value, by_hand)
    if now := [line for line in _wrong(document, keys.path) if line not in wrong]:
        raise Refused("\n".join(now))
    written = tomlkit.dumps(document)
    write_whole(keys.path, written)
    return Keys(keys.path, _version(written), document.unwrap())


def _wrong(document: tomlkit.TOMLDocument, path: Path) -> list[str]:
    """What is wrong with the keys, a line each."""
    try:
        validate(document.unwrap(), Path(path.name))
    except MeasurementError as error:
        return str(error).splitlines()
    return []


def _set(
    document: tomlkit.TOMLDocument, section: str, key: str, value: Any, by_hand: bool
) -> None:
    if section and not isinstance(document.get(section), dict):  # absent, or no table
        if value is None:
            return
        document.pop(section, None)
        document[section] = tomlkit.table()
    place = document[section] if section else document
    if value is None:
        if key in place:
            del place[key]
        if isinstance(place, Table) and not place:
            del document[section]
        return
    item = tomlkit.item(value)
    if by_hand:
        item.comment(BY_HAND)
    elif (
        key in place
        and (comment := place[key].trivia.comment)
        and BY_HAND not in comment
    ):
        item.trivia.comment = comment
        item.trivia.comment_ws = place[key].trivia.comment_ws
    place[key] = item


def parsed(text: str, path: Path) -> tomlkit.TOMLDocument:
    """The text as keys with their comments; Refused where it is not valid TOML."""
    try:
        return tomlkit.parse(text)
    except RecursionError as error:
        raise Refused(f"{path.name}: brackets within brackets, too deep") from error
    except (TOMLKitError, ValueError) as error:
        raise Refused(f"{path.name}: not valid TOML: {error}") from error


def _version(text: str) -> str:
    return hashlib.sha256(text.encode()).hexdigest() if text else ""
