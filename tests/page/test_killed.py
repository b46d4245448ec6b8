"""A page killed at any moment loses nothing that was saved and leaves no half file."""

import multiprocessing
import time
import tomllib
from pathlib import Path

from benchtwin.page import toml_file
from benchtwin.page.folder import INCOMING
from benchtwin.page.upload import ReceivedFile, place_files

KILLS = 50
LARGE = b"x" * 200_000


def save_forever(root: Path, start: int, told) -> None:
    """Change bench.toml and bring a recording, again and again, telling each number
    that is saved."""
    incoming = root / INCOMING
    incoming.mkdir(exist_ok=True)
    for n in range(start, 10**9):
        keys = toml_file.read(root / "bench.toml")
        toml_file.change(
            keys, {("", "session"): str(n) * 2000, ("conditions", "count"): n}
        )
        told.send(n)
        arrived = [ReceivedFile("run/recording.toml", incoming / "0")]
        (incoming / "0").write_text('rig = "pile"\n')
        for name in ("a.jpg", "b.jpg"):
            (incoming / name).write_bytes(LARGE)
            arrived.append(ReceivedFile(f"run/{name}", incoming / name))
        place_files(arrived, root)


def test_nothing_saved_is_lost_and_nothing_is_half(tmp_path):
    file, last = tmp_path / "bench.toml", 0
    fork = multiprocessing.get_context("fork")
    for kill in range(KILLS):
        ours, theirs = fork.Pipe(duplex=False)
        process = fork.Process(target=save_forever, args=(tmp_path, last + 1, theirs))
        process.start()
        theirs.close()
        saved = ours.recv()
        time.sleep(0.0007 * kill)
        process.kill()
        process.join()
        try:
            while True:
                saved = ours.recv()
        except EOFError:
            pass
        keys = tomllib.loads(file.read_text())
        last = int(keys["conditions"]["count"])
        assert last >= saved and keys["session"] == str(last) * 2000
        for made in tmp_path.glob("run*"):
            assert sorted(p.name for p in made.iterdir()) == [
                "a.jpg",
                "b.jpg",
                "recording.toml",
            ]
            assert all(p.stat().st_size == len(LARGE) for p in made.glob("*.jpg"))
    assert (
        len(list(tmp_path.glob("run*"))) > KILLS / 5
    )  # it did not stop before the work began
