"""Diagnosis of rolls past a few gates and of tracks of a few rows: clean ones raise no
alarm, a leaning apparatus is named."""

import math

import numpy as np
import pytest
from rolling_balls import Ball, way

from benchtwin.rigs.roll.diagnose import diagnose_roll
from benchtwin.rigs.roll.read import SeenRoll

SEED = {"length_mm": 15.0, "width_mm": 15.0, "thickness_mm": 15.0, "mass_g": 13.8}
GATES = np.array([180.0, 360, 540, 720, 900])


def runs(
    slope_deg: float,
    count: int,
    rng: np.random.Generator,
    *,
    camera: int = 0,
    level: bool = False,
) -> list[SeenRoll]:
    """`count` runs in either direction of a ball on an apparatus that leans by
    `slope_deg`, falling towards +x; camera: rows of its tracks, 0: past gates."""
    out, place = [], 0.2e-3 * rng.standard_normal(len(GATES))
    for direction, sign in (("+x", 1.0), ("-x", -1.0)):
        for k in range(count):
            mu = 0.015 * (1 + 0.02 * rng.standard_normal())
            beta = math.radians(12 + (0 if level else sign * slope_deg))
            ball = Ball(beta, mu, 1.4, 0.0012, length=0.15 if level else np.inf)
            fine, x = way(ball, rng.uniform(0.02, 0.05), 6.0 if level else 2.0)
            if camera or level:
                stop = (
                    fine[np.argmax(x > 0.95)]
                    if not level
                    else fine[np.argmax(x >= x[-1] - 1e-6)]
                )
                time = np.linspace(0.02, stop, camera or 10)
                seen = 1000 * np.interp(time, fine, x) + 0.3 * rng.standard_normal(
                    len(time)
                )
            else:
                time, seen = (
                    np.interp(GATES / 1000 + place, x, fine)
                    + 2e-5 * rng.standard_normal(len(GATES)),
                    GATES,
                )
            roll = {"incline_deg": 12.0, "direction": direction} | (
                {"incline_length_mm": 150.0} if level else {"level": False}
            )
            told = {
                "seed": SEED,
                "camera": {"scale_sd": 1e-3},
                "air": {"density_kg_m3": 1.2, "viscosity_pa_s": 1.8e-5},
                "roll": roll,
            }
            name = f"{direction}-{k}"
            gates = not (camera or level)
            sd = np.full(len(seen), np.nan)
            out.append(
                SeenRoll(
                    name,
                    "",
                    np.arange(len(seen)),
                    time,
                    seen,
                    None,
                    told,
                    sd_mm=sd,
                    gates=gates,
                )
            )
    return out


@pytest.mark.parametrize(
    ("camera", "slope"),
    [
        pytest.param(0, -0.3, marks=pytest.mark.slow),
        (10, 0.3),
        pytest.param(120, -0.3, marks=pytest.mark.slow),
        *(
            pytest.param(*case, marks=pytest.mark.slow)
            for case in [(0, 0.3), (10, -0.3), (120, 0.3)]
        ),
    ],
)
def test_an_apparatus_that_leans_is_named_from_both_directions(camera, slope):
    found = diagnose_roll(
        runs(slope, 8, np.random.default_rng(4), camera=camera),
        np.random.default_rng(0),
    )
    assert found.alarm and "slope" in found.names
    assert found.verdict == "class" or found.parameters["slope"].value == pytest.approx(
        slope, abs=0.1
    )


@pytest.mark.parametrize("camera", [pytest.param(0, marks=pytest.mark.slow), 10])
def test_a_level_apparatus_raises_no_alarm(camera):
    alarms = []
    for k in range(6):
        seen = runs(0.0, 6, np.random.default_rng(k), camera=camera)
        alarms.append(diagnose_roll(seen, np.random.default_rng(0)).alarm)
    assert sum(alarms) <= 1  # one in a hundred by chance


def test_few_rows_on_both_legs_are_diagnosed():
    found = diagnose_roll(
        runs(0.0, 4, np.random.default_rng(2), level=True), np.random.default_rng(0)
    )
    assert not found.alarm
