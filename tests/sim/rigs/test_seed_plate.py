"""Plates of seeds: how they are laid, what balls that stand still do to a falling one,
and what the two rigs on them tell."""

from dataclasses import replace

import numpy as np
import pytest

from benchtwin.sim.engine.step import init, run
from benchtwin.sim.engine.walls import Balls
from benchtwin.sim.engine.world import Placed
from benchtwin.sim.material import SOYBEAN_SOYBEAN
from benchtwin.sim.ondem.write import triangles
from benchtwin.sim.rigs.bench import Bench, reach
from benchtwin.sim.rigs.seed_drop import SeedDrop, run_seed_drop
from benchtwin.sim.rigs.seed_plate import laid
from benchtwin.sim.rigs.seed_slide import SeedSlide, run_seed_slide, upside_down
from benchtwin.sim.seed import Seed

ROUND = Bench(sizes=(7e-3,) * 3, spheres=1)
LOW, HIGH = (-0.05, -0.04), (0.05, 0.04)


def with_seeds(bench=ROUND, **contact) -> Bench:
    return replace(bench, seed_seed=replace(SOYBEAN_SOYBEAN, **contact))


def fallen(bench, aside_m: float, pair: bool) -> np.ndarray:
    """Velocity after a ball hit another at 1 m/s, `aside_m` from its middle: one that
    stands still as a wall, or one a million times as heavy."""
    (seed,) = bench.draw(np.random.default_rng(0), 1)
    radius, near = float(seed.radii_m[0]), 1e-4
    up = np.sqrt((2 * radius) ** 2 - aside_m**2) + near
    start = np.array([[aside_m, 0.0, up]])
    speed = np.array([[0.0, 0.0, -1.0]])
    wall = Balls("glued", bench.grain, np.zeros((1, 3)), np.array([radius]))
    if pair:
        heavy = replace(
            seed, mass_kg=1e6 * seed.mass_kg, inertia_kg_m2=1e6 * seed.inertia_kg_m2
        )
        start, speed = np.vstack([start, np.zeros(3)]), np.vstack([speed, np.zeros(3)])
        far = replace(wall, centres=np.array([[0.0, 0.0, -1.0]]))
        shapes, walls, of = (seed, heavy), [far], np.array([0, 1])
    else:
        shapes, walls, of = (seed,), [wall], None
    placed = Placed(shapes, bench.grain, start, None, speed, shape_of=of)
    world = replace(bench.world(placed, walls), gravity=(0.0, 0.0, 0.0))
    return run(world, init(world, np.random.default_rng(0)), 2e-3).velocities[0]


@pytest.mark.parametrize("e", [0.3, 0.8])
def test_a_ball_comes_back_from_a_glued_one_with_its_restitution(e):
    v = fallen(with_seeds(restitution=e), 0.0, pair=False)
    assert v[2] == pytest.approx(e, rel=0.01)


def test_off_the_middle_it_flies_as_from_a_heavy_seed():
    """The same radii, the same law: normal, friction, rolling."""
    bench = with_seeds(restitution=0.6, static_friction=0.4, rolling_friction=0.05)
    glued, heavy = (fallen(bench, 2.5e-3, pair=p) for p in (False, True))
    assert glued == pytest.approx(heavy, abs=2e-3)
    assert glued[0] > 0.3  # off to its side


@pytest.mark.parametrize("coverage", [0.5, 0.78])
def test_seeds_lie_flat_side_by_side_and_cover_what_they_should(coverage):
    bench = Bench()
    plate = laid(bench, np.random.default_rng(3), coverage, LOW, HIGH)
    length, width, _ = bench.mean_dimensions_m
    area = np.subtract(HIGH, LOW).prod()
    n = len(plate.seeds)
    assert n * np.pi / 4 * length * width / area == pytest.approx(coverage, rel=0.06)
    low = [
        x[2] - reach(s, q, (0, 0, -1))
        for s, x, q in zip(plate.seeds, plate.positions_m, plate.orientations)
    ]
    assert low == pytest.approx(np.zeros(n), abs=1e-12)
    apart = np.linalg.norm(
        plate.positions_m[:, None, :2] - plate.positions_m[:, :2], axis=2
    )
    nearest = (apart + np.eye(n)).min(axis=1)
    assert nearest.min() > 0.85 * np.sqrt(length * width)
    other = laid(bench, np.random.default_rng(4), coverage, LOW, HIGH)
    assert not np.allclose(other.positions_m[:5], plate.positions_m[:5])


