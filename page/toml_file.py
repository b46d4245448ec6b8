"""Changes recording.toml and bench.toml key by key: comments are kept, files written
whole, nothing is overwritten that somebody else changed meanwhile, and what the page
wrote can be undone and done again."""

import hashlib
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import tomlkit
from tomlkit.exceptions import TOMLKitError
from tomlkit.items import Table

from benchtwin.bench.language import tr
from benchtwin.bench.whole_file import write_whole
from benchtwin.page.folder import Refused
from benchtwin.vision.evidence.read_keys import MOST_BYTES, validate
from benchtwin.vision.measurement import MeasurementError

OVERTAKEN = (
    "{} was changed meanwhile, elsewhere. Reload the page; what you changed here is not"
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
        raise Refused(tr("{}: too large for a file of keys", path.name))
    try:
        return path.read_text(encoding="utf-8-sig")
    except UnicodeDecodeError as error:
        raise Refused(
            tr("{}: not UTF-8 text (byte {})", path.name, error.start)
        ) from error


def any_text(path: Path) -> str:
    """What can be shown of a file, whatever it holds."""
    return path.read_bytes()[:MOST_BYTES].decode("utf8", "replace")


def write_text(path: Path, text: str, seen: str) -> None:
    """Replace the whole file; Refused where the text is not TOML, or where the file is
    another by now than was `seen`."""
    parsed(text, path)
    if any_text(path) != seen:
        raise Refused(tr(OVERTAKEN, path.name))
    write_whole(path, text)


def change(keys: Keys, changes: Changes, *, by_hand: bool = False) -> Keys:
    """Write the changes into the file; Refused where it has changed since `keys` was
    read, or where something in it would be wrong that was not."""
    text = text_of(keys.path)
    if _version(text) != keys.version:
        raise Refused(tr(OVERTAKEN, keys.path.name))
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
        raise Refused(
            tr("{}: brackets within brackets, too deep", path.name)
        ) from error
    except (TOMLKitError, ValueError) as error:
        raise Refused(tr("{}: not valid TOML: {}", path.name, error)) from error


def _version(text: str) -> str:
    return hashlib.sha256(text.encode()).hexdigest() if text else ""


MOST_KEPT = 300  # changes; the oldest are forgotten

Texts = dict[Path, bytes | None]  # a file's whole content; None: it is not there


@dataclass(frozen=True)
class Change:
    """What one act at the page did to some files."""

    before: Texts
    after: Texts


@dataclass
class History:
    """All changes since the page was started, the last one at the end. A file that
    something else changed meanwhile is never overwritten."""

    done: list[Change] = field(default_factory=list)
    undone: list[Change] = field(default_factory=list)

    @contextmanager
    def kept(self, *files: Path) -> Iterator[None]:
        """Remember what happens to the files inside as one change, also where it breaks
        off half-way."""
        before = _texts(files)
        try:
            yield
        finally:
            after = _texts(files)
            changed = [file for file in files if before[file] != after[file]]
            if changed:
                self.undone = [
                    c for c in self.undone if not c.after.keys() & {*changed}
                ]
                change = Change(
                    {f: before[f] for f in changed}, {f: after[f] for f in changed}
                )
                self.done = [*self.done, change][-MOST_KEPT:]

    def undo(self, file: Path) -> list[Path]:
        """Take back the last change that touched `file`; returns all files that it had
        changed, none where there is nothing to take back."""
        return _turn(self.done, self.undone, file, back=True)

    def redo(self, file: Path) -> list[Path]:
        """Do again what `undo` took back last of `file`; returns the files."""
        return _turn(self.undone, self.done, file, back=False)

    def can_undo(self, file: Path) -> bool:
        return any(file in change.after for change in self.done)

    def can_redo(self, file: Path) -> bool:
        return any(file in change.after for change in self.undone)


def _turn(
    source: list[Change], target: list[Change], file: Path, *, back: bool
) -> list[Path]:
    """Move the last change of `file` from one list to the other and write its texts."""
    change = next((c for c in reversed(source) if file in c.after), None)
    if change is None:
        return []
    now, to = (change.after, change.before) if back else (change.before, change.after)
    present = _texts(tuple(now))
    if others := [f for f in now if present[f] != now[f]]:
        names = ", ".join(f"{f.parent.name}/{f.name}" for f in others)
        raise Refused(tr("{} was changed since; nothing was undone or redone", names))
    for path, text in to.items():
        if text is None:
            path.unlink(missing_ok=True)
        else:
            write_whole(path, text)
    source.remove(change)
    target.append(change)
    return [*to]


def _texts(files: tuple[Path, ...]) -> Texts:
    return {file: file.read_bytes() if file.is_file() else None for file in files}
