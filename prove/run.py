"""The proof from end to end: make cases, publish hashes of their keys, solve, compare.
A stopped proof goes on where it was."""

import hashlib
import json
import math
import shutil
import time
from collections.abc import Callable, Iterable
from concurrent.futures import (
    Future,
    ProcessPoolExecutor,
    ThreadPoolExecutor,
    as_completed,
)
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from benchtwin.prove.cases.bench import drop_frames
from benchtwin.prove.files import read_json, write_json
from benchtwin.prove.judge import Judged, judge
from benchtwin.prove.keys import KeyMismatch, canonical, hashed, salt_of, verify
from benchtwin.prove.make import Key, make_folder
from benchtwin.prove.plan import Spec, plan
from benchtwin.prove.solve import SOLVER, read_attempt, read_diagnosis, solve

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
