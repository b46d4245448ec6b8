"""A rig simulated at parameters drawn from a calibration's posterior: what it will
show, and how well that is known."""

from dataclasses import dataclass

import pandas as pd
from benchtwin.bench.rigs import RIGS, VARIANTS
from benchtwin.calibrate.prediction.posterior import Kept
from benchtwin.calibrate.procedure.rigs import PARAMETERS
from benchtwin.calibrate.procedure.simulator import Run, Simulator, seed_numbers, usable
from benchtwin.calibrate.statistics.predictive import Predictive, predictive
from benchtwin.twin.job import rig_named

# systems that no calibration saw, of which angles are read: a rig built otherwise, and
# rigs that tell a calibration nothing
SYSTEMS = VARIANTS | {name: rig for name, rig in RIGS.items() if not rig.tells}
QUANTITIES = {
    name: {column: of.replace("_", " ") for column, (of, _) in rig.readings.items()}
    for name, rig in SYSTEMS.items()
    if {unit for _, unit in rig.readings.values()} == {"deg"}
}
DRAWN, MEAN = "posterior draw", "posterior mean"
# share of the runs: with fewer, those that failed could decide the answer
LEAST_USABLE = 0.75


@dataclass(frozen=True, eq=False)
class Prediction:
    """rig; of: {quantity: Predictive}, quantities in degrees; runs: a row a run: kind
    (DRAWN or MEAN), parameters, quantities, seconds where known; notes."""

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
    posterior's mean, each with its own packing.

    measured: read the angles off the pictures, not off the simulation's own outline.
    Raises ValueError where `predictive` does, SimulationFailed where too many runs gave
    nothing."""
    drawn = kept.some(draws, seed).assign(kind=DRAWN)
    middle = pd.DataFrame([kept.draws.mean()] * packings).assign(kind=MEAN)
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
        angles = (good.loc[good["kind"] == k, quantity] for k in (DRAWN, MEAN))
        of[quantity] = predictive(*angles)
    told = {n: table[n] for n in ("seconds", "key") if n in table}
    return Prediction(rig, of, runs.assign(**told), tuple(notes))


def rows(found: Prediction) -> pd.DataFrame:
    """A row a quantity [deg]: mean; low, high (95 % of single packings); mean_low,
    mean_high (95 % of the mean over packings); parameter_sd, packing_sd; draws."""
    table = []
    for quantity, p in found.of.items():
        one, many = p.half_width(), p.half_width(float("inf"))
        row = {"rig": found.rig, "quantity": quantity, "mean": p.mean}
        row |= {"low": p.mean - one, "high": p.mean + one}
        row |= {"mean_low": p.mean - many, "mean_high": p.mean + many}
        row |= {"parameter_sd": p.parameter_sd, "packing_sd": p.packing_sd}
        table.append(row | {"draws": p.n})
    return pd.DataFrame(table)
