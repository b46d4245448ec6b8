"""The solver and the baseline methods scored on the same cases: drops with tracks."""

import time
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from pathlib import Path

import numpy as np

from benchtwin.prove.baselines.methods import METHODS, diagnose
from benchtwin.prove.files import read_json, write_json
from benchtwin.prove.judge import Judged, judge
from benchtwin.prove.score import Row, table

SOLVER_NAME = "benchtwin diagnose"


def compare(
    out: Path, judged: list[Judged], workers: int, rng_seed: int
) -> dict[str, list[Row]]:
    """The table of each method over the drops with tracks, the solver's first: the
    others can be asked of these only."""
    some = [j for j in judged if j.key.rig == "drop" and not j.key.rendered]
    tables = {SOLVER_NAME: _over(some, rng_seed)}
    with ProcessPoolExecutor(workers) as pool:
        for method in METHODS:
            cases = [j.key.case for j in some]
            answers = pool.map(partial(_answer, method, out), cases, chunksize=8)
            theirs = [judge(j.key, *answer) for j, answer in zip(some, answers)]
            tables[method] = _over(theirs, rng_seed)
    return tables


def _over(judged: list[Judged], rng_seed: int) -> list[Row]:
    rows = table(judged, np.random.default_rng(rng_seed))
    return [row for row in rows if row.rig == "all"]


def _answer(method: str, out: Path, case: str) -> tuple[dict | None, float]:
    """A method's diagnosis of a case and its seconds; kept, so that no case is
    diagnosed twice."""
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
