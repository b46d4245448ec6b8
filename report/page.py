"""The report of a calibration: words, tables and figures, filled into page.html.j2."""

import json
from importlib.resources import files
from itertools import combinations
from pathlib import Path

import pandas as pd

from calibrate.procedure.calibration import Calibration, parameters
from calibrate.procedure.pile import PileFit
from calibrate.procedure.shape_effect import verdict
from calibrate.statistics.assessment import natural_coefficients
from report import draw, figures, pile_figures, side_by_side
from report.numbers import cells, sentence, with_interval
from twin.versions import versions


def write_report(c: Calibration, out: Path) -> Path:
    """report.html in the folder `out`; appears whole. OSError when it cannot be written."""
    file = out / "report.html"
    part = out / ".report.html.part"
    part.write_text(render(c), encoding="utf8")
    part.replace(file)
    return file


def render(c: Calibration) -> str:
    """The whole page as text."""
    from jinja2 import Environment, StrictUndefined

    environment = Environment(autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True)
    environment.filters |= {"cells": cells, "word": draw.name, "sentence": sentence}
    template = environment.from_string((files("report") / "page.html.j2").read_text(encoding="utf8"))
    drawn = _figures(c)
    # "</" would end the script element that carries the figures
    text = json.dumps(drawn, separators=(",", ":"), allow_nan=False).replace("</", "<\\/")
    return template.render(
        c=c,
        answer=_answer(c),
        pile=_pile(c.pile) if c.pile else None,
        figures=sorted(drawn),
        drawn=text,
        plotly=_plotly(),
        versions=versions(),
        checks=_checks(c.checks),
        rigs=_rigs(c),
        shape=verdict(c.more["shape_effect"]) if "shape_effect" in c.more else [],
        pairs=side_by_side.panels(c.more.get("pairs", [])),
    )


def _plotly() -> str:
    from plotly.offline import get_plotlyjs

    return get_plotlyjs()


def _answer(c: Calibration) -> dict:
    """What the page opens with."""
    rows = [
        {
            "name": draw.name(r.parameter),
            "value": with_interval(r.value, r.low, r.high),
            "status": r.status,
            "source": r.source,
            "budget": [(k, f"{100 * v:.0f} %") for k, v in r.budget.items() if v >= 0.005],
            "open": r.status != "calibrated",
        }
        for r in parameters(c).itertuples()
    ]
    notes = []
    if c.pile is not None:
        notes.append(sentence(c.pile.optimum.statement))
        notes.append(sentence(c.pile.sheet.statement))
    if c.joint is not None and len(c.joint.directions):
        notes += [sentence(s) for s in c.joint.directions.loc[~c.joint.directions["resolved"], "statement"]]
    following = c.joint.narrowing.iloc[0] if c.joint is not None and len(c.joint.narrowing) else None
    if following is not None:
        notes.append(
            f"What would narrow them most: {following['candidate']}; it would leave {100 * following['variance_left']:.0f} % of the "
            "variance of the three seed–seed parameters."
        )
    return {"rows": rows, "notes": notes}


def _rigs(c: Calibration) -> list[dict]:
    """One section a seed–steel rig."""
    out = []
    for n, fit in c.steel.items():
        powers = range(fit.polynomial.coefficients.size - 1, -1, -1)
        terms = [
            f"{v:+.5g}" + ("" if p == 0 else " x" if p == 1 else f" x{'²³'[p - 2]}")
            for v, p in zip(fit.polynomial.coefficients, powers)
        ]
        equation = "y = " + " ".join(terms).removeprefix("+")
        out.append(
            {
                "key": n,
                "unit": draw.unit(fit.rig.unit),
                "fit": fit,
                "equation": equation.replace("-", "−"),
                "answers": fit.answers,
                "readings": c.bench.rigs[n],
                "value": with_interval(fit.inverse.value, fit.inverse.low, fit.inverse.high),
            }
        )
    return out


def _pile(p: PileFit) -> dict:
    natural = natural_coefficients(p.surface).rename_axis("term").reset_index(name="natural units")
    coded = p.coefficients.merge(natural, on="term", how="left")
    quality = pd.DataFrame(
        [
            ("R²", p.quality.r2),
            ("adjusted R²", p.quality.r2_adjusted),
            ("predicted R²", p.quality.r2_predicted),
            ("PRESS", p.quality.press),
            ("adequate precision", p.quality.adequate_precision),
            ("sd (°)", p.quality.sd),
            ("C.V. (%)", p.quality.cv_percent),
        ],
        columns=["measure", "value"],
    )
    names = dict(zip("ABCDEFG", p.box.names))
    return {
        "fit": p,
        "coefficients": coded,
        "quality": quality,
        "letters": {k: draw.name(v) for k, v in names.items()},
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
        names = [n for n in c.joint.table["factor"] if c.pile is None or n in c.pile.box.names]
        out["posterior"] = figures.posterior(c.joint, names, marks)
    return out


def _checks(checks: pd.DataFrame) -> dict:
    """Printed values: those that do not follow, and all."""
    return {"wrong": checks[~checks["follows"].astype(bool)] if len(checks) else checks, "all": checks}
