"""What a calibration leaves in its folder: result.json, and every table as CSV. Each
file appears whole or not at all."""

import json
from dataclasses import asdict
from pathlib import Path

import numpy as np
import pandas as pd

from benchtwin.bench.outlets import csv_text
from benchtwin.bench.whole_file import write_whole
from benchtwin.calibrate.procedure.calibration import Calibration, parameters
from benchtwin.calibrate.procedure.pile import PileFit
from benchtwin.calibrate.procedure.rigs import PILE
from benchtwin.calibrate.procedure.steel import SteelFit
from benchtwin.twin import Parameters
from benchtwin.twin.pair import Pair
from benchtwin.twin.result_sections import materials_and_shape
from benchtwin.twin.versions import versions

SCHEMA = 1
CURVE_POINTS = 101  # of a curve as it is drawn: no corners at the width of a page
CONVENTIONS = {
    "rolling": "edem",
    "rolling_means": (
        "torque = μ_r × normal force × own centroid-to-contact distance, against each "
        "body's own spin (EDEM standard)"
    ),
    "restitution": "normal speed after over before impact, at any speed",
    "static_friction": "Coulomb: largest tangential over normal force",
    "repose_angle": (
        "least-squares line through the outline between 20 and 80 % of the crest's"
        " height, against the horizontal"
    ),
    "centroid_angle": (
        "atan(z̄ / x̄) of what stands above a tenth of the crest's height, x̄ from the"
        " wall or the heap's axis"
    ),
    "interval": "low to high holds the value with probability `level`, given the model",
}


def write_result(c: Calibration, out: Path) -> None:
    """result.json and tables/ into `out`. OSError when it cannot be written."""
    tables = out / "tables"
    tables.mkdir(parents=True, exist_ok=True)
    for name, table in all_tables(c).items():
        text = csv_text(table, "%.9g")
        write_whole(tables / f"{name}.csv", text)
    shown = {"pairs": [_beside(p, out) for p in c.more.get("pairs", [])]}
    plain = _plain(content(c) | shown)
    text = json.dumps(plain, indent=1, ensure_ascii=False, allow_nan=False)
    write_whole(out / "result.json", text)


def _beside(p: Pair, out: Path) -> dict:
    """Which recording is shown beside which run of the twin, as a folder below
    `out`."""
    at, inside = p.folder.resolve(), p.folder.resolve().is_relative_to(out.resolve())
    twin = (at.relative_to(out.resolve()) if inside else p.folder).as_posix()
    alike = "crest" not in p.x_name
    return {"rig": p.rig, "recording": p.recording, "alike": alike, "twin": twin}


def content(c: Calibration) -> dict:
    """result.json as plain values."""
    materials, shape = materials_and_shape(c.bench.seed, Parameters())
    found = {row.pop("parameter"): row for row in parameters(c).to_dict("records")}
    fits: dict[str, SteelFit | PileFit] = {**c.steel}
    fits |= {PILE.name: c.pile} if c.pile else {}
    checked = {n: f.verification for n, f in fits.items() if f.verification}
    return {
        "schema": SCHEMA,
        "mode": c.mode,
        "parameters": found,
        "conventions": CONVENTIONS,
        "materials": materials,
        "seed_shape": shape,
        "bench": {
            "folder": str(c.bench.folder),
            "provenance": list(c.bench.provenance),
            "means": {n: asdict(f.bench) | {"sd": f.bench.sd} for n, f in fits.items()},
            "sha256": c.bench.hashes,
            "described": c.bench.seed,
        },
        "verification": {n: asdict(v) for n, v in checked.items()},
        PILE.name: _pile(c),
        "not_calibrated": c.refused,
        "unreadable": {name: why for name, _, why in c.bench.trouble},
        "findings": list(c.findings),
        "printed_but_does_not_follow": c.not_following.to_dict("records"),
        "contradictions": list(c.flags),
        "notes": {n: list(f.notes) for n, f in fits.items()},
        "options": c.options,
        "random_seed": c.seed,
        "versions": versions(),
    }


