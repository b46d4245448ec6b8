"""From a law in the DEM, through its tracks, to the diagnosis and the improved
simulation: slides and impacts.

Rolls: tests/test_samples.py; drops through rendered frames: test_resimulation.py.
"""

import json
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import tomli_w
from typer.testing import CliRunner

from benchtwin.command_line import app
from benchtwin.rigs.drop.fall_laws import viscoelastic
from benchtwin.twin import Parameters
from benchtwin.twin.paths import like
from benchtwin.twin.run import run

SEED = {"length_mm": 7.4, "width_mm": 7.1, "thickness_mm": 7.0, "density_kg_m3": 1250.0}
CAMERA = {
    "fps": 200.0,
    "mm_per_px": 0.25,
    "mm_per_px_sd": 0.0002,
    "plumb_deg": 0.0,
    "plumb_sd_deg": 0.05,
    "distance_mm": 2e4,
}


def record(
    folder: Path,
    rig: str,
    about: dict,
    parameters: Parameters,
    rng,
    *,
    fps: float,
    known: tuple[str, ...],
    count: int = 1,
    noise: float = 0.04,
    conditions: dict | None = None,
):
    """One run of the DEM as a track whose tracker errs by `noise` mm, slowly; of
    `about` the recording states `known` only."""
    told = {
        "seed": SEED | {"count": count},
        rig: about,
        "camera": CAMERA | {"fps": fps},
    }
    motion, _ = run(like(rig, told), parameters, rng=rng)
    x, z = 1e3 * motion.positions_m[:, 0, 0], 1e3 * motion.positions_m[:, 0, 2]
    x, z = (motion.series["travel_mm"], 0 * z) if rig == "slide" else (x, z)
    columns = {
        "t_s": motion.t_s,
        "x_mm": x + noise * slow(len(x), rng),
        "y_mm": z + noise * slow(len(x), rng),
    }
    if rig == "slide":
        columns["tilt_deg"] = motion.series["tilt_deg"] + rng.normal(0, 0.01, len(x))
    folder.mkdir(parents=True)
    pd.DataFrame(columns).round(5).to_csv(folder / "track.csv", index=False)
    stated = {
        "rig": rig,
        "seed": told["seed"],
        "camera": told["camera"],
        rig: {k: v for k, v in about.items() if k in known},
    }
    stated |= {"conditions": conditions} if conditions else {}
    (folder / "recording.toml").write_text(tomli_w.dumps(stated), encoding="utf8")


def slow(n: int, rng) -> np.ndarray:
    """Errors of variance 1 that are alike by 0.7 from frame to frame."""
    out = rng.normal(size=n)
    for k in range(1, n):
        out[k] = 0.7 * out[k - 1] + np.sqrt(1 - 0.7**2) * out[k]
    return out


def diagnosed(folder: Path, rig: str):
    result = CliRunner().invoke(
        app,
        ["diagnose", str(folder / "bench"), "--out", str(folder / "out"), "--quick"],
    )
    return json.loads((folder / "out" / "diagnosis.json").read_text())["rigs"][
        rig
    ], result.output


@pytest.mark.slow
def test_friction_that_falls_once_it_slides(tmp_path):
    rng = np.random.default_rng(11)
    for k, rate in enumerate((1.0, 2.0, 4.0, 2.0)):
        own = Parameters(
            static_friction=0.34 + 0.003 * rng.normal(),
            laws={"friction_kinetic": {"drop": 0.03}},
        )
        about = {"tilt_rate_deg_s": rate, "start_deg": 15.0}
        record(
            tmp_path / "bench" / f"slide-{k}",
            "slide",
            about,
            own,
            rng,
            fps=200.0,
            known=("tilt_rate_deg_s",),
            count=4,
            noise=0.1,
        )
    slide, said = diagnosed(tmp_path, "slide")
    assert (
        slide["alarm"]
        and set(slide["names"]) <= {"kinetic-friction", "stribeck"}
        and slide["names"]
    ), said
    assert slide["verdict"] in ("name", "class")
    for name, value in slide["parameters"].items():
        if "." not in name:
            assert value["low95"] < 0.032 and value["high95"] > 0.028, said
    assert slide["twin"]["rmse_after"] < 0.2 * slide["twin"]["rmse_before"], said


@pytest.mark.slow
def test_friction_that_follows_the_moisture(tmp_path):
    rng = np.random.default_rng(13)
    for k, moisture in enumerate((9.0, 15.0, 11.0, 13.0, 10.0, 14.0)):
        own = Parameters(
            static_friction=0.40 - 0.008 * (moisture - 12.0) + 0.002 * rng.normal()
        )
        about, at = (
            {"tilt_rate_deg_s": 2.0, "start_deg": 17.0},
            tmp_path / "bench" / f"slide-{k}",
        )
        told = {
            "known": ("tilt_rate_deg_s",),
            "count": 4,
            "noise": 0.1,
            "conditions": {"moisture_pct": moisture},
        }
        record(at, "slide", about, own, rng, fps=200.0, **told)
    slide, said = diagnosed(tmp_path, "slide")
    assert slide["verdict"] == "name" and slide["names"] == [
        "static_friction-follows-moisture_pct"
    ], said
    slope = slide["effects"]["static_friction-follows-moisture_pct"]
    assert slope["low95"] < -0.0076 and slope["high95"] > -0.0084, said
    assert (
        "static friction falls by 0.00" in said
        and "per % moisture (moisture_pct), in all 6 slides" in said
    )
    assert (
        slide["twin"]["quantity"] == "angle of onset"
        and slide["twin"]["rmse_after"] < 0.3 * slide["twin"]["rmse_before"]
    ), said


@pytest.mark.slow
def test_restitution_that_falls_with_speed(tmp_path):
    rng = np.random.default_rng(12)
    for k in range(12):
        about = {"height_mm": (30.0, 100.0, 310.0)[k % 3], "bounces": 2}
        own = Parameters(
            restitution=0.6,
            laws={"restitution_viscoelastic": viscoelastic(0.12, 0.6, 1.5)},
        )
        record(
            tmp_path / "bench" / f"drop-{k:02d}",
            "drop",
            about,
            own,
            rng,
            fps=1000.0,
            known=("height_mm",),
        )
    drop, said = diagnosed(tmp_path, "drop")
    falls = {
        "restitution-falls-with-speed",
        "viscoelastic-restitution",
        "plastic-restitution",
        "plate-compliance",
    }
    assert (
        drop["verdict"] in ("name", "class")
        and drop["names"]
        and set(drop["names"]) <= falls
    ), said
    assert drop["sectors"][0]["name"] == "impact"
    assert drop["twin"]["rmse_after"] < 0.9 * drop["twin"]["rmse_before"], said
