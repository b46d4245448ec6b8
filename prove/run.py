"""The proof from end to end: make cases, publish hashes of their keys, solve each in a
process of its own (`benchtwin diagnose BENCH --out DIR`), compare. A stopped proof goes
on where it was.

The keys stay in memory until all solutions are in. A proof that was stopped makes them
again from its seed, and they must match the published hashes."""

import hashlib
import json
import math
import os
import shlex
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterable
from concurrent.futures import (
    Future,
    ProcessPoolExecutor,
    ThreadPoolExecutor,
    as_completed,
)
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np

from benchtwin.prove.cases.bench import drop_frames
from benchtwin.prove.files import read_json, write_json
from benchtwin.prove.judge import Judged, judge
from benchtwin.prove.make import Key, make_folder
from benchtwin.prove.plan import Spec, plan

# verdicts alone: no new DEM runs
SOLVER = "{python} -m benchtwin diagnose {bench} --out {out} --no-twin --quiet"
# stage, done, of, seconds left (NaN: not known)
Progress = Callable[[str, int, int, float], None]


@dataclass(frozen=True)
class Settings:
    """out: the proof's folder. seed: of the random numbers. limit_s: how long one case
    may take."""

    out: Path
    cases: int
    seed: int
    workers: int = 1
    solver: str = SOLVER
    limit_s: float = 600.0
    keep_frames: bool = False

    def bench(self, spec: Spec) -> Path:
        """A case's bench folder."""
        return self.out / "cases" / spec.name


def prove(settings: Settings, progress: Progress) -> list[Judged]:
    """Every case judged. Raises KeyMismatch when the folder was made by another proof;
    OSError when it cannot be written."""
    specs = plan(settings.cases, np.random.default_rng(settings.seed))
    settings.out.mkdir(parents=True, exist_ok=True)
    if not (settings.out / "keys.json").is_file():
        keys, salts = _make_all(settings, specs, progress)
        _solve_all(settings, specs, progress)
        solutions = settings.out / "solutions"
        hashes: dict[str, str | None] = {spec.name: None for spec in specs}
        for file in solutions.glob("*/diagnosis.json"):
            hashes[file.parent.name] = hashlib.sha256(file.read_bytes()).hexdigest()
        write_json(settings.out / "submitted.json", hashes)  # before any key is opened
        content = {"keys": keys, "salts": salts, "seed": settings.seed}
        write_json(settings.out / "keys.json", content)
    return judged(settings.out)


def judged(out: Path) -> list[Judged]:
    """The cases of a proof whose keys are open, each beside its solution."""
    opened = read_json(out / "keys.json")
    verify(opened["keys"], opened["salts"], read_json(out / "hashes.json"))
    found = []
    for case, key in opened["keys"].items():
        solution = out / "solutions" / case
        attempt = read_attempt(solution)
        seconds = attempt.seconds if attempt else math.nan
        found.append(judge(Key.from_dict(key), read_diagnosis(solution), seconds))
    return found


def seed_of(out: Path) -> int:
    """The seed of a proof whose keys are open."""
    return read_json(out / "keys.json")["seed"]


def _make_all(
    settings: Settings, specs: list[Spec], progress: Progress
) -> tuple[dict, dict]:
    """Write bench folders and the hashes of their keys; returns keys and salts by
    case."""
    cases = settings.out / "cases"
    cases.mkdir(exist_ok=True)
    with ProcessPoolExecutor(settings.workers) as pool:
        jobs = {
            pool.submit(
                make_folder, spec, settings.seed, settings.bench(spec)
            ): spec.name
            for spec in specs
        }
        keys = dict(_followed("making", jobs, progress))
    keys = json.loads(canonical(keys))  # as they will be read again
    salts = {case: salt_of(settings.seed, case) for case in keys}
    published = {case: hashed(keys[case], salts[case]) for case in sorted(keys)}
    file = settings.out / "hashes.json"
    if file.is_file() and read_json(file) != published:
        raise KeyMismatch(
            f"{file}: the hashes are those of another proof (other cases, seed or"
            " version); use another --out"
        )
    write_json(file, published)
    return keys, salts


def _solve_all(settings: Settings, specs: list[Spec], progress: Progress) -> None:
    """One attempt at each case that has none yet."""
    left = [
        s for s in specs if read_attempt(settings.out / "solutions" / s.name) is None
    ]

    def attempt(spec: Spec):
        bench = settings.bench(spec)
        # of an attempt that is gone
        if spec.rendered and not any(bench.glob("*/frames")):
            shutil.rmtree(bench, ignore_errors=True)
            make_folder(spec, settings.seed, bench)
        done = solve(
            spec.name,
            bench,
            settings.out / "solutions" / spec.name,
            settings.solver,
            settings.limit_s,
        )
        if not settings.keep_frames:
            drop_frames(bench)
        return done

    with ThreadPoolExecutor(max(settings.workers, 1)) as pool:
        jobs = {pool.submit(attempt, spec): spec.name for spec in left}
        try:
            for _ in _followed("solving", jobs, progress):
                pass
        except BaseException:
            pool.shutdown(wait=True, cancel_futures=True)
            raise


def _followed(
    stage: str, jobs: dict[Future, str], progress: Progress
) -> Iterable[tuple[str, object]]:
    """(name, result) of jobs as they end."""
    begin = time.monotonic()
    for done, job in enumerate(as_completed(jobs), 1):
        yield jobs[job], job.result()
        progress(
            stage,
            done,
            len(jobs),
            (time.monotonic() - begin) / done * (len(jobs) - done),
        )


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


class KeyMismatch(Exception):
    """The keys are not those whose hashes were published."""


def canonical(content: dict) -> bytes:
    """One spelling of a dict, so that equal content has equal hashes."""
    return json.dumps(
        content, sort_keys=True, separators=(",", ":"), ensure_ascii=False
    ).encode()


def salt_of(seed: int, case: str) -> str:
    """The case's salt, 32 hex digits: drawn from the proof's seed, so that the same
    proof publishes the same hashes."""
    return hashlib.sha256(f"salt of {case}, {seed}".encode()).hexdigest()[:32]


def hashed(key: dict, salt: str) -> str:
    """SHA-256 of salt and key, in hex."""
    return hashlib.sha256(bytes.fromhex(salt) + canonical(key)).hexdigest()


def verify(
    keys: dict[str, dict], salts: dict[str, str], published: dict[str, str]
) -> None:
    """Raises KeyMismatch unless every key matches its published hash."""
    if set(keys) != set(published):
        raise KeyMismatch(
            f"{len(published)} hashes were published, for other cases than the"
            f" {len(keys)} keys"
        )
    wrong = [
        case for case in keys if hashed(keys[case], salts[case]) != published[case]
    ]
    if wrong:
        raise KeyMismatch(
            f"{len(wrong)} keys are not those whose hashes were published, {wrong[0]}"
            " first"
        )