def _pile(c: Calibration) -> dict | None:
    """What one angle leaves open."""
    if c.pile is None:
        return None
    o, path = c.pile.optimum, c.pile.path
    out = {
        "optimum": o.point,
        "predicted_deg": o.predicted,
        "target_deg": o.target,
        "outcome": o.outcome,
        "boundary": o.boundary,
        "nearest_the_centre": c.pile.central.point,
        "solutions": c.pile.sheet.statement,
        "path_meets_bench_at": path.crossing if path is not None else None,
    }
    if (joint := c.joint) is None:
        return out
    tension = joint.posterior.tension
    by = tension["observable"].str.split(": ").str[0]
    out["observables"] = tension[by.isin([PILE.name, *c.beside])].to_dict("records")
    if len(joint.directions):
        shown = joint.directions[["sd_ratio", "resolved", "statement"]]
        out["directions"] = shown.to_dict("records")
        tests = joint.next_tests
        out["measure_next"] = tests["test"].iloc[0] if len(tests) else None
    return out


def all_tables(c: Calibration) -> dict[str, pd.DataFrame]:
    """Every table by the name of its file."""
    flat = parameters(c)
    flat["budget"] = [
        "; ".join(f"{k} {v:.0%}" for k, v in b.items()) for b in flat["budget"]
    ]
    out = {"parameters": flat, "printed": c.checks}
    for name, r in c.bench.rigs.items():
        read = {r.response: r.values, "reading_sd": r.reading_sd}
        out[f"{name}_bench"] = pd.DataFrame(read)
        out[f"{name}_recordings"] = r.recordings
    for name, fit in c.steel.items():
        out[f"{name}_simulated"] = fit.rows
        out[f"{name}_answers"] = fit.answers
        out[f"{name}_curve"] = curve(fit)
    if (p := c.pile) is not None:
        out |= {
            "pile_design": p.design,
            "pile_coefficients": p.coefficients,
            "pile_anova": p.anova,
            "pile_residuals": p.residuals,
            "pile_contributions": p.contributions,
            "pile_left_out": p.reduction.steps,
            "pile_solutions": p.sheet.table,
            "pile_quality": pd.DataFrame([asdict(p.quality)]),
        }
        out |= {"pile_path": p.path.errors} if p.path is not None else {}
        out |= {"pile_replicates": p.plan.table} if p.plan is not None else {}
    out |= {f"{n}_runs": s.runs for n, s in c.beside.items() if s.runs is not None}
    if (joint := c.joint) is not None:
        out["posterior"] = joint.posterior.draws
        out["posterior_summary"] = joint.table
        out["tension"] = joint.posterior.tension
        out |= {"next_tests": joint.next_tests} if len(joint.next_tests) else {}
        if len(joint.directions):
            out |= {"directions": joint.directions}
    return out | {k: v for k, v in c.more.items() if isinstance(v, pd.DataFrame)}


def curve(fit: SteelFit) -> pd.DataFrame:
    """Both curves of a rig with their standard errors, for drawing."""
    x = np.linspace(fit.polynomial.low, fit.polynomial.high, CURVE_POINTS)
    table = {fit.rig.parameter: x}
    curves = {"polynomial": fit.polynomial, "monotone": fit.monotone}
    for name, line in curves.items():
        if line is not None:
            table[name] = line.mean(x)
            table["se" if name == "polynomial" else f"{name}_se"] = np.sqrt(
                line.variance(x)
            )
    return pd.DataFrame(table)


def _plain(value):
    """JSON values; what is not finite becomes null."""
    if isinstance(value, dict):
        return {str(k): _plain(v) for k, v in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(v) for v in value]
    if isinstance(value, np.bool_ | bool):
        return bool(value)
    if isinstance(value, np.integer):
        return int(value)
    if isinstance(value, float | np.floating):
        return float(value) if np.isfinite(value) else None
    return value
