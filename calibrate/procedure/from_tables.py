"""The procedure on simulations that stand in BENCH/tables/: drop, slide, roll, path,
levels, design, and published.toml.

Everything that published.toml says was printed is recomputed from the tables and stands
beside it (`published.py`)."""

import tomllib
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd

from benchtwin.bench.tells import ByCurve
from benchtwin.calibrate.procedure.bench import RigReadings, bench_of
from benchtwin.calibrate.procedure.calibration import Calibration
from benchtwin.calibrate.procedure.pile import PileFit, fit_pile
from benchtwin.calibrate.procedure.published import check_pile, check_steel
from benchtwin.calibrate.procedure.published_keys import checked
from benchtwin.calibrate.procedure.rigs import PILE, STEEL
from benchtwin.calibrate.procedure.steel import (
    ANSWERS,
    SteelFit,
    answer_row,
    fit_beyond,
    fit_steel,
)
from benchtwin.calibrate.procedure.tables import (
    design_table,
    levels_box,
    levels_table,
    naming,
    path_table,
    steel_table,
)
from benchtwin.calibrate.statistics.ascent import choose_centre
from benchtwin.calibrate.statistics.inversion import Inverse, OutsideRange
from benchtwin.calibrate.statistics.replicates import Noise, packing_noise
from benchtwin.twin.bench_folder import Observed


def calibrate_tables(folder: Path | Observed, *, seed: int = 1) -> Calibration:
    """Calibrate a bench on tabulated simulations.

    Raises FileNotFoundError naming the table that is not there; ValueError naming file
    and column of what cannot be used."""
    tables = Path(folder) / "tables"
    if not tables.is_dir():
        needed = ", ".join(f"{name}.csv" for name in (*STEEL, "design", "levels"))
        raise FileNotFoundError(f"{tables}: not there; --tables needs {needed} in it")
    printed = published(tables / "published.toml")
    bench = bench_of(folder, trimmed(printed))
    rng = np.random.default_rng(seed)
    found = Calibration.of("tables", bench, seed, {"tables": str(tables)})
    found = replace(found, title=printed.get("title", ""))
    for name in (n for n in STEEL if n in bench.rigs):
        found = _steel_rig(found, tables, name, printed.get(name, {}), rng)
    if PILE.name in bench.rigs:
        found = _pile_rig(found, tables, printed.get(PILE.name, {}), rng)
    return found.joined(rng)


def _steel_rig(
    found: Calibration,
    tables: Path,
    name: str,
    printed: dict,
    rng: np.random.Generator,
) -> Calibration:
    """With a seed–steel rig's table fitted, and what was printed of it checked."""
    readings = found.bench.rigs[name]
    rig, file = STEEL[name], tables / f"{name}.csv"
    found = found.trying(name, lambda: _steel(rig, readings, file, printed, rng))
    if (fit := found.steel.get(name)) is None:
        return found
    with naming(tables / "published.toml"):
        return found.checked(check_steel(fit, readings, printed), _outside(fit))


def _pile_rig(
    found: Calibration, tables: Path, printed: dict, rng: np.random.Generator
) -> Calibration:
    """With the pile's tables fitted, and what was printed of them checked."""
    readings = found.bench.rigs[PILE.name]
    found = found.trying(PILE.name, lambda: _pile(readings, tables, printed, rng))
    if found.pile is None:
        return found
    try:
        with naming(tables / "published.toml"):
            levels = levels_table(tables / "levels.csv")
            return found.checked(*check_pile(found.pile, printed, levels))
    except (ValueError, FileNotFoundError) as error:
        return found.without(PILE.name, error)


def published(file: Path) -> dict:
    """What published.toml says was printed; empty without the file. ValueError where it
    is no TOML."""
    if not file.is_file():
        return {}
    try:
        return checked(tomllib.loads(file.read_text(encoding="utf-8-sig")), file)
    except (ValueError, RecursionError) as error:
        raise ValueError(f"{file}: not valid TOML: {error}") from error


