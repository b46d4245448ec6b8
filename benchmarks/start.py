"""Processor time that people wait for: the help, an import, one photo, one film, one
drop simulated for the first time and again; beside another checkout's, as ratios.

    python benchmarks/start.py
    python benchmarks/start.py --beside ../yesterday/.venv/bin/python

Of each the least of three runs, the two in turns; the first simulation once. One BLAS
thread, as the command line takes.
"""

import argparse
import os
import resource
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
PHOTO = ROOT / "samples" / "soybean-bench" / "pile-01" / "photo.jpg"
FILM = ROOT / "samples" / "drawn-bench" / "roll-video"
RUNS = 3
COMMAND = "from benchtwin.command_line import main; main()"


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--beside", type=Path, help="Python of another checkout")
    beside = parser.parse_args().beside
    pythons = [Path(sys.executable), *([beside] if beside else [])]
    with tempfile.TemporaryDirectory() as folder:
        for what, seconds in rows(pythons, Path(folder)):
            ratio = f"{seconds[0] / seconds[1]:8.2f} of the other's" if beside else ""
            told = "  ".join(f"{s:7.2f} s" for s in seconds)
            print(f"{what:36} {told} {ratio}", flush=True)


def rows(pythons: list[Path], place: Path) -> Iterator[tuple[str, list[float]]]:
    """What is timed, and its processor time [s] for each Python."""
    bench = place / "bench"
    bench.mkdir()
    (bench / PHOTO.name).write_bytes(PHOTO.read_bytes())
    timed = {
        "benchtwin --help": ["-c", COMMAND, "--help"],
        "import benchtwin; benchtwin.measure": [
            "-c",
            "import benchtwin; benchtwin.measure",
        ],
        "one photo": ["-c", COMMAND, "measure", str(bench), "--out"],
        "one film": ["-c", COMMAND, "measure", str(FILM), "--out"],
    }
    for what, words in timed.items():
        yield what, [least(k, pythons, words, place) for k in range(len(pythons))]
    drop = ["-c", COMMAND, "simulate", "drop", "--track", "--quiet", "--out"]
    caches = [place / f"cache-{k}" for k in range(len(pythons))]
    for what in ("a drop, the first time", "a drop, again"):
        yield what, [once(p, drop, place, c) for p, c in zip(pythons, caches)]


def least(which: int, pythons: list[Path], words: list[str], place: Path) -> float:
    """Of RUNS runs, each after one of the others'."""
    seconds = []
    for _ in range(RUNS):
        for k, python in enumerate(pythons):
            took = once(python, words, place)
            if k == which:
                seconds.append(took)
    return min(seconds)


def once(
    python: Path, words: list[str], place: Path, cache: Path | None = None
) -> float:
    """Processor time [s] of one command with its processes; cache: where compiled code
    is kept, else where it always is."""
    out = [tempfile.mkdtemp(dir=place) + "/out"] if words[-1] == "--out" else []
    told = {"NUMBA_CACHE_DIR": str(cache)} if cache else {}
    environment = os.environ | {"OPENBLAS_NUM_THREADS": "1"} | told
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    done = subprocess.run(
        [python, *words, *out],
        cwd=place,
        env=environment,
        capture_output=True,
        text=True,
    )
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    if done.returncode:
        sys.exit(f"{python} {' '.join(words)}: {done.stderr}")
    spent = after.ru_utime - before.ru_utime, after.ru_stime - before.ru_stime
    return sum(spent)


if __name__ == "__main__":
    main()
