"""The page of a diagnosis: a verdict a rig, then what it rests on, filled into diagnosis.html.j2."""

import base64
import json
import math
from importlib.resources import files
from pathlib import Path

import pandas as pd

from calibrate.diagnose import words
from calibrate.diagnose.bench import Diagnosis
from calibrate.diagnose.finding import Finding
from calibrate.report.numbers import cells
from calibrate.report.residuals import before_and_after, points, recorded
from calibrate.twin.versions import versions

TAGS = {"none": "nothing missing", "name": "found", "class": "not told apart", "unknown": "unknown"}
MOST_CANDIDATES = 12


def write_report(found: Diagnosis, out: Path) -> Path:
    """report.html in the folder `out`; appears whole. OSError when it cannot be written."""
    file, part = out / "report.html", out / ".report.html.part"
    part.write_text(render(found), encoding="utf8")
    part.replace(file)
    return file


def render(found: Diagnosis) -> str:
    """The whole page of a `calibrate.diagnose.bench.Diagnosis` as text."""
    from jinja2 import Environment, StrictUndefined
    from plotly.offline import get_plotlyjs

    environment = Environment(autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True)
    environment.filters |= {"cells": _cells, "sentence": _sentence}
    template = environment.from_string((files("calibrate.report") / "diagnosis.html.j2").read_text(encoding="utf8"))
    drawn = {k: v for rig, f in found.findings.items() for k, v in _figures(rig, f).items()}
    drawn |= {f"{rig}-twins": points(again.figure) for rig, again in found.twins.items() if again.figure}
    # "</" would end the script element that carries the figures
    text = json.dumps(drawn, separators=(",", ":"), allow_nan=False).replace("</", "<\\/")
    rigs = [_rig(rig, finding, found.twins.get(rig)) for rig, finding in found.findings.items()]
    return template.render(d=found, rigs=rigs, figures=sorted(drawn), drawn=text, plotly=get_plotlyjs(), versions=versions())


def _sentence(text: str) -> str:
    """A capital first letter and a full stop; unlike a calibration's, "restitution" here is nobody's column."""
    text = text.strip()
    return text[:1].upper() + text[1:] + ("" if text.endswith((".", "?")) else ".")


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
    return {
        "key": rig, "finding": f, "verdict": words.verdict_in_words(f), "tag": TAGS[f.verdict], "where": _where(f),
        "sure": _sure(f),
        "parameters": _parameters(f), "sectors": _sectors(f), "evidence": _evidence(f), "held_out": _held_out(f),
        "quantities": quantities(f), "model": _model(f), "again": again, "rows": pd.DataFrame(again.rows) if again else None,
        "picture": base64.b64encode(again.picture).decode() if again and again.picture else "",
    }  # fmt: skip


def _where(f: Finding) -> str:
    """ "in flight (97 % of the mismatch), most at speed 1.8 to 2.3 m/s; best told by height"."""
    if f.verdict == "none":
        return ""
    best = next((s for s in f.sectors if math.isfinite(s.explained) and s.explained > 0), None)
    out = words.place(f) + (f", which explains {100 * best.explained:.0f} % of the mismatch ({_p(best.p)})" if best else "")
    if window := words.window_in_words(f):
        out += f"; most at {window}"
    if f.collapse:
        out += f"; what is missing follows {words.AXES.get(f.collapse, (f.collapse, ''))[0]} best"
    return out


def _sure(f: Finding) -> str:
    """Evidence in words."""
    if f.verdict == "none":
        return f"a mismatch as great arises by chance with {_p(f.p_global)}; an alarm needs p < 0.005"
    out = f"a mismatch as great arises by chance with {_p(f.p_global)}"
    if math.isfinite(f.ln_bayes_baseline):
        out += f"; ln Bayes factor {f.ln_bayes_baseline:.1f} over the baseline (5 is needed)"
    if math.isfinite(f.ln_bayes_runner_up):
        out += f", {f.ln_bayes_runner_up:.1f} over the next best explanation (3 is needed)"
    return out


def _p(p: float) -> str:
    return "p < 0.0001" if p < 1e-4 else f"p = {p:.2g}"


def _parameters(f: Finding) -> pd.DataFrame | None:
    rows = [
        {"effect": n, "value ± 95 %": words.plus_minus(p), "low": p.low95, "high": p.high95, "unit": p.unit}
        for n, p in f.parameters.items()
    ]
    return pd.DataFrame(rows) if rows else None


def _sectors(f: Finding) -> pd.DataFrame:
    rows = [{"sector": s.name, "explains": f"{100 * s.explained:.0f} %" if math.isfinite(s.explained) else "–", "p": s.p}
            for s in f.sectors]  # fmt: skip
    return pd.DataFrame(rows)


def _evidence(f: Finding) -> pd.DataFrame | None:
    """Candidates, best first."""
    rows = []
    for c in f.candidates[:MOST_CANDIDATES]:
        values = ", ".join(f"{v:.3g} ± {1.96 * sd:.2g}" for v, sd in zip(c.value, c.sd, strict=True))
        gain = f"{c.gain:.3g} ± {c.gain_se:.2g}" if math.isfinite(c.gain) else "–"
        rows.append({
            "explanation": " + ".join(c.names), "value ± 95 %": values, "ln Bayes": c.ln_bayes, "gain a recording": gain,
            "same sign": f"{100 * c.same_sign:.0f} %", "p of the rest": c.left_p, "against it": "; ".join(c.flaws) or "nothing",
        })  # fmt: skip
    return pd.DataFrame(rows) if rows else None


def _held_out(f: Finding) -> str:
    h = f.held_out
    if h is None:
        return "" if f.verdict == "none" else "one recording only: nothing could be held out"
    if not math.isfinite(h.removed_fraction):
        return f"each recording predicted from the others: the baseline misses nothing beyond noise (× {h.rmse_ratio:.3f})"
    removed = 100 * min(h.removed_fraction, 1.0)
    return (
        f"each recording predicted from the others: {removed:.0f} % of what the baseline misses is removed "
        f"(residuals, noise included, × {h.rmse_ratio:.3f})"
    )


def _model(f: Finding) -> str:
    """What the "after" curves have in them."""
    if f.left_out:
        return " and ".join(f.modelled)
    return "" if f.verdict == "none" else "nothing"


def quantities(f: Finding) -> list[tuple[str, str]]:
    """(key, quantity) of the curves, the one that the model mends most first."""
    gain: dict[str, float] = {}
    for c in f.curves:
        gain[c.quantity] = gain.get(c.quantity, 0.0) + float((c.left_by_baseline**2).sum() - (c.left_by_model**2).sum())
    return [(f"{i}", q) for i, q in enumerate(sorted(gain, key=gain.__getitem__, reverse=True))]


def _figures(rig: str, f: Finding) -> dict[str, dict]:
    out = {}
    for key, quantity in quantities(f):
        these = [c for c in f.curves if c.quantity == quantity]
        out[f"{rig}-left-{key}"] = before_and_after(these, _model(f))
        out[f"{rig}-seen-{key}"] = recorded(these)
    return out
