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
from benchtwin.calibrate.procedure.observed import PileObservables
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
    "value": "median of the posterior, in the digits that its interval carries",
    "interval": "low to high holds the value with probability `level`, given the model",
    "most_probable_set": (
        "the one point of all parameters with the highest joint density: medians, each"
        " by itself, need not give what the bench shows together"
    ),
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
    fits: dict[str, SteelFit | PileObservables] = {**c.steel, **c.seeds}
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
        "verification": {n: asdict(v) for n, v in c.verified.items()},
        "observables": observables(c),
        "surface": _surface(c),
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


def observables(c: Calibration) -> list[dict]:
    """What was matched: a row a reading, at the most probable set."""
    return [] if c.joint is None else c.joint.posterior.tension.to_dict("records")


def _surface(c: Calibration) -> dict | None:
    """What the steps of a publication give."""
    if c.surface is None:
        return None
    o, path = c.surface.optimum, c.surface.path
    return {
        "optimum": o.point,
        "predicted_deg": o.predicted,
        "target_deg": o.target,
        "outcome": o.outcome,
        "boundary": o.boundary,
        "path_meets_bench_at": path.crossing if path is not None else None,
    }


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
        out[f"{name}_curve"] = curve(fit)
    out |= {f"{n}_runs": s.runs for n, s in c.seeds.items()}
    if (p := c.surface) is not None:
        out |= {
            "pile_design": p.design,
            "pile_coefficients": p.coefficients,
            "pile_anova": p.anova,
            "pile_residuals": p.residuals,
            "pile_contributions": p.contributions,
            "pile_quality": p.quality,
        }
        out |= {"pile_path": p.path.errors} if p.path is not None else {}
    if (joint := c.joint) is not None:
        out["posterior"] = joint.posterior.draws
        out["posterior_summary"] = joint.table
        out["tension"] = joint.posterior.tension
        out |= {"next_tests": joint.next_tests} if len(joint.next_tests) else {}
    return out | {k: v for k, v in c.more.items() if isinstance(v, pd.DataFrame)}


def curve(fit: SteelFit) -> pd.DataFrame:
    """The surrogate of a rig with its standard error, for drawing."""
    box = fit.surrogate.box
    x = np.linspace(*box.range(fit.rig.parameter), CURVE_POINTS)
    mean, variance = fit.surrogate.evaluate(x[:, None])
    table = {fit.rig.parameter: x, fit.rig.response: mean, "se": np.sqrt(variance)}
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
