"""What a calibration found as a workbook, for spreadsheet programs and a paper's
tables."""

import pandas as pd

from benchtwin.bench.language import tr
from benchtwin.bench.numbers import with_interval
from benchtwin.calibrate.procedure.calibration import LEVEL, Calibration, parameters
from benchtwin.calibrate.procedure.words import in_status
from benchtwin.calibrate.result_file import CONVENTIONS
from benchtwin.calibrate.statistics.posterior import Observable
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
SIMULATED = "simulations of the same rigs with Hertz–Mindlin contacts"
UNITS = {"density_kg_m3": "kg/m³", "shear_modulus_pa": "Pa", "poisson_ratio": "1"}


def sheets(c: Calibration) -> dict[str, pd.DataFrame]:
    """The workbook's sheets by name."""
    return {
        "parameters": _parameters(c),
        "posterior": _posterior(c),
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
    for column in ("remark", "source"):
        table[column] = table[column].map(words)
    table.insert(0, "in words", table["parameter"].map(draw.name))
    return table


def _posterior(c: Calibration) -> pd.DataFrame:
    """How far the posterior narrows each parameter, and how well it was drawn."""
    if c.joint is None:
        return pd.DataFrame(columns=["parameter"])
    return c.joint.table.rename(columns={"factor": "parameter"})


def _correlations(c: Calibration) -> pd.DataFrame:
    """Of the posterior's draws; the first column names the row."""
    if c.joint is None:
        return pd.DataFrame(columns=["parameter"])
    found = c.joint.posterior.draws.corr()
    return found.rename_axis("parameter").reset_index()


def _observables(c: Calibration) -> list[Observable]:
    """What was calibrated on."""
    seeds = (o for seen in c.seeds.values() for o in seen.observables)
    return [*(fit.observable for fit in c.steel.values()), *seeds]


def _means(c: Calibration) -> pd.DataFrame:
    """What was calibrated on: a row a reading."""
    rows = []
    for o in _observables(c):
        (name, reading), m = o.name.split(": "), o.bench
        unit = reading.rsplit("_", 1)[-1]
        of = (m.n, m.value, m.sd, m.scatter_sd, m.df, m.shared_sd)
        rows.append((name, reading, unit, *of))
    return pd.DataFrame(rows, columns=MEANS)


def _methods(c: Calibration) -> pd.DataFrame:
    """What a reader of the numbers has to know; a paragraph for a paper first."""
    rows: list[tuple[str, str, object]] = [(tr("in words"), "", in_words(c))]
    rows += [(key.replace("_", " "), "", tr(text)) for key, text in CONVENTIONS.items()]
    materials, _ = materials_and_shape(c.bench.seed, Parameters())
    for role, material in materials.items():
        for key, value in material.items():
            if isinstance(value, str | int | float):
                what = f"{role}: {key.replace('_', ' ')}"
                rows.append((what, UNITS.get(key, ""), value))
    rows += [(rig, "", tr("not calibrated: {}", why)) for rig, why in c.refused.items()]
    rows += [(tr("seed of the random numbers"), "1", c.seed)]
    rows += [(tr("version of {}", name), "", text) for name, text in versions().items()]
    return pd.DataFrame(rows, columns=METHODS)


def in_words(c: Calibration) -> str:
    """How the parameters were found and what they are, as a paper's methods state
    it."""
    read = [
        f"{words(o.name.split(': ')[1])} {o.bench.value:.4g} ± {o.bench.sd:.2g}"
        f" {draw.unit(o.name.rsplit('_', 1)[-1])} (n = {o.bench.n})"
        for o in _observables(c)
    ]
    found = [
        f"{draw.name(r.parameter)} {with_interval(r.value, r.low, r.high)},"
        f" {in_status(r.status, words(r.remark))}"
        for r in parameters(c).itertuples()
    ]
    by = tr("printed simulations") if c.mode == "tables" else tr(SIMULATED)
    return tr(
        "Contact parameters were calibrated with benchtwin {}: means over repeats ±"
        " their standard deviation ({}) were matched by {}. Medians with intervals that"
        " hold the value with probability {:.0%}, given the model: {}. Rolling friction"
        " is in EDEM's standard convention (torque = μ_r × normal force × distance from"
        " the centroid to the contact).",
        versions()["benchtwin"],
        "; ".join(read),
        by,
        LEVEL,
        "; ".join(found),
    )
