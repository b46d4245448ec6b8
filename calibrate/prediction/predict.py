"""A rig simulated at parameters drawn from a calibration's posterior: what it will
show, and how well that is known."""

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from benchtwin.bench.tells import by_surface
from benchtwin.calibrate.procedure.calibration import CALIBRATED
from benchtwin.calibrate.procedure.rigs import (
    ASSUMED,
    PARAMETERS,
    PILE,
    SEED_FACTORS,
)
from benchtwin.calibrate.procedure.simulator import Run, Simulator, seed_numbers, usable
from benchtwin.calibrate.statistics.predictive import Predictive, predictive
from benchtwin.twin.bench_folder import read_numbers
from benchtwin.twin.job import rig_named

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


# what is read of each system of many seeds: what can be evidence can be predicted
READ = {name: told.rig.readings for name, told in by_surface().items()}
QUANTITIES = {
    name: {column: of.replace("_", " ") for column, (of, _) in read.items()}
    for name, read in READ.items()
}
UNITS = {column: unit for read in READ.values() for column, (_, unit) in read.items()}
DECIMALS = {"s": 3}  # worth printing, where it is not one
DRAWN, SET = "posterior draw", "most probable set"
# share of the runs: with fewer, those that failed could decide the answer
LEAST_USABLE = 0.75


@dataclass(frozen=True, eq=False)
class Prediction:
    """rig; of: {quantity: Predictive}, each in its unit; runs: a row a run: kind (DRAWN
    or SET), parameters, quantities, seconds where known; notes."""

    rig: str
    of: dict[str, Predictive]
    runs: pd.DataFrame
    notes: tuple[str, ...]


def predict(
    rig: str,
    kept: Kept,
    description: dict,
    simulate: Simulator,
    *,
    draws: int,
    packings: int,
    seed: int,
    measured: bool = False,
) -> Prediction:
    """Run the rig once at each of `draws` posterior draws, and `packings` times at the
    most probable set, each with its own packing.

    measured: read off the pictures, not off the simulation itself.
    Raises ValueError where `predictive` does, SimulationFailed where too many runs gave
    nothing."""
    drawn = kept.some(draws, seed).assign(kind=DRAWN)
    middle = pd.DataFrame([kept.most_probable] * packings).assign(kind=SET)
    runs = pd.concat([drawn, middle], ignore_index=True)
    values = runs[list(PARAMETERS)].astype(float).to_dict("records")
    places = [*range(draws), *range(packings)]
    asked = [
        Run(rig_named(rig)[0], row, seed_numbers(seed, rig, kind, k), description)
        for row, kind, k in zip(values, runs["kind"], places, strict=True)
    ]
    table, notes, of = simulate(asked).reset_index(drop=True), list(kept.notes), {}
    for quantity in QUANTITIES[rig]:
        column = quantity if measured else f"true_{quantity}"
        there, lost = usable(table, column, least=LEAST_USABLE)
        notes += [line for line in lost if line not in notes]
        runs[quantity] = table[column].where(there).astype(float)
        good = runs[there]
        seen = (good.loc[good["kind"] == k, quantity] for k in (DRAWN, SET))
        of[quantity] = predictive(*seen)
    told = {n: table[n] for n in ("seconds", "key") if n in table}
    return Prediction(rig, of, runs.assign(**told), tuple(notes))


def sign(quantity: str) -> str:
    """What stands behind a number of it: "°", " s"."""
    unit = UNITS[quantity]
    return "°" if unit == "deg" else f" {unit}"


def digits(quantity: str, value: float, more: int = 0) -> str:
    """A number of it without its unit; more: decimals than usual."""
    return f"{value:.{DECIMALS.get(UNITS[quantity], 1) + more}f}"


def intervals(row: Any) -> tuple[str, str]:
    """Of a row of `rows`, in words: 95 % of single packings with the mean, and of the
    mean over packings."""
    q = row.quantity
    mean, *ends = (digits(q, v) for v in (row.mean, row.low, row.high))
    many = (digits(q, v) for v in (row.mean_low, row.mean_high))
    return f"{mean} ({' to '.join(ends)}){sign(q)}", f"{' to '.join(many)}{sign(q)}"


def rows(found: Prediction) -> pd.DataFrame:
    """A row a quantity: unit; mean; low, high (95 % of single packings); mean_low,
    mean_high (95 % of the mean over packings); parameter_sd, packing_sd; draws."""
    table = []
    for quantity, p in found.of.items():
        one, many = p.half_width(), p.half_width(float("inf"))
        row: dict[str, object] = {"rig": found.rig, "quantity": quantity}
        row |= {"unit": UNITS[quantity]}
        row |= {"mean": p.mean, "low": p.mean - one, "high": p.mean + one}
        row |= {"mean_low": p.mean - many, "mean_high": p.mean + many}
        row |= {"parameter_sd": p.parameter_sd, "packing_sd": p.packing_sd}
        table.append(row | {"draws": p.n})
    return pd.DataFrame(table)
