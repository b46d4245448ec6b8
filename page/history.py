"""Undo and redo of what the page wrote into recording.toml and bench.toml."""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path

from benchtwin.bench.whole_file import write_whole
from benchtwin.page.folder import Refused

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
        raise Refused(f"{names} was changed since; nothing was undone or redone")
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
