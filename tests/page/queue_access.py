"""A run as its folder stands, and the queue gone on with, as a page does both among
other things."""

from pathlib import Path

from benchtwin.page import runs
from benchtwin.page.folder import Folder


def read_run(place: Path) -> runs.Run:
    with runs._queue(bench := place.parents[2]):
        return runs._read(place, runs._current(bench))


def advance(bench: Path, folder: Folder) -> None:
    with runs._queue(bench):
        runs._advance(bench, folder)
