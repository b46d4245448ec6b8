"""How stiff seeds rain: long ones, whose ends are small balls, as their fall asks for,
all others as the bench has them."""

from dataclasses import replace

import numpy as np
import pytest
from scenes import NO_AIR

from benchtwin.bench.constants import G_M_S2
from benchtwin.sim.engine.gathering import S_OVERLAP
from benchtwin.sim.engine.step import Every, init, run
from benchtwin.sim.engine.world import Placed, World
from benchtwin.sim.material import SOYBEAN_SOYBEAN
from benchtwin.sim.rigs.bench import Bench, no_watch
from benchtwin.sim.rigs.engine import Ours
from benchtwin.sim.rigs.filling import RAIN_OVERLAP, firm
from benchtwin.sim.rigs.heap import fill
from benchtwin.sim.rigs.pile import Pile, vessel

SOFT = Bench(shear_modulus_pa=3e6, rayleigh_fraction=0.3, air_density_kg_m3=0.0)
LONG = replace(SOFT, sizes=(15e-3, 5.7e-3, 5.7e-3))


@pytest.mark.parametrize("speed", [2.0, 3.5])
@pytest.mark.parametrize("overlap", [0.1, 0.25])
def test_seeds_that_meet_end_to_end_overlap_by_as_much_as_is_allowed(speed, overlap):
    """Head on, without damping: the greatest overlap of their end balls is the share of
    their radius that was asked for."""
    seed = LONG.mean_seed()
    grain = firm(LONG, (seed,), speed, overlap)
    half = float((seed.centres_m[:, 0] + seed.radii_m).max())
    places = np.array([[-half - 1e-5, 0, 0], [half + 1e-5, 0, 0]])
    speeds = np.array([[speed / 2, 0, 0], [-speed / 2, 0, 0]])
    placed = Placed((seed,), grain, places, velocities=speeds)
    elastic = replace(SOYBEAN_SOYBEAN, restitution=1.0)
    world = World(
        (placed,),
        contacts=(elastic,),
        laws=NO_AIR,
        gravity=(0.0, 0.0, 0.0),
        rayleigh_fraction=0.05,
        most_overlap=0.5,
    )
    greatest = []

    def look(world, state):
        greatest.append(float(state.sums[:, S_OVERLAP].max()))

    run(world, init(world, np.random.default_rng(0)), 2e-3, [Every(1e-6, look)])
    assert max(greatest) == pytest.approx(overlap, rel=5e-3)


def test_only_what_falls_far_on_small_balls_is_made_stiffer():
    for bench in (SOFT, replace(SOFT, sizes=(8.7e-3, 6.8e-3, 6e-3))):
        assert firm(bench, (bench.mean_seed(),), 2.8, RAIN_OVERLAP) == bench.grain
    seed = (LONG.mean_seed(),)
    slow, fast = (firm(LONG, seed, v, RAIN_OVERLAP).shear_modulus_pa for v in (1.5, 3))
    assert fast == pytest.approx(4 * slow) and slow > 3e6
    assert firm(LONG, seed, 1e3, RAIN_OVERLAP) == LONG.seed  # never above the real one


def test_long_seeds_fill_a_high_box():
    """Rained as soft as the bench, an end is pressed by more than the guard allows."""
    box = vessel(Pile((0.03, 0.03, 0.14), (0.03, 0.14), (0.1, 0.1), 0.12), LONG)
    filled = fill(box, LONG, np.random.default_rng(5), Ours(1), no_watch)
    fall = np.sqrt(2 * G_M_S2 * 0.3)
    assert firm(LONG, filled.shapes, fall, RAIN_OVERLAP) != LONG.grain
    assert len(filled.shape_of) > 100 and filled.positions_m[:, 2].max() < 0.12