def test_no_single_layer_covers_all():
    with pytest.raises(ValueError, match=r"coverage = 0\.95: must be 0\.3 to"):
        laid(Bench(), np.random.default_rng(1), 0.95, LOW, HIGH)


def test_a_card_is_its_seeds_turned_over():
    """Mass and moments of the seeds together about their common middle (Steiner); its
    lowest points were the plate's highest."""
    plate = laid(ROUND, np.random.default_rng(1), 0.7, (-0.01, -0.01), (0.01, 0.01))
    card = upside_down(plate)
    each: Seed = plate.seeds[0]
    n, x = len(plate.seeds), plate.positions_m - plate.positions_m.mean(axis=0)
    assert card.mass_kg == pytest.approx(n * each.mass_kg)
    about_z = n * each.inertia_kg_m2[0] + each.mass_kg * (x[:, :2] ** 2).sum()
    assert card.inertia_kg_m2.max() == pytest.approx(about_z, rel=1e-6)
    assert np.linalg.det(card.axes) == pytest.approx(1.0)
    lying = card.centres_m @ card.axes.T + card.origin_m
    assert -np.min(lying[:, 2] - card.radii_m) == pytest.approx(plate.top_m)


def test_seeds_rise_farther_with_more_restitution():
    """As e² and more: (.7/.45)² is 2.4; a mean of eight drops is off by a fifth."""

    def rise(e: float) -> float:
        bench = with_seeds(Bench(), restitution=e)
        motion = run_seed_drop(SeedDrop(drops=8), bench, np.random.default_rng(2))
        assert len(motion.readings["rebound_height_mm"]) == 8
        return motion.truth["rebound_height_mm"]

    assert rise(0.7) > 1.5 * rise(0.45)


def test_a_dropped_seed_is_seen_falling_and_rising():
    motion = run_seed_drop(
        SeedDrop(drops=1), with_seeds(Bench()), np.random.default_rng(5), fps=1000.0
    )
    z = motion.positions_m[:, 0, 2]
    assert np.diff(motion.t_s) == pytest.approx(1e-3, abs=2e-5)
    fall = z[0] - z.min()
    assert fall == pytest.approx(0.310, abs=0.012)
    low = int(np.argmin(z))
    seen = 1e3 * (z[low:].max() - z[low])
    assert motion.truth["rebound_height_mm"] == pytest.approx(seen, abs=1.5)


def test_a_card_slides_later_with_more_friction():
    def angle(mu: float) -> float:
        bench = replace(
            with_seeds(static_friction=mu),
            shear_modulus_pa=5e6,
            rayleigh_fraction=0.3,
        )
        rig = SeedSlide(slides=2, card_m=(0.02, 0.02), travel_m=0.01)
        return run_seed_slide(rig, bench, np.random.default_rng(1)).truth[
            "slide_angle_deg"
        ]

    smooth, rough = angle(0.1), angle(0.6)
    assert smooth > np.degrees(np.arctan(0.1)) + 5  # the hollows hold it
    assert rough > smooth + 10


def test_a_glued_seed_is_saved_as_the_surface_of_its_balls():
    plate = laid(Bench(), np.random.default_rng(1), 0.7, (-0.01, -0.01), (0.01, 0.01))
    wall = plate.walls(Bench())[1]
    far = triangles(wall, wall.primitives()[1]).reshape(-1, 3)
    off = np.linalg.norm(far[:, None] - wall.centres, axis=2) - wall.radii
    assert off.min(axis=1) == pytest.approx(np.zeros(len(far)), abs=1e-9)


def test_glue_takes_its_share_of_what_an_impact_gives_back():
    """A ball on the middle of another, from 100 mm: it rises by e² of that, less a
    third with glue that takes a third."""
    bench = with_seeds(restitution=0.8)
    rises = [
        run_seed_drop(
            SeedDrop(height_m=0.1, coverage=0.8, drops=12, glue_loss=loss),
            bench,
            np.random.default_rng(5),
        ).truth["rebound_height_mm"]
        for loss in (0.0, 1 / 3)
    ]
    assert rises[1] / rises[0] == pytest.approx(2 / 3, abs=0.12)
