"""The solver and the baseline methods scored on the same cases: drops with tracks."""

import time
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

import numpy as np

from benchtwin.prove.baselines.methods import METHODS, diagnose
from benchtwin.prove.files import read_json, write_json
from benchtwin.prove.judge import Judged, judge
from benchtwin.prove.score import Row, table
from benchtwin.prove.solve import Attempt

SOLVER_NAME = "benchtwin diagnose"


def comparable(j: Judged) -> bool:
    """Whether the other methods can be asked too: a drop, given as a track."""
    return j.key.rig == "drop" and not j.key.rendered


def compare(
    out: Path, judged: list[Judged], workers: int, rng_seed: int
) -> dict[str, list[Row]]:
    """The table of each method over the drops with tracks, the solver's first."""
    some = [j for j in judged if comparable(j)]
    tables = {SOLVER_NAME: _over(some, rng_seed)}
    tasks = [(method, out, j.key.case) for method in METHODS for j in some]
    with ProcessPoolExecutor(workers) as pool:
        answers = list(pool.map(_answer, tasks, chunksize=8))
    found = {
        (method, case): answer for (method, _, case), answer in zip(tasks, answers)
    }
    for method in METHODS:
        judged_here = []
        for j in some:
            answer, seconds = found[method, j.key.case]
            judged_here.append(
                judge(j.key, answer, Attempt(j.key.case, seconds, 0, ""))
            )
        tables[method] = _over(judged_here, rng_seed)
    return tables


def _over(judged: list[Judged], rng_seed: int) -> list[Row]:
    rows = table(judged, np.random.default_rng(rng_seed))
    return [row for row in rows if row.rig == "all"]


def _answer(task: tuple[str, Path, str]) -> tuple[dict | None, float]:
    """A method's diagnosis of a case and its seconds; kept, so that no case is
    diagnosed twice."""
    method, out, case = task
    file = out / "baselines" / method.replace(" ", "-") / f"{case}.json"
    if file.is_file():
        stored = read_json(file)
        return stored["diagnosis"], stored["seconds"]
    begin = time.monotonic()
    try:
        answer = diagnose(out / "cases" / case, method)
    except (
        ValueError,
        np.linalg.LinAlgError,
    ):  # a baseline that breaks down has no answer
        answer = None
    seconds = time.monotonic() - begin
    file.parent.mkdir(parents=True, exist_ok=True)
    write_json(file, {"diagnosis": answer, "seconds": seconds})
    return answer, seconds
