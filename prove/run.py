"""The proof from end to end: make, publish hashes, solve, submit, open, score. Run again, it goes on where it was stopped."""

import hashlib
import json
import shutil
import time
from collections.abc import Callable, Iterable
from concurrent.futures import Future, ProcessPoolExecutor, ThreadPoolExecutor, as_completed
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from prove.cases.folder import drop_frames
from prove.judge import Judged, judge
from prove.keys import Seal, SealError, canonical, hashed, salt_of, verify
from prove.make import Key, make_folder
from prove.plan import Spec, plan
from prove.solve import SOLVER, read_attempt, read_diagnosis, solve

Say = Callable[[str, int, int, float], None]  # stage, done, of, seconds left (NaN: not known)


@dataclass(frozen=True)
class Asked:
    """out: the proof's folder. seed: of the random numbers. limit_s: how long one case may take."""

    out: Path
    cases: int
    seed: int
    workers: int = 1
    solver: str = SOLVER
    limit_s: float = 600.0
    keep_frames: bool = False


def prove(asked: Asked, say: Say) -> list[Judged]:
    """Every case judged. SealError when what is in asked.out was made by another proof; OSError when it cannot be written."""
    specs = plan(asked.cases, np.random.default_rng(asked.seed))
    asked.out.mkdir(parents=True, exist_ok=True)
    if not (asked.out / "keys.json").is_file():
        seal = _make_all(asked, specs, say)
        _solve_all(asked, specs, say)
        _submit(asked.out, specs)
        keys, salts = seal.open((asked.out / "keys.sealed").read_bytes())
        verify(keys, salts, _read(asked.out / "hashes.json"))
        _write(asked.out / "keys.json", {"keys": keys, "salts": salts, "seed": asked.seed})
    return judged(asked.out)


def judged(out: Path) -> list[Judged]:
    """The cases of a proof whose keys are open, each beside its solution."""
    opened = _read(out / "keys.json")
    verify(opened["keys"], opened["salts"], _read(out / "hashes.json"))
    folders = {case: out / "solutions" / case for case in opened["keys"]}
    return [
        judge(Key.from_dict(key), read_diagnosis(folders[case]), read_attempt(folders[case]))
        for case, key in opened["keys"].items()
    ]


def seed_of(out: Path) -> int:
    """The seed of a proof whose keys are open."""
    return _read(out / "keys.json")["seed"]


def _make_all(asked: Asked, specs: list[Spec], say: Say) -> Seal:
    """Bench folders, published hashes, sealed keys. The keys leave this function only sealed."""
    cases = asked.out / "cases"
    cases.mkdir(exist_ok=True)
    with ProcessPoolExecutor(asked.workers) as pool:
        jobs = {pool.submit(make_folder, spec, asked.seed, _bench(asked, spec)): spec.name for spec in specs}
        keys = dict(_followed("making", jobs, say))
    keys = json.loads(canonical(keys))  # as they will be read again
    salts = {case: salt_of(asked.seed, case) for case in keys}
    published = {case: hashed(keys[case], salts[case]) for case in sorted(keys)}
    file = asked.out / "hashes.json"
    if file.is_file() and _read(file) != published:
        raise SealError(f"{file}: the hashes are those of another proof (other cases, seed or version); use another --out")
    _write(file, published)
    seal = Seal()
    (asked.out / "keys.sealed").write_bytes(seal.close(keys, salts))
    return seal


def _bench(asked: Asked, spec: Spec) -> Path:
    """A case's folder. One that is solved already need not be written again."""
    return asked.out / "cases" / spec.name


def _solve_all(asked: Asked, specs: list[Spec], say: Say) -> None:
    """One attempt at each case that has none yet."""
    left = [s for s in specs if read_attempt(asked.out / "solutions" / s.name) is None]

    def attempt(spec: Spec):
        bench = _bench(asked, spec)
        if spec.rendered and not any(bench.glob("*/frames")):  # of an attempt that is gone
            shutil.rmtree(bench, ignore_errors=True)
            make_folder(spec, asked.seed, bench)
        done = solve(spec.name, bench, asked.out / "solutions" / spec.name, asked.solver, asked.limit_s)
        if not asked.keep_frames:
            drop_frames(bench)
        return done

    with ThreadPoolExecutor(max(asked.workers, 1)) as pool:
        jobs = {pool.submit(attempt, spec): spec.name for spec in left}
        try:
            for _ in _followed("solving", jobs, say):
                pass
        except BaseException:
            pool.shutdown(wait=True, cancel_futures=True)
            raise


def _submit(out: Path, specs: list[Spec]) -> None:
    """Hashes of all solutions, written before any key is opened."""
    files = {s.name: out / "solutions" / s.name / "diagnosis.json" for s in specs}
    _write(
        out / "submitted.json", {n: hashlib.sha256(f.read_bytes()).hexdigest() if f.is_file() else None for n, f in files.items()}
    )


def _followed(stage: str, jobs: dict[Future, str], say: Say) -> Iterable[tuple[str, object]]:
    """(name, result) of jobs as they end."""
    begin = time.monotonic()
    for done, job in enumerate(as_completed(jobs), 1):
        yield jobs[job], job.result()
        say(stage, done, len(jobs), (time.monotonic() - begin) / done * (len(jobs) - done))


def _read(file: Path) -> dict:
    return json.loads(file.read_text(encoding="utf8"))


def _write(file: Path, content: dict) -> None:
    part = file.with_name(f".{file.name}.part")
    part.write_text(json.dumps(content, indent=1, sort_keys=True, allow_nan=False), encoding="utf8")
    part.replace(file)
