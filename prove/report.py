"""Writes the results of a proof: prove.json, cases.csv, and one self-contained
report.html with its figures: power curves, confusion, reliability, calibration."""

import json
import math
from dataclasses import asdict
from pathlib import Path

import numpy as np
import pandas as pd
from jinja2 import Environment, PackageLoader, StrictUndefined
from plotly.graph_objects import Figure
from plotly.offline import get_plotlyjs
from scipy.special import logit, ndtri

from benchtwin.prove.files import write_whole
from benchtwin.prove.judge import Judged, cases_table
from benchtwin.prove.rigs import RIGS
from benchtwin.prove.score import (
    FALSE_ALARM,
    GRID,
    Row,
    binomial_interval,
    confusion,
    power,
    reliability,
)


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


BLACK, GREY, RIGHT, WRONG = "#1b1f24", "#6b7280", "#2e7d4f", "#b3261e"
COLOURS = {"all": BLACK} | {name: rig.colour for name, rig in RIGS.items()}
BINS = (0.0, 2.5, 4.0, 5.5, 7.5, 12.0, 20.0, math.inf)
# ticks of the reliability diagram, on a scale of ln p/(1 − p)
ODDS = (0.05, 0.25, 0.5, 0.75, 0.9, 0.97, 0.99, 0.997)
LEAST_P, MOST_P = 0.02, 0.9985
# SNR at these powers of a two-sided test of a known law among EFFECTS others
EFFECTS = 12
LEAST_SNR = float(ndtri(1 - FALSE_ALARM / EFFECTS / 2))
THEORY = {p: LEAST_SNR + float(ndtri(p)) for p in (0.5, 0.9)}
DOTTED = {"color": GREY, "dash": "dot"}


def power_figure(judged: list[Judged], rng: np.random.Generator) -> Figure:
    """Share of alarms against SNR: fitted curves, shares by bins with their intervals,
    and the theory's two points."""
    figure = _figure("SNR of the concealed effect", "share of alarms")
    for rig, colour in COLOURS.items():
        curve = power([j for j in judged if rig in ("all", j.key.rig)], rng)
        if math.isfinite(curve.snr50):
            line = {"color": colour, "width": 3 if rig == "all" else 1.5}
            figure.add_scatter(
                x=GRID, y=curve.at(GRID), mode="lines", name=rig, line=line
            )
    binned = _binned(judged)
    figure.add_scatter(
        x=binned.snr,
        y=binned.share,
        error_y=_bars(binned.share, binned.low, binned.high),
        text=binned.counted,
        mode="markers",
        name="all, binned (95 %)",
        marker={"color": BLACK, "size": 8},
    )
    figure.add_scatter(
        x=[*THEORY.values()],
        y=[*THEORY],
        mode="markers",
        name="limit by theory",
        marker={"symbol": "x", "color": GREY, "size": 11},
    )
    figure.update_xaxes(type="log")
    return figure.update_yaxes(range=[-0.02, 1.02], tickformat=".0%")


def _binned(judged: list[Judged]) -> pd.DataFrame:
    """Of each bin of SNR: its geometric mean, share of alarms with its interval."""
    cases = cases_table([j for j in judged if len(j.key.effects) == 1])
    bins = pd.cut(cases.snr, BINS, right=False)
    rows = []
    for _, group in cases.groupby(bins, observed=True):
        k, n = int(group.alarm.sum()), len(group)
        mean = np.exp(np.log(group.snr.clip(0.3)).mean())
        rows.append((mean, k / n, *binomial_interval(k, n), f"{k} of {n}"))
    return pd.DataFrame(rows, columns=["snr", "share", "low", "high", "counted"])


def confusion_figure(judged: list[Judged]) -> Figure:
    """Confusion matrix: concealed effects (rows), diagnoses (columns), as shares of
    each row with the counts written in."""
    counts = confusion(judged)
    figure = _figure("", "", height=180 + 22 * len(counts))
    figure.add_heatmap(
        x=counts.columns,
        y=counts.index,
        z=counts.div(counts.sum(axis=1), axis=0),
        text=counts.astype(str).replace("0", ""),
        texttemplate="%{text}",
        colorscale=[[0, "#ffffff"], [1, "#1f5fa8"]],
        showscale=False,
        **{"zmin": 0, "zmax": 1, "xgap": 1, "ygap": 1},
    )
    figure.update_xaxes(tickangle=-50, automargin=True)
    return figure.update_yaxes(autorange="reversed", automargin=True)


def reliability_figure(judged: list[Judged]) -> Figure:
    """Share of right verdicts with 95 % bounds against their mean stated probability,
    by bins."""
    bins, figure = reliability(cases_table(judged)), _figure("said", "share right")
    ends, share = _odds([0.0, 1.0]), _odds(bins.share)
    figure.add_scatter(x=ends, y=ends, mode="lines", name="as said", line=DOTTED)
    figure.add_scatter(
        x=_odds(bins.mean_p),
        y=share,
        error_y=_bars(share, _odds(bins.low95), _odds(bins.high95)),
        mode="markers+text",
        name="right, 95 %",
        text=[f"{k} of {n}" for k, n in zip(bins.right, bins.n)],
        textposition="bottom right",
        marker={"color": np.where(bins.holds, RIGHT, WRONG), "size": 10},
    )
    said = [f"{100 * p:g} %" for p in ODDS]
    ticks = {"tickvals": _odds(ODDS), "ticktext": said, "range": ends}
    return figure.update_xaxes(**ticks).update_yaxes(**ticks)


def _odds(p) -> np.ndarray:
    """ln p/(1 − p), within the diagram."""
    return logit(np.clip(np.asarray(p, float), LEAST_P, MOST_P))


def calibration_figure(judged: list[Judged]) -> Figure:
    """(SNR, stated / true, interval / true) of every right name, by rig: 1 is right,
    bars are 95 % intervals."""
    figure = _figure("SNR", "stated / true")
    for rig in RIGS:
        points = [point for j in judged if j.key.rig == rig for point in j.stated]
        found = pd.DataFrame(points, columns=["snr", "value", "low", "high"])
        figure.add_scatter(
            x=found.snr,
            y=found.value,
            error_y=_bars(found.value, found.low, found.high, thickness=1),
            mode="markers",
            name=rig,
            marker={"color": COLOURS[rig], "size": 6},
        )
    figure.add_hline(1, line=DOTTED)
    figure.update_xaxes(type="log")
    return figure.update_yaxes(range=[0, 2])


def _bars(value, low, high, thickness: float = 2) -> dict:
    """Error bars from low to high."""
    bars = {"type": "data", "symmetric": False, "thickness": thickness}
    return bars | {"array": high - value, "arrayminus": value - low}


def _figure(x: str, y: str, height: int = 420) -> Figure:
    return Figure(
        layout={
            "template": "none",
            "margin": {"l": 60, "r": 15, "t": 10, "b": 50},
            "height": height,
            "legend": {"orientation": "h", "y": -0.25},
            "xaxis": {"title": {"text": x}},
            "yaxis": {"title": {"text": y}},
        }
    )
