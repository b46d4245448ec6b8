"""A lot of measured seeds: every one as often as the next, the typical one nearest to
the means."""

import numpy as np
import pytest

from benchtwin.sim.rigs.bench import Bench
from benchtwin.sim.seed import Seed
from benchtwin.sim.seed.lot import Lot

SEEDS = tuple(
    Seed.from_dimensions(1e-3 * length, 6e-3, 5e-3) for length in (7.0, 8.0, 9.5)
)


def test_each_seed_is_drawn_as_often_as_the_next_in_random_order():
    drawn = Lot(SEEDS).draw(np.random.default_rng(1), 302)
    counts = [sum(seed is other for other in drawn) for seed in SEEDS]
    assert sum(counts) == 302 and max(counts) - min(counts) <= 1
    assert any(drawn[k] is not SEEDS[k % 3] for k in range(30))


def test_the_typical_seed_and_the_nearest():
    lot = Lot(SEEDS)
    assert lot.typical() is SEEDS[1] and lot.nearest([9.4e-3, 6e-3, 5e-3]) is SEEDS[2]


def test_a_bench_draws_from_its_lot():
    bench = Bench(sizes=Lot(SEEDS))
    assert set(bench.draw(np.random.default_rng(2), 12)) == set(SEEDS)
    assert bench.mean_seed() is SEEDS[1]
    assert bench.mean_dimensions_m == pytest.approx((8.1667e-3, 6e-3, 5e-3), rel=1e-3)


def test_a_lot_needs_seeds_with_sizes():
    with pytest.raises(ValueError, match="at least one"):
        Lot(())
    with pytest.raises(ValueError, match="dimensions"):
        Lot((Seed.from_spheres(np.zeros((1, 3)), np.array([3e-3])),))
