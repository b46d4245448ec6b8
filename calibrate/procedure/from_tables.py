"""The procedure on simulations that stand in BENCH/tables/: drop, slide, roll, path,
levels, design, and published.toml.

Everything that published.toml says was printed is recomputed from the tables and stands
beside it (`published.py`)."""

import tomllib
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
from benchtwin.calibrate.procedure.bench import (
    Bench,
    bench_of,
    contradictory,
    missing,
    trimmed_before,
)
from benchtwin.calibrate.procedure.calibration import (
    FOLLOWS,
    Calibration,
    nothing_calibrated,
)
from benchtwin.calibrate.procedure.joint import fit_joint
from benchtwin.calibrate.procedure.pile import PileFit, fit_pile
from benchtwin.calibrate.procedure.published import check_pile, check_steel
from benchtwin.calibrate.procedure.published_keys import checked
from benchtwin.calibrate.procedure.rigs import PILE_RESPONSE, STEEL
from benchtwin.calibrate.procedure.steel import SteelFit, fit_beyond, fit_steel
from benchtwin.calibrate.procedure.tables import (
    LETTERS,
    box_of,
    design_table,
    levels_table,
    naming,
    path_table,
    steel_table,
)
from benchtwin.calibrate.statistics.ascent import choose_centre
from benchtwin.calibrate.statistics.inversion import OutsideRange
from benchtwin.calibrate.statistics.replicates import Noise, packing_noise
from benchtwin.twin.bench_folder import Observed


def calibrate_tables(folder: Path | Observed, *, seed: int = 1) -> Calibration:
    """Calibrate a bench on tabulated simulations.

    Raises FileNotFoundError naming the table that is not there; ValueError naming file
    and column of what cannot be used."""
    tables = Path(folder) / "tables"
    if not tables.is_dir():
        raise FileNotFoundError(
            f"{tables}: not there; --tables needs drop.csv, slide.csv, roll.csv,"
            " design.csv, levels.csv in it"
        )
    file = tables / "published.toml"
    printed = published(file)
    bench = trimmed_before(bench_of(folder), trimmed(printed))
    rng = np.random.default_rng(seed)
    steel, refused, checks, flags = {}, missing(bench), [], []
    for name in STEEL:
        if name in bench.rigs:
            try:
                steel[name] = _steel(bench, tables, name, printed.get(name, {}), rng)
            except (OutsideRange, ValueError, FileNotFoundError) as error:
                refused[name] = str(error)
                continue
            with naming(file):
                checks.append(
                    check_steel(steel[name], bench.rigs[name], printed.get(name, {}))
                )
            flags += _outside(steel[name])
    pile = None
    if "pile" in bench.rigs:
        try:
            pile = _pile(bench, tables, printed.get("pile", {}), rng)
            with naming(file):
                table, more = check_pile(
                    pile, printed.get("pile", {}), levels_table(tables / "levels.csv")
                )
            checks.append(table)
            flags += more
        except (ValueError, FileNotFoundError) as error:
            refused["pile"] = str(error)
    if not steel and pile is None:
        raise nothing_calibrated(folder, refused)
    none = pd.DataFrame(columns=FOLLOWS)
    return Calibration(
        mode="tables",
        bench=bench,
        steel=steel,
        pile=pile,
        joint=fit_joint(steel, pile, rng=rng),
        refused=refused,
        findings=(*contradictory(bench), *(pile.findings if pile else ())),
        options={"tables": str(tables)},
        seed=seed,
        checks=pd.concat([t for t in checks if len(t)] or [none], ignore_index=True),
        flags=tuple(flags),
        title=printed.get("title", ""),
    )


