"""A rig simulated at parameters drawn from a calibration's posterior: what it will
show, and how well that is known."""

from dataclasses import dataclass
from typing import Any

import pandas as pd

from benchtwin.bench.tells import by_surface
from benchtwin.calibrate.prediction.posterior import Kept
from benchtwin.calibrate.procedure.rigs import PARAMETERS
from benchtwin.calibrate.procedure.simulator import Run, Simulator, seed_numbers, usable
from benchtwin.calibrate.statistics.predictive import Predictive, predictive
from benchtwin.twin.job import rig_named

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
