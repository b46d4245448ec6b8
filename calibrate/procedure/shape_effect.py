"""Whether the seeds' shape matters: the rigs at the calibrated parameters with the lot,
its typical seed, and ellipsoids."""

from dataclasses import dataclass

import numpy as np
import pandas as pd
from benchtwin.calibrate.procedure.rigs import PILE_RESPONSE
from benchtwin.calibrate.procedure.simulator import Run, Simulator, seed_numbers
from benchtwin.calibrate.procedure.steel import SteelFit
from benchtwin.twin.lot import other_seeds

LEAST = 2  # runs of either kind, below which a difference has no error


@dataclass(frozen=True)
class Question:
    """One rig to run. description: sections of its recording.toml, with the lot;
    values: all contact parameters; runs: of each kind of seed; slope: d response / d
    parameter at those values, None where the reading stands for no single parameter."""

    rig: str
    response: str
    unit: str
    parameter: str
    description: dict
    values: dict[str, float]
    runs: int
    slope: float | None


def shape_effect(
    questions: list[Question], simulate: Simulator, seed: int
) -> pd.DataFrame:
    """A row a rig and kind of seed: rig, seeds, response, unit, mean, runs, difference
    and difference_sd from the lot's mean, parameter, and by how much it would come out
    differently (parameter_shift, parameter_shift_sd: difference over −slope).

    Runs of different kinds share their generators' numbers, not their packings: their
    errors are independent."""
    rows = []
    for q in questions:
        kinds = {"lot": q.description} | {
            name: q.description | {"seed": section}
            for name, section in other_seeds(q.description["seed"]).items()
        }
        runs = [
            Run(q.rig, q.values, seed_numbers(seed, "shape", q.rig, k), description)
            for description in kinds.values()
            for k in range(q.runs)
        ]
        table = simulate(runs).reset_index(drop=True)
        answered = (
            table[q.response].to_numpy(float)
            if q.response in table
            else np.full(len(table), np.nan)
        )
        found = np.split(answered, len(kinds))
        rows += _rows(q, dict(zip(kinds, found)))
    return pd.DataFrame(rows)


def _rows(q: Question, found: dict[str, np.ndarray]) -> list[dict]:
    kept = {name: values[np.isfinite(values)] for name, values in found.items()}
    rows = []
    for name, values in kept.items():
        row = {
            "rig": q.rig,
            "seeds": name,
            "response": q.response,
            "unit": q.unit,
            "runs": len(values),
        }
        row |= {
            "mean": float(values.mean()) if len(values) else np.nan,
            "parameter": q.parameter,
        }
        if name != "lot" and min(len(values), len(kept["lot"])) >= LEAST:
            off = float(values.mean() - kept["lot"].mean())
            sd = float(
                np.sqrt(
                    values.var(ddof=1) / len(values)
                    + kept["lot"].var(ddof=1) / len(kept["lot"])
                )
            )
            row |= {"difference": off, "difference_sd": sd}
            if q.slope:
                row |= {
                    "parameter_shift": -off / q.slope,
                    "parameter_shift_sd": abs(sd / q.slope),
                }
        rows.append(row)
    return rows


def steel_question(
    fit: SteelFit, description: dict, fixed: dict[str, float], runs: int
) -> Question:
    """What to ask of a seed–steel rig: the slope is that of the curve that answered, at
    the answer."""
    rig, at = fit.rig, fit.inverse.value
    width = 0.05 * max(fit.surrogate.high - fit.surrogate.low, 1e-9)
    ends = np.clip([at - width, at + width], fit.surrogate.low, fit.surrogate.high)
    low, high = (float(v) for v in fit.surrogate.mean(ends))
    slope = (high - low) / float(np.ptp(ends)) if np.ptp(ends) > 0 else None
    return Question(
        rig.name,
        rig.response,
        rig.unit,
        rig.parameter,
        description,
        {**fixed, rig.parameter: at},
        runs,
        slope,
    )


def pile_question(description: dict, values: dict[str, float], runs: int) -> Question:
    """What to ask of the pile: by how much its angle moves; three parameters share it,
    so none is said to shift."""
    return Question("pile", PILE_RESPONSE, "deg", "", description, values, runs, None)


def verdict(table: pd.DataFrame) -> list[str]:
    """A sentence a rig and kind of seed: how much the reading, and the parameter, would
    differ."""
    sentences: list[str] = []
    if "difference" not in table:
        return sentences
    for row in table[table["difference"].notna()].itertuples():
        clear = abs(row.difference) > 2 * row.difference_sd
        size = f"{row.difference:+.2g} ± {row.difference_sd:.1g} {row.unit}"
        text = (
            f"{row.rig}: with {SEEDS[row.seeds]} the"
            f" {row.response.rsplit('_', 1)[0].replace('_', ' ')} "
        )
        text += (
            f"differs by {size}"
            if clear
            else f"is the same within {2 * row.difference_sd:.1g} {row.unit}"
        )
        shift = getattr(row, "parameter_shift", np.nan)
        if clear and np.isfinite(shift):
            text += (
                f"; {row.parameter} would have come out {shift:+.2g} ±"
                f" {row.parameter_shift_sd:.1g} off"
            )
        sentences.append(text)
    return sentences


SEEDS = {
    "typical seed": "the lot's typical seed alone",
    "ellipsoids": "ellipsoids of the lot's sizes",
}