def published(file: Path) -> dict:
    """What published.toml says was printed; empty without the file. ValueError where it
    is no TOML."""
    if not file.is_file():
        return {}
    try:
        return checked(tomllib.loads(file.read_text(encoding="utf-8-sig")), file)
    except (tomllib.TOMLDecodeError, UnicodeDecodeError, RecursionError) as error:
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
    bench: Bench, tables: Path, name: str, printed: dict, rng: np.random.Generator
) -> SteelFit:
    """As the paper fits it, unweighted; the monotone curve weighs rows by their printed
    sds."""
    rig, readings = STEEL[name], bench.rigs[name]
    mean, file = readings.mean(), tables / f"{name}.csv"
    rows = steel_table(file, rig)
    if rig.sd in rows and "repeats" in printed:
        rows = rows.assign(repeats=printed["repeats"])
    elif rig.sd in rows:
        rows = rows.drop(columns=rig.sd)
    with naming(file):
        fit = fit_steel(
            rig, rows, mean, rng=rng, description=readings.description, weighted=False
        )
    if fit.by == "polynomial":
        return fit
    try:
        beyond = fit_beyond(rig, rows, fit.bench)
        row = (
            "polynomial, a little beyond its rows",
            beyond.value,
            beyond.low,
            beyond.high,
            "; ".join(beyond.notes),
        )
    except OutsideRange as error:
        row = (
            "polynomial, a little beyond its rows",
            np.nan,
            np.nan,
            np.nan,
            str(error),
        )
    return replace(
        fit,
        answers=pd.concat(
            [fit.answers, pd.DataFrame([row], columns=fit.answers.columns)],
            ignore_index=True,
        ),
    )


def _outside(fit: SteelFit) -> list[str]:
    """A polynomial that does not reach the bench's mean within its own rows, said with
    its end."""
    if fit.by == "polynomial":
        return []
    ends = [
        float(fit.polynomial.mean(x)[0])
        for x in (fit.polynomial.low, fit.polynomial.high)
    ]
    near = int(np.argmin([abs(e - fit.bench.value) for e in ends]))
    x = (fit.polynomial.low, fit.polynomial.high)[near]
    return [
        f"{fit.rig.equation} gives {ends[near]:.4g} {fit.rig.unit} at its end"
        f" {fit.rig.parameter} = {x:g}, the bench's mean is {fit.bench.value:.4g}"
        f" {fit.rig.unit}: it has no answer within its own rows; the {fit.by} answers"
        f" {fit.inverse.value:.4f}"
    ]


def _pile(
    bench: Bench, tables: Path, printed: dict, rng: np.random.Generator
) -> PileFit:
    box = box_of(levels_table(tables / "levels.csv"), tables / "levels.csv")
    factors, file = box.names, tables / "design.csv"
    coded = design_table(file)
    design = pd.DataFrame(
        np.round(box.natural(coded[list(LETTERS)]), 12), columns=list(factors)
    )
    design = design.assign(**{PILE_RESPONSE: coded[PILE_RESPONSE]})
    notes, noise = [], _noise(design, factors)
    readings = bench.rigs["pile"]
    other = (noise.sd, float(noise.df)) if noise else None
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
    mean = readings.mean(other=other)
    path = None
    if (tables / "path.csv").is_file():
        steps = path_table(tables / "path.csv")
        with naming(tables / "path.csv"):
            path = choose_centre(
                steps,
                PILE_RESPONSE,
                mean.value,
                factors,
                noise_sd=noise.sd if noise else 0.0,
            )
    with naming(file):
        fit = fit_pile(design, box, mean, rng=rng, near=printed.get("optimum"))
        return replace(fit, path=path, noise=noise, notes=(*notes, *fit.notes))


def _noise(design: pd.DataFrame, factors: tuple[str, ...]) -> Noise | None:
    """Scatter of piles with the same parameters, from points that were run more than
    once."""
    try:
        return packing_noise(
            design.assign(
                point=design[list(factors)].astype(str).agg(" ".join, axis=1)
            ),
            PILE_RESPONSE,
            point="point",
        )
    except ValueError:
        return None
