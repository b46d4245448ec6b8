"""The slide rig against closed forms: onset at atan μ, the slide after it, the taped
block."""

from dataclasses import replace

import numpy as np
import pytest

from benchtwin.bench.constants import G_M_S2
from benchtwin.sim.material import SOYBEAN_Q235
from benchtwin.sim.rigs.bench import Bench
from benchtwin.sim.rigs.slide import Slide, run_slide, taped

QUICK = Slide(tilt_rate_deg_s=10.0, start_deg=10.0)


def bench(mu):
    return Bench(seed_wall=replace(SOYBEAN_Q235, static_friction=mu))


@pytest.mark.parametrize("mu", [0.25, 0.34, 0.45])
def test_the_block_lets_go_at_the_angle_of_friction(mu):
    truth = run_slide(QUICK, bench(mu), np.random.default_rng(1)).truth
    assert truth["slide_angle_deg"] == pytest.approx(
        np.degrees(np.arctan(mu)), abs=0.05
    )


def test_after_the_onset_it_slides_as_a_block_does():
    """ẍ = g (sin θ − μ cos θ), θ growing at the tilt rate from atan μ: travel within 2
    % (the plate turns under the block)."""
    mu, rate = 0.34, np.radians(QUICK.tilt_rate_deg_s)
    motion = run_slide(QUICK, bench(mu), np.random.default_rng(1), fps=200.0)
    tilt, travel = np.radians(motion.series["tilt_deg"]), motion.series["travel_mm"]
    onset = np.arctan(mu)
    fine = np.linspace(onset, tilt[-1], 4000)
    step = (fine[1] - fine[0]) / rate
    acceleration = G_M_S2 * (np.sin(fine) - mu * np.cos(fine))
    way = np.cumsum(np.cumsum(acceleration) * step) * step
    assert travel[-1] == pytest.approx(1e3 * way[-1], rel=0.02)
    assert travel[-1] >= 80.0


def test_taped_seeds_lie_level_and_are_one_body():
    seeds = Bench().draw(np.random.default_rng(2), 4)
    block = taped(seeds)
    table = block.centres_m @ block.axes.T + block.origin_m
    low = (table[:, 2] - block.radii_m).reshape(4, -1).min(axis=1)
    assert np.allclose(low, 0.0, atol=1e-9)  # each of the four touches the table
    assert len(block.radii_m) == 20
    assert block.mass_kg == pytest.approx(
        sum(s.mass_kg for s in seeds), rel=0.01
    )  # pressed together, hardly overlapping


@pytest.mark.parametrize("k", range(20))
def test_four_seeds_of_any_lot_can_be_taped(k):
    block = taped(Bench().draw(np.random.default_rng(k), 4))
    assert len(block.radii_m) == 20


def test_a_plate_too_rough_to_slide_on_is_said_so():
    with pytest.raises(ValueError, match="the block tips over at"):
        run_slide(
            Slide(tilt_rate_deg_s=20.0, start_deg=60.0),
            bench(5.0),
            np.random.default_rng(1),
        )


def test_a_tilting_that_begins_beyond_the_onset_is_said_so():
    with pytest.raises(ValueError, match=r"slides from the start: start_deg = 30"):
        run_slide(Slide(start_deg=30.0), bench(0.34), np.random.default_rng(1))


@pytest.mark.parametrize(
    "wrong",
    [{"count": 3}, {"tilt_rate_deg_s": 0.0}, {"travel_m": 0.2}, {"start_deg": 85.0}],
)
def test_descriptions_that_make_no_sense_are_refused(wrong):
    with pytest.raises(ValueError, match=next(iter(wrong))):
        Slide(**wrong)
