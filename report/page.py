"""The report of a calibration: words, tables and figures, filled into page.html.j2."""

from itertools import combinations

from benchtwin.bench.language import tr
from benchtwin.bench.numbers import beside_interval, with_interval
from benchtwin.calibrate.procedure.calibration import (
    CALIBRATED,
    Calibration,
    advice,
    parameters,
)
from benchtwin.calibrate.procedure.rigs import SEED_FACTORS
from benchtwin.calibrate.procedure.shape_effect import verdict
from benchtwin.calibrate.procedure.steel import SteelFit
from benchtwin.calibrate.procedure.surface import SurfaceFit
from benchtwin.calibrate.procedure.words import in_status, ties_in_words
from benchtwin.calibrate.result_file import CONVENTIONS
from benchtwin.report import draw, figures
from benchtwin.report.numbers import cells, sentence
from benchtwin.report.template import fill


def render(c: Calibration) -> str:
    """The whole page as text."""
    return fill(
        "page.html.j2",
        _figures(c),
        {"cells": cells, "word": draw.name, "sentence": sentence},
        c=c,
        answer=_answer(c),
        surface=_surface(c.surface) if c.surface else None,
        conventions=CONVENTIONS,
        checks={"wrong": c.not_following, "all": c.checks},
        rigs=[
            {
                "key": n,
                "unit": draw.unit(fit.rig.unit),
                "fit": fit,
                "curve": _equation(fit) if c.mode == "tables" else "",
                "readings": c.bench.rigs[n],
            }
            for n, fit in c.steel.items()
        ],
        shape=verdict(c.more["shape_effect"]) if "shape_effect" in c.more else [],
        pairs=figures.panels(c.more.get("pairs", [])),
    )


def _answer(c: Calibration) -> dict:
    """What the page opens with."""
    rows = [
        {
            "name": draw.name(r.parameter),
            "value": with_interval(r.value, r.low, r.high),
            "status": in_status(r.status, r.remark),
            "together": beside_interval(r.most_probable_set, r.low, r.high),
            "source": r.source,
            "budget": [
                (k, f"{100 * v:.0f} %") for k, v in r.budget.items() if v >= 0.005
            ],
            "open": r.status != CALIBRATED,
        }
        for r in parameters(c).itertuples()
    ]
    if c.joint is None:
        return {"rows": rows, "notes": []}
    notes = [*ties_in_words(c.joint.ties), *advice(c)]
    return {"rows": rows, "notes": [sentence(text) for text in notes]}


def _equation(fit: SteelFit) -> str:
    """A publication's curve, "Eq. 5: y = 2 x² − 3 x +1, R² 0.9987; it gives …"."""
    curve = fit.equation
    powers = ("", " x", " x²", " x³")[: len(curve.coefficients)][::-1]
    terms = [f"{v:+.5g}{power}" for v, power in zip(curve.coefficients, powers)]
    law = " ".join(terms).removeprefix("+").replace("-", "−")
    return tr(
        "{}: y = {}, R² {:.4f}; it gives the bench's mean at {:.4g}.",
        fit.rig.equation,
        law,
        curve.r2,
        curve.at(fit.bench.value),
    )


def _surface(s: SurfaceFit) -> dict:
    """The steps of a publication."""
    return {
        "fit": s,
        "letters": {letter: draw.name(n) for letter, n in zip("ABCDEFG", s.box.names)},
        "pairs": [(f"{a}-{b}", a, b) for a, b in combinations(s.box.names, 2)],
    }


def _figures(c: Calibration) -> dict[str, dict]:
    out = {f"steel-{n}": figures.steel(fit) for n, fit in c.steel.items()}
    out |= {f"pair-{p.rig}": figures.side_by_side(p) for p in c.more.get("pairs", [])}
    if (s := c.surface) is not None:
        if s.path is not None:
            out["path"] = figures.path(s)
        for a, b in combinations(s.box.names, 2):
            out[f"contour-{a}-{b}"] = figures.contour(s, a, b)
        out["residuals"] = figures.residuals(s)
    if c.joint is not None:
        table = parameters(c)
        seeds = table[table["parameter"].isin(SEED_FACTORS)]
        out["posterior"] = figures.posterior(
            c.joint.posterior.draws, seeds if len(seeds) else table
        )
    return out
