"""The report of a diagnosis: of each rig the verdict, then the evidence, filled into
diagnosis.html.j2."""

import base64
import math

import pandas as pd

from benchtwin.bench.language import tr
from benchtwin.bench.numbers import with_interval
from benchtwin.diagnose import words
from benchtwin.diagnose.bench import Diagnosis
from benchtwin.infer.alarm import ALARM_P
from benchtwin.infer.condition_table import FOUND_PROBABILITY
from benchtwin.infer.finding import Finding
from benchtwin.report.numbers import capitalised, cells
from benchtwin.report.residuals import (
    before_and_after,
    followed,
    points,
    recorded,
)
from benchtwin.report.template import fill

TAGS = {
    "sure": "nothing missing",
    "open": "nothing shown",
    "quiet": "moves nothing",
    "name": "found",
    "class": "not told apart",
    "unknown": "unknown",
}
MOST_EXPLANATIONS, MOST_EFFECTS = 10, 12


def render(found: Diagnosis) -> str:
    """The whole page of a `diagnose.bench.Diagnosis` as text."""
    drawn: dict[str, dict] = {}
    for rig, finding in found.findings.items():
        drawn |= _figures(rig, finding)
    for rig, again in found.twins.items():
        drawn |= {f"{rig}-twins": points(again.figure)} if again.figure else {}
    entries = found.findings.items()
    missing_first = sorted(entries, key=lambda entry: entry[1].verdict == "none")
    rigs = [_rig(rig, finding, found.twins.get(rig)) for rig, finding in missing_first]
    filters = {"cells": _cells, "sentence": capitalised}
    return fill("diagnosis.html.j2", drawn, filters, d=found, rigs=rigs)


def _cells(table: pd.DataFrame) -> dict:
    """`numbers.cells`, texts as they are."""
    out = cells(table)
    for k, column in enumerate(table.columns):
        for row, value in zip(out["rows"], table[column], strict=True):
            row[k] = value if isinstance(value, str) else row[k]
    out["heads"] = [str(c) for c in table.columns]
    return out


def _rig(rig: str, f: Finding, again) -> dict:
    """One section."""
    tone = words.tone(f)
    return {
        "key": rig,
        "finding": f,
        "verdict": words.verdict_in_words(f),
        "tag": tr(TAGS[tone]),
        "tone": tone,
        "where": _where(f),
        "sure": _sure(f),
        "explanations": _explanations(f),
        "effects": _effects(f),
        "contact": _contact(f),
        "sectors": _sectors(f),
        "held_out": _held_out(f),
        "follows": [
            f"{words.follow_in_words(follow, f)} ({words.chance(follow.p)})"
            for follow in f.follows
        ],
        "quantities": quantities(f),
        "model": _model(f),
        "again": again,
        "rows": _rows(again) if again else None,
        "picture": (
            base64.b64encode(again.picture).decode() if again and again.picture else ""
        ),
    }


def _rows(again) -> pd.DataFrame:
    """How far old and new twin are from each recording."""
    return pd.DataFrame(
        [
            {
                tr("recording"): c.recording,
                tr("what"): c.quantity,
                tr("old twin off by"): c.before,
                tr("new twin off by"): c.after,
                tr("unit"): "" if c.unit == "1" else c.unit,
                tr("measured on"): c.by,
            }
            for c in again.compared
        ]
    )


def _where(f: Finding) -> str:
    """ "in flight (97 % of the mismatch), most at speed 1.8 to 2.3 m/s; best told by
    height"."""
    if f.verdict == "none":
        return ""
    out = words.place(f)
    if best := next((s for s in f.sectors if s.explained > 0), None):
        share = tr("{:.0f} % of the mismatch", 100 * best.explained)
        out += tr(", which explains {} ({})", share, words.chance(best.p))
    if window := words.window(f):
        out += tr("; most at {}", window)
    if f.best_axis:
        axis, _ = words.AXES.get(f.best_axis, (f.best_axis, ""))
        out += tr("; what is missing follows {} best", tr(axis))
    return out


def _sure(f: Finding) -> str:
    """What p is, and what an alarm takes."""
    return tr(
        "noise alone makes as great a mismatch in {} ({}); an alarm needs p < {}, or a"
        " condition that is followed with a probability of {}",
        words.odds(f.p_global),
        words.chance(f.p_global),
        ALARM_P,
        words.percent(FOUND_PROBABILITY),
    )


