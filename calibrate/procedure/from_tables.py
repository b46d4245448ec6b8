"""The procedure on simulations that stand in BENCH/tables/: drop, slide, roll, path,
levels, design, and published.toml.

Everything that published.toml says was printed is recomputed from the tables and stands
beside it (`published.py`)."""

import tomllib
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd

from benchtwin.bench.language import tr
from benchtwin.bench.tells import ByCurve
from benchtwin.calibrate.procedure.bench import RigReadings, bench_of
from benchtwin.calibrate.procedure.calibration import Calibration
from benchtwin.calibrate.procedure.published import check_pile, check_steel, checked
from benchtwin.calibrate.procedure.rigs import PILE, STEEL
from benchtwin.calibrate.procedure.steel import SteelFit, fit_steel
from benchtwin.calibrate.procedure.surface import SurfaceFit, angle_alone, fit_pile
from benchtwin.calibrate.procedure.tables import (
    design_table,
    levels_box,
    naming,
    path_table,
    steel_table,
)
from benchtwin.calibrate.statistics.ascent import choose_centre
from benchtwin.calibrate.statistics.equation import fit_equation
from benchtwin.twin.bench_folder import Observed


def calibrate_tables(folder: Path | Observed, *, seed: int = 1) -> Calibration:
    """Calibrate a bench on tabulated simulations.

    Raises FileNotFoundError naming the table that is not there; ValueError naming file
    and column of what cannot be used."""
    tables = Path(folder) / "tables"
    if not tables.is_dir():
        needed = ", ".join(f"{name}.csv" for name in (*STEEL, "design", "levels"))
        raise FileNotFoundError(
            tr("{}: not there; --tables needs {} in it", tables, needed)
        )
    printed = published(tables / "published.toml")
    bench = bench_of(folder, trimmed(printed))
    found = Calibration.of("tables", bench, seed, {"tables": str(tables)})
    found = replace(found, title=printed.get("title", ""))
    for name in (n for n in STEEL if n in bench.rigs):
        found = _steel_rig(found, tables, name, printed.get(name, {}))
    if PILE.name in bench.rigs:
        found = _pile_rig(found, tables, printed.get(PILE.name, {}))
    return replace(found.joined(np.random.default_rng(seed)), finished=True)


def _steel_rig(
    found: Calibration, tables: Path, name: str, printed: dict
) -> Calibration:
    """With a seed–steel rig's table fitted, and what was printed of it checked."""
    readings, rig = found.bench.rigs[name], STEEL[name]
    file = tables / f"{name}.csv"
    found = found.trying(
        name, lambda: found.with_steel(name, _steel(rig, readings, file))
    )
    if (fit := found.steel.get(name)) is None:
        return found
    with naming(tables / "published.toml"):
        return found.checked(check_steel(fit, readings, printed), _outside(fit))


def _pile_rig(found: Calibration, tables: Path, printed: dict) -> Calibration:
    """With the pile's tables fitted, and what was printed of them checked."""
    readings, name = found.bench.rigs[PILE.name], PILE.name

    def fitted() -> Calibration:
        fit = _pile(readings, tables, printed)
        return replace(found, surface=fit).with_seeds(name, angle_alone(fit))

    done = found.trying(name, fitted)
    if done.surface is None:
        return done
    try:
        with naming(tables / "published.toml"):
            return done.checked(check_pile(done.surface, printed), [])
    except (ValueError, FileNotFoundError) as error:
        return found.without(name, error)


def published(file: Path) -> dict:
    """What published.toml says was printed; empty without the file. ValueError where it
    is no TOML."""
    if not file.is_file():
        return {}
    try:
        return checked(tomllib.loads(file.read_text(encoding="utf-8-sig")), file)
    except (ValueError, RecursionError) as error:
        raise ValueError(tr("{}: not valid TOML: {}", file, error)) from error


def trimmed(printed: dict) -> dict[str, int]:
    """How many highest and lowest readings were left out before, by rig."""
    rigs = {rig: keys for rig, keys in printed.items() if isinstance(keys, dict)}
    return {
        rig: keys["bench_trimmed"]
        for rig, keys in rigs.items()
        if "bench_trimmed" in keys
    }


def _steel(rig: ByCurve, readings: RigReadings, file: Path) -> SteelFit:
    """The table's rows with the publication's curve through them, and what they say of
    the bench's mean."""
    readings.mean()  # what cannot be used is refused first
    rows = steel_table(file, rig)
    with naming(file):
        fit_equation(rows, rig.parameter, rig.response, rig.degree)
        fit = fit_steel(rig, rows, readings, rows)
        if not fit.reached:
            raise ValueError(
                tr(
                    "no {} of its rows gives the bench's {:.4g} {}",
                    rig.parameter,
                    fit.bench.value,
                    rig.unit,
                )
            )
    return fit


def _outside(fit: SteelFit) -> list[str]:
    """A curve that does not reach the bench's mean within its own rows, said with its
    end."""
    curve = fit.equation
    if curve.low <= curve.at(fit.bench.value) <= curve.high:
        return []
    x = np.array([curve.low, curve.high])
    ends = curve.mean(x)
    near = int(np.argmin(abs(ends - fit.bench.value)))
    return [
        tr(
            "{} gives {:.4g} {} at its end {} = {:g}, the bench's mean is {:.4g} {}: it"
            " has no answer within its own rows; followed beyond them it answers"
            " {:.4f}",
            fit.rig.equation,
            ends[near],
            fit.rig.unit,
            fit.rig.parameter,
            x[near],
            fit.bench.value,
            fit.rig.unit,
            curve.at(fit.bench.value),
        )
    ]


def _pile(readings: RigReadings, tables: Path, printed: dict) -> SurfaceFit:
    """As the paper fits it: unweighted, every pile on a packing of its own."""
    box, file = levels_box(tables / "levels.csv"), tables / "design.csv"
    design = design_table(file, box)
    notes, noise = [], _noise(design, box.names)
    if readings.values.size == 1:
        if noise is None:
            raise ValueError(
                tr(
                    "{}: no point run twice with different angles tells the scatter of"
                    " the bench's only pile",
                    file,
                )
            )
        notes.append(
            tr(
                "one bench pile: its scatter is taken to be that of the simulated piles"
                " at the centre, {:.2g}° on {:g} degrees of freedom",
                noise[0],
                noise[1],
            )
        )
    mean = readings.mean(other=noise)
    path, walked, sd = None, tables / "path.csv", noise[0] if noise else 0.0
    if walked.is_file():
        steps = path_table(walked)
        with naming(walked):
            path = choose_centre(
                steps, PILE.response, mean.value, box.names, noise_sd=sd
            )
    with naming(file):
        fit = fit_pile(design, box, mean, near=printed.get("optimum"))
    return replace(fit, path=path, notes=(*notes, *fit.notes))


def _noise(
    design: pd.DataFrame, factors: tuple[str, ...]
) -> tuple[float, float] | None:
    """Scatter of piles with the same parameters and its degrees of freedom, from points
    that were run more than once; None where there are none or they do not scatter."""
    y = design[PILE.response]
    within = y - y.groupby([design[f] for f in factors]).transform("mean")
    free = len(design) - len(design[list(factors)].drop_duplicates())
    if free < 1 or not within.any():
        return None
    return float(np.sqrt((within**2).sum() / free)), float(free)
