"""The report of a calibration: words, tables and figures, filled into page.html.j2."""

from itertools import combinations
from pathlib import Path

import pandas as pd

from benchtwin.bench.numbers import with_interval
from benchtwin.calibrate.procedure.calibration import Calibration, parameters
from benchtwin.calibrate.procedure.next_tests import in_words
from benchtwin.calibrate.procedure.pile import PileFit
from benchtwin.calibrate.procedure.shape_effect import verdict
from benchtwin.calibrate.statistics.assessment import natural_coefficients
from benchtwin.report import draw, figures, pile_figures, side_by_side
from benchtwin.report.numbers import cells, sentence
from benchtwin.report.template import fill, write_page


def write_report(c: Calibration, out: Path) -> None:
    """report.html in the folder `out`. OSError when it cannot be written."""
    write_page(out, render(c))


def render(c: Calibration) -> str:
    """The whole page as text."""
    return fill(
        "page.html.j2",
        _figures(c),
        {"cells": cells, "word": draw.name, "sentence": sentence},
        c=c,
        answer=_answer(c),
        pile=_pile(c.pile) if c.pile else None,
        checks={"wrong": c.not_following, "all": c.checks},
        rigs=_rigs(c),
        shape=verdict(c.more["shape_effect"]) if "shape_effect" in c.more else [],
        pairs=side_by_side.panels(c.more.get("pairs", [])),
    )


def _answer(c: Calibration) -> dict:
    """What the page opens with."""
    rows = [
        {
            "name": draw.name(r.parameter),
            "value": with_interval(r.value, r.low, r.high),
            "status": r.status,
            "source": r.source,
            "budget": [
                (k, f"{100 * v:.0f} %") for k, v in r.budget.items() if v >= 0.005
            ],
            "open": r.status != "calibrated",
        }
        for r in parameters(c).itertuples()
    ]
    notes = (
        [c.pile.optimum.statement, c.pile.sheet.statement] if c.pile is not None else []
    )
    if c.joint is not None and len(c.joint.directions):
        notes += list(
            c.joint.directions.loc[~c.joint.directions["resolved"], "statement"]
        )
    notes = [sentence(text) for text in notes]
    if c.joint is not None:
        notes += [sentence(text) for text in in_words(c.joint.next_tests)]
    return {"rows": rows, "notes": notes}


def _rigs(c: Calibration) -> list[dict]:
    """One section a seed–steel rig."""
    return [
        {
            "key": n,
            "unit": draw.unit(fit.rig.unit),
            "fit": fit,
            "equation": _equation(fit.polynomial.coefficients),
            "answers": fit.answers,
            "readings": c.bench.rigs[n],
            "value": with_interval(
                fit.inverse.value, fit.inverse.low, fit.inverse.high
            ),
        }
        for n, fit in c.steel.items()
    ]


def _equation(coefficients) -> str:
    """ "y = 2 x² − 3 x +1" of coefficients, the highest power's first."""
    powers = ("", " x", " x²", " x³")[: len(coefficients)][::-1]
    terms = [f"{v:+.5g}{power}" for v, power in zip(coefficients, powers)]
    return "y = " + " ".join(terms).removeprefix("+").replace("-", "−")


def _pile(p: PileFit) -> dict:
    natural = (
        natural_coefficients(p.surface)
        .rename_axis("term")
        .reset_index(name="natural units")
    )
    quality = {
        "R²": p.quality.r2,
        "adjusted R²": p.quality.r2_adjusted,
        "predicted R²": p.quality.r2_predicted,
        "PRESS": p.quality.press,
        "adequate precision": p.quality.adequate_precision,
        "sd (°)": p.quality.sd,
        "C.V. (%)": p.quality.cv_percent,
    }
    return {
        "fit": p,
        "coefficients": p.coefficients.merge(natural, on="term", how="left"),
        "quality": pd.DataFrame(quality.items(), columns=["measure", "value"]),
        "letters": {letter: draw.name(n) for letter, n in zip("ABCDEFG", p.box.names)},
        "pairs": [(f"{a}-{b}", a, b) for a, b in combinations(p.box.names, 2)],
        "left_out": ", ".join(p.reduction.steps["term"]),
    }


def _figures(c: Calibration) -> dict[str, dict]:
    out = {f"steel-{n}": figures.steel(fit) for n, fit in c.steel.items()}
    out |= {f"pair-{p.rig}": side_by_side.figure(p) for p in c.more.get("pairs", [])}
    if c.pile is not None:
        if c.pile.path is not None:
            out["path"] = pile_figures.path(c.pile)
        for a, b in combinations(c.pile.box.names, 2):
            out[f"surface-{a}-{b}"] = pile_figures.surface(c.pile, a, b)
            out[f"contour-{a}-{b}"] = pile_figures.contour(c.pile, a, b)
        out["residuals"] = pile_figures.residuals(c.pile)
        if (drawn := pile_figures.sheet(c.pile)) is not None:
            out["sheet"] = drawn
    if c.joint is not None:
        marks = dict(zip(c.joint.table["factor"], c.joint.table["sequential"]))
        names = [
            n
            for n in c.joint.table["factor"]
            if c.pile is None or n in c.pile.box.names
        ]
        out["posterior"] = figures.posterior(c.joint, names, marks)
    return out
