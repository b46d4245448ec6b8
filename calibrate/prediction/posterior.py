"""A calibration's folder, read back: draws from its posterior, the seeds it was made
with, its convention."""

import json
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd

from benchtwin.calibrate.procedure.calibration import CALIBRATED
from benchtwin.calibrate.procedure.rigs import (
    ASSUMED,
    PARAMETERS,
    PILE,
    SEED_FACTORS,
)
from benchtwin.twin.bench_folder import read_numbers

LIMITS = (0.0, 5.0)  # of a contact parameter: beyond them it is another column


@dataclass(frozen=True, eq=False)
class Kept:
    """draws: (n, 6) of all PARAMETERS, natural units; most_probable: the set of them
    with the highest joint density; described: the lot's [seed] and [air]; rolling: the
    rolling friction's convention; notes: sentences on what a prediction from it
    assumes."""

    draws: pd.DataFrame
    most_probable: dict[str, float]
    described: dict
    rolling: str
    notes: tuple[str, ...]

    def some(self, n: int, seed: int) -> pd.DataFrame:
        """n draws, different ones; more of them begin with the same. ValueError where
        there are not so many."""
        if n > len(self.draws):
            raise ValueError(f"--draws {n}: the calibration keeps {len(self.draws)}")
        order = np.random.default_rng(seed).permutation(len(self.draws))
        return self.draws.iloc[order[:n]].reset_index(drop=True)


def read_posterior(folder: Path) -> Kept:
    """What `benchtwin calibrate … --out folder` left. FileNotFoundError without one;
    ValueError names what is missing in it."""
    file = folder / "result.json"
    if not file.is_file():
        raise FileNotFoundError(
            f"{file}: not there; CALIBRATED is what `benchtwin calibrate … --out DIR`"
            " wrote"
        )
    try:
        content = json.loads(file.read_text(encoding="utf8"))
        rolling, mode = content["conventions"]["rolling"], content["mode"]
        bench, refused = (content[k] for k in ("bench", "not_calibrated"))
        stated = {n: dict(row) for n, row in content["parameters"].items()}
        at = {n: float(row["most_probable_set"]) for n, row in stated.items()}
        options = dict(content["options"])
    except (ValueError, KeyError, TypeError, AttributeError) as error:
        raise ValueError(f"{file}: not a calibration's result: {error!r}") from error
    if not set(SEED_FACTORS) <= set(at):
        why = refused.get(PILE.name, "no pile was recorded")
        raise ValueError(
            f"{file}: no rig of many seeds was calibrated ({why}), so nothing is known"
            " of seed on seed, and nothing can be predicted"
        )
    if "described" not in bench:
        raise ValueError(
            f"{file}: bench.described, the lot's seeds, is missing; calibrate again"
            " with --overwrite: finished runs are kept"
        )
    draws, assumed = _draws(folder / "tables" / "posterior.csv")
    notes = [
        f"{n} was not calibrated: {v:g} is assumed, as in the calibration"
        for n, v in assumed.items()
    ]
    notes += [
        f"{n} is {row['status']}; it is drawn over {row['low']:g} to {row['high']:g}"
        for n, row in stated.items()
        if row["status"] != CALIBRATED
    ]
    if mode != "simulated":
        notes.append(
            "calibrated on simulations of another program; predicted with benchtwin's"
        )
    if options.get("engine"):
        notes.append(
            f"calibrated with the engine {options['engine']}; predicted with"
            " benchtwin's own"
        )
    return Kept(draws, at | assumed, bench["described"], rolling, tuple(notes))


def _draws(file: Path) -> tuple[pd.DataFrame, dict[str, float]]:
    """The posterior's draws with a column for every parameter, and the values of those
    that were not calibrated."""
    if not file.is_file():
        raise FileNotFoundError(
            f"{file}: not there; it should hold draws from the posterior, a column a"
            " parameter"
        )
    needed, optional = (dict.fromkeys(n, LIMITS) for n in (SEED_FACTORS, ASSUMED))
    draws = read_numbers(file, needed, optional)
    assumed = {n: v for n, v in ASSUMED.items() if n not in draws}
    return draws.assign(**assumed)[list(PARAMETERS)], assumed
