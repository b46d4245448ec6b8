"""A calibration's folder without a calibration: a posterior drawn here, and a simulator
in closed form."""

import json

import numpy as np
import pandas as pd

MEAN = {
    "restitution": 0.50,
    "static_friction": 0.36,
    "rolling_friction": 0.03,
    "seed_restitution": 0.60,
    "seed_static_friction": 0.50,
    "seed_rolling_friction": 0.04,
}
FRICTION_SD = 0.06  # of the seed–seed static friction, which the angles rise with
SLOPE_DEG = 20.0  # degrees by friction


def write_calibrated(folder, **changed):
    """A folder as `benchtwin calibrate` leaves it, of which only one parameter is
    uncertain. changed: entries of result.json in place of the usual ones."""
    (folder / "tables").mkdir(parents=True)
    draws = pd.DataFrame([MEAN] * 500)
    draws["seed_static_friction"] += np.random.default_rng(5).normal(
        0, FRICTION_SD, 500
    )
    draws.to_csv(folder / "tables" / "posterior.csv", index=False)
    seed = {
        "length_mm": 7.5,
        "width_mm": 7.1,
        "thickness_mm": 6.9,
        "density_kg_m3": 1250.0,
    }
    content = {
        "mode": "simulated",
        "conventions": {"rolling": "edem"},
        "parameters": {
            name: {
                "low": value - 0.1,
                "high": value + 0.1,
                "status": "calibrated",
                "most_probable_set": value,
            }
            for name, value in MEAN.items()
        },
        "not_calibrated": {},
        "options": {},
        "bench": {"described": {"seed": seed}},
    }
    (folder / "result.json").write_text(json.dumps(content | changed))
    return folder


class Angles:
    """A simulator whose angles are SLOPE_DEG × friction + a packing's own scatter; it
    keeps what it was asked for. lost: how many of the first runs fail."""

    def __init__(self, packing_sd: float = 0.8, lost: int = 0):
        self.packing_sd, self.lost, self.runs = packing_sd, lost, []

    def __call__(self, runs) -> pd.DataFrame:
        rows = [self._row(run) for run in runs]
        for row in rows[: self.lost]:
            row.update(
                status="failed",
                reason="ValueError: it blew up",
                true_repose_angle_deg=np.nan,
            )
        self.runs += runs
        return pd.DataFrame(rows)

    def _row(self, run) -> dict:
        noise = np.random.default_rng(list(run.rng)).normal(0, self.packing_sd, 2)
        angle = 15 + SLOPE_DEG * run.values["seed_static_friction"]
        done = {"status": "done", "reason": "", "rerun": "", "seconds": 1.0}
        if run.rig == "drum":
            return done | {"true_flowing_angle_deg": angle + 10 + noise[0]}
        if run.rig == "bed":
            return done | {"true_bed_rebound_mm": 0.1 * (angle + noise[0])}
        return done | {
            "true_repose_angle_deg": angle + noise[0],
            "true_centroid_angle_deg": angle - 2 + noise[1],
        }
