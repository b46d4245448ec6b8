"""The soybean paper's printed tables, as tables, and what it printed of its
analysis."""

import numpy as np
import pandas as pd
import pytest

from benchtwin.calibrate.statistics.box import Box
from benchtwin.calibrate.statistics.surface import fit_surface
from benchtwin.calibrate.statistics.surrogate import fit_surrogate

FACTORS = ("restitution", "static_friction", "rolling_friction")


@pytest.fixture
def drop_rows():
    height, sd = [70, 82, 91, 104, 117, 129], [3, 5, 6, 5, 6, 4]
    restitution = [0.45, 0.49, 0.53, 0.57, 0.61, 0.65]
    return pd.DataFrame(
        {
            "restitution": restitution,
            "rebound_height_mm": height,
            "sd_mm": sd,
            "repeats": 10,
        }
    )


@pytest.fixture
def slide_rows():
    friction, angle = [0.25, 0.29, 0.33, 0.37, 0.41, 0.45], [15, 17, 19, 21, 23, 25]
    return pd.DataFrame({"static_friction": friction, "slide_angle_deg": angle})


@pytest.fixture
def roll_rows():
    run_out, sd = [216, 125, 93, 48, 36, 27], [4, 3, 5, 6, 7, 6]
    return pd.DataFrame(
        {
            "rolling_friction": np.arange(1, 7) / 100,
            "run_out_mm": run_out,
            "sd_mm": sd,
            "repeats": 10,
        }
    )


@pytest.fixture
def path():
    x = [[0.45 + 0.05 * i, 0.2 + 0.1 * i, 0.01 + 0.01 * i] for i in range(6)]
    return pd.DataFrame(x, columns=list(FACTORS)).assign(
        repose_angle_deg=[24, 26.2, 28.1, 30, 31.9, 33.8]
    )


@pytest.fixture
def box():
    return Box(FACTORS, [0.55, 0.40, 0.03], [0.65, 0.60, 0.05])


@pytest.fixture
def runs():
    """Table 9: the Box–Behnken runs, coded."""
    rows = """0 0 0 30.3;0 0 0 29.8;-1 1 0 29.8;-1 0 1 29.9;1 0 -1 29.4;0 0 0 30.3;
    0 1 1 31.5;0 -1 -1 28.2;1 1 0 31.1;1 -1 0 29.5;-1 0 -1 28.4;-1 -1 0 28.5;
    0 -1 1 28.9;0 1 -1 29.4;1 0 1 31.3;0 0 0 29.7;0 0 0 30.1"""
    return pd.DataFrame(
        [[float(v) for v in r.split()] for r in rows.split(";")],
        columns=["A", "B", "C", "repose_angle_deg"],
    )


@pytest.fixture
def natural(box):
    """A table coded A, B, C with its factors' natural values."""

    def of(table):
        values = box.natural(table[["A", "B", "C"]].to_numpy(float))
        return table.assign(**dict(zip(FACTORS, values.T)))

    return of


@pytest.fixture
def surface(runs, box, natural):
    return fit_surface(natural(runs), "repose_angle_deg", box)


@pytest.fixture
def surrogate(runs, box, natural):
    return fit_surrogate(natural(runs), "repose_angle_deg", box)
