"""Writes the results of a proof: prove.json, cases.csv, and one self-contained
report.html."""

import json
import math
from dataclasses import asdict
from pathlib import Path

import numpy as np
from jinja2 import Environment, PackageLoader, StrictUndefined
from plotly.offline import get_plotlyjs

from benchtwin.prove.figures import (
    calibration_figure,
    confusion_figure,
    power_figure,
    reliability_figure,
)
from benchtwin.prove.files import write_whole
from benchtwin.prove.intervals import reliability
from benchtwin.prove.judge import Judged, cases_table
from benchtwin.prove.score import Row


def write_all(out: Path, judged: list[Judged], rows: list[Row], seed: int) -> None:
    """All three files, each whole. OSError when they cannot be written."""
    content = {
        "schema": 1,
        "cases": len(judged),
        "rng": seed,
        "scores": [_plain(row) for row in rows],
        "reliability": reliability(cases_table(judged)).to_dict("records"),
    }
    write_whole(
        out / "prove.json",
        json.dumps(content, indent=1, ensure_ascii=False, allow_nan=False),
    )
    cases = cases_table(judged).round({"snr": 2})
    write_whole(out / "cases.csv", cases.to_csv(index=False))
    write_whole(out / "report.html", render(judged, rows, seed))
    (out / "report.pdf").unlink(missing_ok=True)  # a print of an older one


def render(judged: list[Judged], rows: list[Row], seed: int) -> str:
    """The page as text."""
    rng = np.random.default_rng(seed)
    figures = {
        "power": power_figure(judged, rng),
        "confusion": confusion_figure(judged),
        "reliability": reliability_figure(judged),
        "calibration": calibration_figure(judged),
    }
    environment = Environment(
        loader=PackageLoader("benchtwin.prove", ""),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters["figure"] = number
    return environment.get_template("page.html.j2").render(
        rows=rows,
        rigs=list(dict.fromkeys(r.rig for r in rows)),
        judged=judged,
        missing=[j for j in judged if j.verdict == "missing"],
        drawn={
            name: figure.to_html(
                {"displaylogo": False}, include_plotlyjs=False, full_html=False
            )
            for name, figure in figures.items()
        },
        plotly=get_plotlyjs(),
        seed=seed,
        wrong=[
            j for j in judged if j.wrong_name or (j.key.kind == "clean" and j.alarm)
        ],
    )


def number(row: Row) -> str:
    """A score with its interval, as it is printed."""
    if not math.isfinite(row.value):
        return "–"
    if row.k is not None:
        return (
            f"{100 * row.value:.1f} % ({100 * row.low:.1f}–{100 * row.high:.1f});"
            f" {row.k} of {row.n}"
        )
    if math.isfinite(row.low) and math.isfinite(row.high):
        interval = f" ({row.low:.3g}–{row.high:.3g})"
    else:
        interval = ""
    return f"{row.value:.3g}{interval}; {row.n} cases"


def _plain(row: Row) -> dict:
    """The row without what JSON has no number for."""
    return {
        k: None if isinstance(v, float) and not math.isfinite(v) else v
        for k, v in asdict(row).items()
    }
