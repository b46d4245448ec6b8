"""Runs the solver on one case: `benchtwin diagnose BENCH --out DIR` in a process of its
own."""

import os
import shlex
import subprocess
import sys
import tempfile
import time
from dataclasses import asdict, dataclass
from pathlib import Path

from benchtwin.prove.files import read_json, write_json

# verdicts alone: no new DEM runs
SOLVER = "{python} -m benchtwin diagnose {bench} --out {out} --no-twin --quiet"
PASSED_ON = (
    "PATH",
    "LANG",
    "LC_ALL",
    "LD_LIBRARY_PATH",
    "VIRTUAL_ENV",
    "PYTHONPATH",
    "SYSTEMROOT",
    "NUMBA_CACHE_DIR",
)


@dataclass(frozen=True)
class Attempt:
    """The one attempt at a case. trouble: why there is no diagnosis, "" when there is
    one."""

    case: str
    seconds: float
    exit_code: int | None
    trouble: str


def solve(case: str, bench: Path, out: Path, solver: str, limit_s: float) -> Attempt:
    """Run the solver with nothing but the two paths, in an empty folder, on one
    core."""
    out.mkdir(parents=True, exist_ok=True)
    command = [
        w.format(python=sys.executable, bench=bench.resolve(), out=out.resolve())
        for w in shlex.split(solver)
    ]
    begin = time.monotonic()
    code, trouble = None, ""
    threads = (
        "OMP_NUM_THREADS",
        "OPENBLAS_NUM_THREADS",
        "MKL_NUM_THREADS",
        "NUMBA_NUM_THREADS",
    )
    with tempfile.TemporaryDirectory() as empty:
        kept = {name: os.environ[name] for name in PASSED_ON if name in os.environ}
        bare = kept | dict.fromkeys(threads, "1") | {"HOME": empty, "TMPDIR": empty}
        try:
            done = subprocess.run(
                command,
                cwd=empty,
                env=bare,
                capture_output=True,
                timeout=limit_s,
                check=False,
            )
            code = done.returncode
            printed = done.stdout[-20_000:] + done.stderr[-20_000:]
        except subprocess.TimeoutExpired as late:
            printed = (late.stdout or b"") + (late.stderr or b"")
            trouble = f"stopped after {limit_s:g} s"
        except OSError as error:
            printed, trouble = b"", f"cannot be run: {error}"
    seconds = time.monotonic() - begin
    (out / "printed.txt").write_bytes(printed)
    if not trouble and read_diagnosis(out) is None:
        trouble = f"no diagnosis.json that can be read; exit code {code}"
    attempt = Attempt(case, round(seconds, 3), code, trouble)
    write_json(out / "attempt.json", asdict(attempt))
    return attempt


def read_attempt(out: Path) -> Attempt | None:
    """The case's attempt, if it was made."""
    file = out / "attempt.json"
    return Attempt(**read_json(file)) if file.is_file() else None


def read_diagnosis(out: Path) -> dict | None:
    """diagnosis.json; None where there is none that can be read."""
    try:
        content = read_json(out / "diagnosis.json")
    except (OSError, ValueError):
        return None
    if isinstance(content, dict) and isinstance(content.get("rigs"), dict):
        return content
    return None
