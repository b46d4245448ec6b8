"""Whether the seeds' shape matters: the rigs at the calibrated parameters with the lot,
its typical seed, and ellipsoids."""

from dataclasses import dataclass

import numpy as np
import pandas as pd

from benchtwin.bench.language import tr
from benchtwin.calibrate.procedure.rigs import PILE
from benchtwin.calibrate.procedure.simulator import Run, Simulator, seed_numbers
from benchtwin.calibrate.procedure.steel import SteelFit
from benchtwin.twin.lot import other_seeds

LEAST = 2  # runs of either kind, below which a difference has no error
CLEAR = 2  # standard deviations of a difference, beyond which it is one
STEP = 0.05  # of the curve's range: over which its slope at the answer is taken
SEEDS = {
    "typical seed": "the lot's typical seed alone",
    "ellipsoids": "ellipsoids of the lot's sizes",
}


@dataclass(frozen=True, kw_only=True)
class Question:
    """One rig to run. description: sections of its recording.toml, with the lot;
    values: all contact parameters; runs: of each kind of seed; slope: d response / d
    parameter at those values, None where the reading stands for no single parameter."""

    rig: str
    response: str
    unit: str
    parameter: str = ""
    description: dict
    values: dict[str, float]
    runs: int
    slope: float | None = None


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
        others = other_seeds(q.description["seed"])
        kinds = {n: q.description | {"seed": seed} for n, seed in others.items()}
        kinds = {"lot": q.description} | kinds
        runs = [
            Run(q.rig, q.values, seed_numbers(seed, "shape", q.rig, k), description)
            for description in kinds.values()
            for k in range(q.runs)
        ]
        table = simulate(runs).reset_index(drop=True)
        nothing = pd.Series(np.nan, index=table.index)
        answered = table.get(q.response, nothing).to_numpy(float)
        rows += _rows(q, dict(zip(kinds, np.split(answered, len(kinds)))))
    return pd.DataFrame(rows)


def _rows(q: Question, found: dict[str, np.ndarray]) -> list[dict]:
    kept = {name: values[np.isfinite(values)] for name, values in found.items()}
    lot, rows = kept["lot"], []
    for name, values in kept.items():
        row = {
            "rig": q.rig,
            "seeds": name,
            "response": q.response,
            "unit": q.unit,
            "runs": len(values),
            "mean": float(values.mean()) if len(values) else np.nan,
            "parameter": q.parameter,
        }
        if name != "lot" and min(len(values), len(lot)) >= LEAST:
            off = float(values.mean() - lot.mean())
            variance = values.var(ddof=1) / len(values) + lot.var(ddof=1) / len(lot)
            sd = float(np.sqrt(variance))
            row |= {"difference": off, "difference_sd": sd}
            if q.slope:
                shift, its_sd = -off / q.slope, abs(sd / q.slope)
                row |= {"parameter_shift": shift, "parameter_shift_sd": its_sd}
        rows.append(row)
    return rows


def steel_question(
    fit: SteelFit, description: dict, fixed: dict[str, float], runs: int
) -> Question:
    """What to ask of a seed–steel rig: the slope is that of the curve that answered, at
    the answer."""
    rig, at = fit.rig, fixed[fit.rig.parameter]
    least, most = fit.surrogate.box.range(rig.parameter)
    width = STEP * (most - least)
    ends = np.clip([at - width, at + width], least, most)
    low, high = fit.surrogate.evaluate(ends[:, None])[0]
    return Question(
        rig=rig.name,
        response=rig.response,
        unit=rig.unit,
        parameter=rig.parameter,
        description=description,
        values=dict(fixed),
        runs=runs,
        slope=float((high - low) / np.ptp(ends)) if np.ptp(ends) > 0 else None,
    )


def pile_question(description: dict, values: dict[str, float], runs: int) -> Question:
    """What to ask of the pile: by how much its angle moves; three parameters share it,
    so none is said to shift."""
    return Question(
        rig=PILE.name,
        response=PILE.response,
        unit=PILE.unit,
        description=description,
        values=values,
        runs=runs,
    )


def verdict(table: pd.DataFrame) -> list[str]:
    """A sentence a rig and kind of seed: how much the reading, and the parameter, would
    differ."""
    sentences: list[str] = []
    if "difference" not in table:
        return sentences
    for row in table[table["difference"].notna()].itertuples():
        off, sd = row.difference, row.difference_sd
        clear, same = abs(off) > CLEAR * sd, f"{CLEAR * sd:.1g} {row.unit}"
        size = tr("differs by {:+.2g} ± {:.1g} {}", off, sd, row.unit)
        read = row.response.rsplit("_", 1)[0].replace("_", " ")
        text = tr("{}: with {} the {} ", row.rig, SEEDS[row.seeds], read)
        text += size if clear else tr("is the same within {}", same)
        shift = getattr(row, "parameter_shift", np.nan)
        if clear and np.isfinite(shift):
            text += tr(
                "; {} would have come out {:+.2g} ± {:.1g} off",
                row.parameter,
                shift,
                row.parameter_shift_sd,
            )
        sentences.append(text)
    return sentences
