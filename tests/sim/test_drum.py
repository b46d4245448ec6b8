"""The rotating drum: its level of filling by a closed form, seeds that stay within it,
a surface that falls the way it turns."""

import numpy as np
import pytest

from benchtwin.bench.keys import Air, Seed
from benchtwin.sim.rigs.drum import Drum, _level, flowing_angle, run_drum
from benchtwin.sim.rigs.engine import Ours
from benchtwin.twin.parameters import Parameters, bench


@pytest.mark.parametrize("share", [0.1, 0.25, 0.5, 0.6])
def test_the_level_below_which_a_share_of_a_circle_lies(share):
    """Against counting points of a grid: 0.1 % of the area."""
    x, z = np.meshgrid(np.linspace(-1, 1, 2001), np.linspace(-1, 1, 2001))
    inside = x**2 + z**2 < 1
    assert (inside & (z < _level(share))).sum() / inside.sum() == pytest.approx(
        share, abs=1e-3
    )


@pytest.fixture(scope="module")
def flow():
    rig = Drum(drum_m=(0.080, 0.016), speed_rpm=20.0, wait_s=0.8, film_s=0.4)
    of = bench(Parameters(shear_modulus_pa=1e6), "drum", Seed(), Air())
    return rig, run_drum(rig, of, np.random.default_rng(3), fps=20.0, engine=Ours(1))


def test_all_seeds_stay_in_the_drum(flow):
    rig, motion = flow
    away = np.hypot(motion.positions_m[..., 0], motion.positions_m[..., 2])
    assert (
        np.isfinite(away).all() and away.max() < rig.drum_m[0] / 2 and motion.seeds > 30
    )


def test_the_surface_stands_where_the_drum_s_turning_carries_the_seeds(flow):
    """Turned clockwise as the camera sees it, seeds are carried up on the left: the
    surface falls to the right."""
    rig, motion = flow
    assert 15 < motion.truth["flowing_angle_deg"] < 60
    assert motion.positions_m[-1, :, 0].mean() < 0
    angles = [flowing_angle(motion, rig.drum_m[0] / 2, k) for k in range(motion.frames)]
    assert motion.truth["flowing_angle_deg"] == pytest.approx(np.mean(angles))


@pytest.mark.parametrize(
    "wrong", [{"fill_share": 0.9}, {"speed_rpm": 400.0}, {"drum_m": (0.1, 0.0)}]
)
def test_a_drum_that_cannot_be_is_refused(wrong):
    with pytest.raises(
        ValueError, match=next(iter(wrong)) if "drum_m" not in wrong else "above 0"
    ):
        Drum(**wrong)
