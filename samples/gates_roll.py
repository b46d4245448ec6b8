"""A steel ball on two rails past five light gates, samples/gates-roll: it never leaves
its incline, and is run both ways on a table that is not level. Drawn from the equation
of motion alone.

    .venv/bin/python samples/gates_roll.py FOLDER      # draw it anew (at once)

truth.csv holds each run's acceleration, the mean rolling friction of both directions,
and the slope."""

import math
import sys
from pathlib import Path

import numpy as np
import pandas as pd

GATES_MM = (150.0, 350.0, 550.0, 750.0, 950.0)  # along the rails, from the release
DIAMETER_MM, GAP_MM, MASS_G = 15.0, 6.0, 13.8
INCLINE_DEG, SLOPE_DEG = 8.0, -0.15  # of the rails; of the table, falling towards +x
FRICTION, FROM_RUN_TO_RUN = 0.012, 0.02  # of rolling, and how much it differs, relative
TIMER_SD_S = 2e-5
RUNS = 4  # either way
DRAG_PER_M = (
    1.2 * 0.44 * math.pi * (DIAMETER_MM / 1000) ** 2 / (8 * MASS_G / 1000)
)  # C_d 0.44
SEED = 2053


def draw(folder: Path) -> pd.DataFrame:
    """Write all recordings, bench.toml and truth.csv; returns the truth."""
    folder.mkdir(parents=True)
    said = (
        f"length_mm = {DIAMETER_MM}\nwidth_mm = {DIAMETER_MM}\nthickness_mm ="
        f" {DIAMETER_MM}\nmass_g = {MASS_G}\n"
    )
    roll = f"incline_deg = {INCLINE_DEG}\nrail_gap_mm = {GAP_MM}\nlevel = false\n"
    (folder / "bench.toml").write_text(
        'rig = "roll"\nsession = "rails"\nprovenance ='
        f' "simulated"\n[seed]\n{said}[roll]\n{roll}'
    )
    rng, truth, friction = np.random.default_rng(SEED), [], []
    radius = DIAMETER_MM / 2
    inertia = 1 + 0.4 * radius**2 / (radius**2 - (GAP_MM / 2) ** 2)
    for direction, sign in (("+x", 1), ("-x", -1)):
        for k in range(RUNS):
            friction.append(FRICTION * (1 + FROM_RUN_TO_RUN * rng.standard_normal()))
            lean = math.radians(INCLINE_DEG + sign * SLOPE_DEG)
            acceleration = (
                9.80665 * (math.sin(lean) - friction[-1] * math.cos(lean)) / inertia
            )
            name = f"{'right' if sign > 0 else 'left'}-{k + 1}"
            time = passages(
                acceleration, DRAG_PER_M / inertia
            ) + TIMER_SD_S * rng.standard_normal(len(GATES_MM))
            (folder / name).mkdir()
            (folder / name / "recording.toml").write_text(
                f'[roll]\ndirection = "{direction}"\n'
            )
            rows = pd.DataFrame({"x_mm": GATES_MM, "t_s": (time - time[0]).round(6)})
            rows.to_csv(folder / name / "gates.csv", index=False)
            truth.append((name, "acceleration", acceleration, "m/s²"))
    truth += [
        ("mean", "rolling_resistance", float(np.mean(friction)), "1"),
        ("rails both ways", "slope", SLOPE_DEG, "deg"),
    ]
    table = pd.DataFrame(truth, columns=["recording", "quantity", "value", "unit"])
    table.to_csv(folder / "truth.csv", index=False, float_format="%.6g")
    return table


def passages(acceleration: float, drag_per_m: float) -> np.ndarray:
    """Times [s] from rest at x = 0 to the gates under a − k v²: x = ln cosh(√(a k) t) /
    k."""
    x = np.array(GATES_MM) / 1000
    return np.arccosh(np.exp(drag_per_m * x)) / math.sqrt(acceleration * drag_per_m)


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__.strip())
    draw(Path(sys.argv[1]))
