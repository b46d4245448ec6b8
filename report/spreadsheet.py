"""What a calibration found as a workbook, for spreadsheet programs and a paper's
tables."""

from pathlib import Path

import pandas as pd

from benchtwin.bench.workbook import WORKBOOK, write_workbook
from benchtwin.calibrate.procedure.calibration import Calibration, parameters
from benchtwin.calibrate.procedure.joint import LEVEL
from benchtwin.calibrate.procedure.pile import PileFit
from benchtwin.calibrate.procedure.pile_surrogate import PileObservables
from benchtwin.calibrate.procedure.rigs import PILE, STEEL
from benchtwin.calibrate.procedure.steel import SteelFit
from benchtwin.calibrate.result_file import CONVENTIONS
from benchtwin.report import draw
from benchtwin.report.numbers import words
from benchtwin.twin.parameters import Parameters
from benchtwin.twin.result_sections import materials_and_shape
from benchtwin.twin.versions import versions

METHODS = ["what", "unit", "value or method"]
MEANS = [
    *("rig", "reading", "unit", "n", "mean", "sd of the mean", "of it from scatter"),
    *("degrees of freedom", "of it in common"),
]
READ = {**STEEL, PILE.name: PILE}  # what each rig is calibrated on
SIMULATED = "simulations of the same rigs with Hertz–Mindlin contacts"
UNITS = {"density_kg_m3": "kg/m³", "shear_modulus_pa": "Pa", "poisson_ratio": "1"}


def write_spreadsheet(c: Calibration, out: Path) -> None:
    """results.xlsx in the folder `out`. OSError when it cannot be written."""
    write_workbook(out / WORKBOOK, sheets(c))


def sheets(c: Calibration) -> dict[str, pd.DataFrame]:
    """The workbook's sheets by name."""
    return {
        "parameters": _parameters(c),
        "intervals": _intervals(c),
        "correlations": _correlations(c),
        "means over repeats": _means(c),
        "units and methods": _methods(c),
    }


def _parameters(c: Calibration) -> pd.DataFrame:
    table = parameters(c)
    table["budget"] = [
        "; ".join(f"{k} {v:.0%}" for k, v in shares.items())
        for shares in table["budget"]
    ]
    table["status"] = table["status"].map(words)
    table["source"] = table["source"].map(words)
    table.insert(0, "in words", table["parameter"].map(draw.name))
    return table


def _intervals(c: Calibration) -> pd.DataFrame:
    """Each parameter by itself, of the posterior of all recordings together."""
    if c.joint is None:
        return pd.DataFrame(columns=["parameter", "level", "low", "high"])
    table = c.joint.table.rename(columns={"factor": "parameter"})
    table.insert(1, "level", LEVEL)
    return table


def _correlations(c: Calibration) -> pd.DataFrame:
    """Of the posterior's draws; the first column names the row."""
    if c.joint is None:
        return pd.DataFrame(columns=["parameter"])
    found = c.joint.posterior.draws.corr()
    return found.rename_axis("parameter").reset_index()


def _fits(c: Calibration) -> dict[str, SteelFit | PileFit]:
    return {**c.steel, **({PILE.name: c.pile} if c.pile is not None else {})}


def _means(c: Calibration) -> pd.DataFrame:
    """What was calibrated on: a row a reading."""
    read = [(n, READ[n].response, f.bench) for n, f in _fits(c).items()]
    for name, seen in _several(c).items():
        there = {f"{rig}: {reading}" for rig, reading, _ in read}
        more = [o for o in seen.observables if o.name not in there]
        read += [(name, o.name.removeprefix(f"{name}: "), o.bench) for o in more]
    rows = [
        (
            *(name, reading, reading.rsplit("_", 1)[-1]),
            *(m.n, m.value, m.sd, m.scatter_sd, m.df, m.shared_sd),
        )
        for name, reading, m in read
    ]
    return pd.DataFrame(rows, columns=MEANS)


def _several(c: Calibration) -> dict[str, PileObservables]:
    """Rigs of which more than one reading was used."""
    seen = c.pile.seen if c.pile is not None else None
    return {**({PILE.name: seen} if seen is not None else {}), **c.beside}


def _methods(c: Calibration) -> pd.DataFrame:
    """What a reader of the numbers has to know; a paragraph for a paper first."""
    rows: list[tuple[str, str, object]] = [("in words", "", in_words(c))]
    rows += [(key.replace("_", " "), "", text) for key, text in CONVENTIONS.items()]
    materials, _ = materials_and_shape(c.bench.seed, Parameters())
    for role, material in materials.items():
        for key, value in material.items():
            if isinstance(value, str | int | float):
                what = f"{role}: {key.replace('_', ' ')}"
                rows.append((what, UNITS.get(key, ""), value))
    rows += [(rig, "", f"not calibrated: {why}") for rig, why in c.refused.items()]
    rows += [("seed of the random numbers", "1", c.seed)]
    rows += [(f"version of {name}", "", text) for name, text in versions().items()]
    return pd.DataFrame(rows, columns=METHODS)


def in_words(c: Calibration) -> str:
    """How the parameters were found, as a paper's methods state it."""
    read = [
        f"{words(READ[n].response)} {f.bench.value:.4g} ± {f.bench.sd:.2g}"
        f" {draw.unit(READ[n].unit)} (n = {f.bench.n})"
        for n, f in _fits(c).items()
    ]
    by = "printed simulations" if c.mode == "tables" else SIMULATED
    return (
        f"Contact parameters were calibrated with benchtwin {versions()['benchtwin']}:"
        f" means over repeats ± their standard deviation ({'; '.join(read)}) were"
        f" matched by {by}. Intervals hold the value with probability {LEVEL:.0%},"
        " given the model. Rolling friction is in EDEM's standard convention (torque ="
        " μ_r × normal force × distance from the centroid to the contact)."
    )
