"""The page served from a folder, in a process of its own; what it keeps for itself lies
in a folder of the tests."""

import os
import re
import subprocess
import sys
import time
import urllib.error
import urllib.request
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest


@pytest.fixture(scope="session", autouse=True)
def private_folder(tmp_path_factory) -> Iterator[Path]:
    """Where runs are signed and locked, instead of the user's own folder."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("XDG_STATE_HOME", str(tmp_path_factory.mktemp("state")))
        yield Path(os.environ["XDG_STATE_HOME"]) / "benchtwin"


PRINTED = r"http://\w+\.localhost(:\d+/\?token=\S+)"


@contextmanager
def served(
    folder: Path,
    *options: str,
    named: bool = False,
    program: tuple[str, ...] = ("-m", "benchtwin"),
) -> Iterator[str]:
    """The address of the page on `folder`, once it answers. It lets one browser in.
    named: by the server's own name, as it is printed; program: what Python runs."""
    server = subprocess.Popen(
        [sys.executable, *program, "page", str(folder), "--no-browser", *options],
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
    )
    try:
        assert server.stdout is not None
        said = ""
        while not (address := re.search(PRINTED, said)):
            line = server.stdout.readline()
            assert line, said
            said += line
        numbered = f"http://127.0.0.1{address[1]}"  # not every system knows such names
        for _ in range(200):
            try:
                urllib.request.urlopen(numbered.split("?")[0], timeout=5)
            except urllib.error.HTTPError:  # it answers, and refuses: it has no key
                break
            except OSError:
                time.sleep(0.1)
        yield address[0] if named else numbered
    finally:
        server.terminate()
        server.wait(60)


@pytest.fixture(scope="module")
def serve():
    """`served`, for tests to call."""
    return served