def trimmed(printed: dict) -> dict[str, int]:
    """How many highest and lowest readings were left out before, by rig."""
    rigs = {rig: keys for rig, keys in printed.items() if isinstance(keys, dict)}
    return {
        rig: keys["bench_trimmed"]
        for rig, keys in rigs.items()
        if "bench_trimmed" in keys
    }


def _steel(
    rig: ByCurve,
    readings: RigReadings,
    file: Path,
    printed: dict,
    rng: np.random.Generator,
) -> SteelFit:
    """As the paper fits it, unweighted; the monotone curve weighs rows by their printed
    sds."""
    mean, rows, stated = readings.mean(), steel_table(file, rig), readings.description
    if rig.sd in rows and "repeats" in printed:
        rows = rows.assign(repeats=printed["repeats"])
    elif rig.sd in rows:
        rows = rows.drop(columns=rig.sd)
    with naming(file):
        fit = fit_steel(rig, rows, mean, rng=rng, description=stated, weighted=False)
    if fit.by == "polynomial":
        return fit
    beyond: Inverse | OutsideRange
    try:
        beyond = fit_beyond(rig, rows, fit.bench)
    except OutsideRange as error:
        beyond = error
    row = answer_row("polynomial, a little beyond its rows", beyond)
    more = pd.DataFrame([row], columns=ANSWERS)
    return replace(fit, answers=pd.concat([fit.answers, more], ignore_index=True))


def _outside(fit: SteelFit) -> list[str]:
    """A polynomial that does not reach the bench's mean within its own rows, said with
    its end."""
    if fit.by == "polynomial":
        return []
    x = np.array([fit.polynomial.low, fit.polynomial.high])
    ends = fit.polynomial.mean(x)
    near = int(np.argmin(abs(ends - fit.bench.value)))
    return [
        f"{fit.rig.equation} gives {ends[near]:.4g} {fit.rig.unit} at its end"
        f" {fit.rig.parameter} = {x[near]:g}, the bench's mean is"
        f" {fit.bench.value:.4g} {fit.rig.unit}: it has no answer within its own rows;"
        f" the {fit.by} answers {fit.inverse.value:.4f}"
    ]


def _pile(
    readings: RigReadings, tables: Path, printed: dict, rng: np.random.Generator
) -> PileFit:
    """As the paper fits it: unweighted, every pile on a packing of its own."""
    box, file = levels_box(tables / "levels.csv"), tables / "design.csv"
    design = design_table(file, box)
    notes, noise = [], _noise(design, box.names)
    if readings.values.size == 1:
        if noise is None:
            raise ValueError(
                f"{file}: no point run twice with different angles tells the scatter of"
                " the bench's only pile"
            )
        notes.append(
            "one bench pile: its scatter is taken to be that of the simulated piles at"
            f" the centre, {noise.sd:.2g}° on {noise.df} degrees of freedom"
        )
    mean = readings.mean(other=(noise.sd, float(noise.df)) if noise else None)
    path, walked, sd = None, tables / "path.csv", noise.sd if noise else 0.0
    if walked.is_file():
        steps = path_table(walked)
        with naming(walked):
            path = choose_centre(
                steps, PILE.response, mean.value, box.names, noise_sd=sd
            )
    with naming(file):
        fit = fit_pile(design, box, mean, rng=rng, near=printed.get("optimum"))
    return replace(fit, path=path, noise=noise, notes=(*notes, *fit.notes))


def _noise(design: pd.DataFrame, factors: tuple[str, ...]) -> Noise | None:
    """Scatter of piles with the same parameters, from points that were run more than
    once."""
    point = design[list(factors)].astype(str).agg(" ".join, axis=1)
    try:
        return packing_noise(design.assign(point=point), PILE.response, point="point")
    except ValueError:
        return None
