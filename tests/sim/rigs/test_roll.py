"""The roll rig against the energy balance, and the same both ways."""

from dataclasses import replace

import numpy as np
import pytest
from scenes import NO_AIR

from benchtwin.sim.material import SOYBEAN_Q235
from benchtwin.sim.rigs.bench import Bench
from benchtwin.sim.rigs.roll import Roll, run_roll

BETA = np.radians(15.0)
STRAIGHT = Roll(axis_sd_deg=0.0)


def bench(mu_r, **more):
    contact = replace(SOYBEAN_Q235, rolling_friction=mu_r)
    return Bench(seed_wall=contact, air_density_kg_m3=0.0, laws=NO_AIR, **more)


def energy_run_out(mu_r, way=0.010):
    """Eq. (3) of the paper: no loss in the corner."""
    return 1e3 * way * (np.sin(BETA) / mu_r - np.cos(BETA))


@pytest.mark.parametrize("mu_r", [0.02, 0.05])
def test_a_straight_seed_stops_short_of_the_energy_balance_by_what_the_corner_takes(
    mu_r,
):
    """In the corner the speed across the new plate is lost: v' ≥ v cos β, so at least
    cos²β of the energy is left."""
    run_out = run_roll(STRAIGHT, bench(mu_r), np.random.default_rng(1)).truth[
        "run_out_mm"
    ]
    assert energy_run_out(mu_r) * 0.82 < run_out < energy_run_out(mu_r)


def test_a_gentle_corner_takes_next_to_nothing():
    """At 3° the corner takes sin²β = 0.3 % of the energy: the balance holds within 2
    %."""
    rig = Roll(incline_deg=3.0, incline_length_m=0.03, axis_sd_deg=0.0)
    run_out = run_roll(rig, bench(0.02), np.random.default_rng(1)).truth["run_out_mm"]
    assert run_out == pytest.approx(
        30.0 * (np.sin(np.radians(3)) / 0.02 - np.cos(np.radians(3))), rel=0.02
    )


def test_both_ways_are_alike_on_a_level_plate_and_differ_on_a_sloping_one():
    level = [
        run_roll(
            replace(STRAIGHT, direction=d), bench(0.02), np.random.default_rng(1)
        ).truth["run_out_mm"]
        for d in ("+x", "-x")
    ]
    assert level[0] == pytest.approx(level[1], rel=0.01)
    sloping = replace(STRAIGHT, slope_deg=0.3)
    down, up = (
        run_roll(
            replace(sloping, direction=d), bench(0.02), np.random.default_rng(1)
        ).truth["run_out_mm"]
        for d in ("+x", "-x")
    )
    # deceleration ∝ μ_r ∓ tan slope
    assert down / up == pytest.approx(
        (0.02 + np.tan(np.radians(0.3))) / (0.02 - np.tan(np.radians(0.3))), rel=0.05
    )


def test_the_travel_is_the_centres_as_a_camera_sees_it_and_ends_where_the_seed_does():
    """The corner is cut: 2 r tan(β/2) less than the foot goes, with neither leap nor
    haste."""
    motion = run_roll(STRAIGHT, bench(0.02), np.random.default_rng(1), fps=500.0)
    travel, centre = (
        motion.series["travel_mm"],
        1e3 * motion.positions_m[:, 0][:, [0, 2]],
    )
    assert travel[-1] - 10.0 == pytest.approx(motion.truth["run_out_mm"])
    assert travel[0] == pytest.approx(
        2 * centre[-1, 1] * np.tan(BETA / 2), rel=0.15
    )  # the seed is not round
    steps = np.hypot(*np.diff(centre, axis=0).T)
    np.testing.assert_allclose(np.diff(travel), steps, atol=0.02 * steps.max() + 0.01)


def test_a_seed_that_rolls_off_the_plate_has_no_run_out():
    motion = run_roll(
        Roll(plate_m=(0.05, 0.12), axis_sd_deg=0.0),
        bench(0.005),
        np.random.default_rng(1),
    )
    assert "run_out_mm" not in motion.truth


@pytest.mark.parametrize(
    "wrong",
    [
        {"direction": "left"},
        {"incline_deg": 0.0},
        {"orientation": "flat"},
        {"incline_length_m": 0.0},
    ],
)
def test_descriptions_that_make_no_sense_are_refused(wrong):
    with pytest.raises(ValueError, match=next(iter(wrong))):
        Roll(**wrong)