def _explanations(f: Finding) -> pd.DataFrame | None:
    """The most probable first."""
    rows = [
        {
            tr("what is missing"): "; ".join(words.missing(n, f.rig) for n in names)
            or tr("nothing"),
            tr("probability"): words.percent(p),
        }
        for names, p in f.explanations[:MOST_EXPLANATIONS]
    ]
    return pd.DataFrame(rows) if rows else None


def _effects(f: Finding) -> pd.DataFrame | None:
    """Effects with their probability, and their size where they are there."""
    rows = [
        {
            tr("what may be missing"): (
                tr(f.laws[n].wording[0]) if n in f.laws else words.missing(n, f.rig)
            ),
            tr("probability"): words.percent(t.probability),
            tr("size, if there (95 %)"): _interval(t.size),
            tr("unit"): {"1": "", "deg": "°"}.get(t.unit, t.unit),
            tr("in diagnosis.json"): n,
        }
        for n, t in sorted(f.effects.items(), key=lambda entry: -entry[1].probability)[
            :MOST_EFFECTS
        ]
    ]
    return pd.DataFrame(rows) if rows else None


def _interval(size) -> str:
    return with_interval(*vars(size).values()) if math.isfinite(size.value) else "–"


def _contact(f: Finding) -> pd.DataFrame | None:
    """Contact parameters with nothing missing and averaged over all explanations."""
    rows = [
        {
            tr("parameter"): name.replace("_", " "),
            tr("with nothing missing"): _interval(m.nothing_missing),
            tr("averaged over all explanations"): _interval(m.explained),
            tr("moved by"): tr("{} of its sds", words.brief(abs(m.shift_sds))),
        }
        for name, m in f.contact.items()
    ]
    return pd.DataFrame(rows) if rows else None


def _sectors(f: Finding) -> pd.DataFrame:
    shares = [s.explained for s in f.sectors]
    explains = [f"{100 * v:.0f} %" if math.isfinite(v) else "–" for v in shares]
    names = [s.name for s in f.sectors]
    return pd.DataFrame(
        {tr("sector"): names, tr("explains"): explains, "p": [s.p for s in f.sectors]}
    )


def _held_out(f: Finding) -> str:
    h = f.held_out
    if h is None:
        if f.verdict == "none":
            return ""
        return tr("one recording only: nothing could be held out")
    if not math.isfinite(h.removed_fraction):
        return tr(
            "each recording predicted from the others: without what was found nothing"
            " is left but noise; with it residuals are {:.3f} times as large",
            h.rmse_ratio,
        )
    removed = 100 * min(h.removed_fraction, 1.0)
    return tr(
        "each recording predicted from the others: what was found explains {:.0f} % of"
        " what is left beyond noise without it; with it residuals, noise included, are"
        " {:.3f} times as large",
        removed,
        h.rmse_ratio,
    )


def _model(f: Finding) -> str:
    """What the "after" curves have in them."""
    if f.left_out:
        return tr(" and ").join(f.modelled)
    return ""


def quantities(f: Finding) -> list[tuple[str, str]]:
    """(key, quantity) of the curves, the one that the model mends most first."""
    gain: dict[str, float] = {}
    for c in f.curves:
        more = float((c.left_by_baseline**2).sum() - (c.left_by_model**2).sum())
        gain[c.quantity] = gain.get(c.quantity, 0.0) + more
    ordered = sorted(gain, key=gain.__getitem__, reverse=True)
    return [(f"{i}", q) for i, q in enumerate(ordered)]


def _figures(rig: str, f: Finding) -> dict[str, dict]:
    out = {}
    for k, follow in enumerate(f.follows):
        told = f.contact.get(follow.parameter)
        level = told.explained.value if told else 0.0
        out[f"{rig}-follows-{k}"] = followed(follow, level)
    for key, quantity in quantities(f):
        these = [c for c in f.curves if c.quantity == quantity]
        out[f"{rig}-left-{key}"] = before_and_after(these, _model(f))
        out[f"{rig}-seen-{key}"] = recorded(these)
    return out
