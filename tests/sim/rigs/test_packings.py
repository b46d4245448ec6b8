"""Fillings are random packings, whatever the shape, the friction and the vessel.

Within the packing, a seed's diameter from walls and surface:

- Spheres without rolling friction lie between random loose and random close packing:
  solid share .55 to .64, coordination number 4 to 6 (Silbert 2010, Soft Matter 6, 2918;
  at a friction of .3, .593 and 4.5: Agnolin & Roux 2007, Phys. Rev. E 76, 061302).
- Rolling friction holds spheres that sliding friction alone does not, and loosens: then
  a contact takes five of the six freedoms that a seed has, not three, and 12/5 contacts
  a seed hold in the place of 4. Long seeds turn until they lie closer: up to .70
  (Donev et al. 2004, Science 303, 990).
- Directions of contacts are spread evenly but for what weight does: of 300 even ones
  the mean square of a component is 1/3 ± .017, and 5 % ± 1.3 % lie within 18° of the
  vertical."""

from dataclasses import dataclass, replace

import numpy as np
import pytest
from scenes import NO_AIR
from scipy.spatial import cKDTree

from benchtwin.sim.engine import filling
from benchtwin.sim.engine.world import Scattered
from benchtwin.sim.material import SOYBEAN_SOYBEAN
from benchtwin.sim.rigs import cylinder, drawdown, drum, pile
from benchtwin.sim.rigs.bench import Bench, no_watch
from benchtwin.sim.rigs.cylinder import LiftedCylinder
from benchtwin.sim.rigs.engine import Ours
from benchtwin.sim.rigs.filling import Filled
from benchtwin.sim.rigs.heap import fill
from benchtwin.sim.rotation import turned

SIZES = {1: (6e-3, 6e-3, 6e-3), 2: (8e-3, 6e-3, 6e-3), 5: (8e-3, 6.5e-3, 6e-3)}
FRICTIONS = (0.0, 0.04, 0.25)
# solid share and contacts a seed: see above; a core of 100 seeds tells them to .01, .15
OF_SPHERES = {0.0: ((0.55, 0.64), (4.0, 6.0))}
OTHERWISE = ((0.50, 0.70), (2.4, 6.0))
BOX = pile.Pile((0.04, 0.04, 0.05), (0.03, 0.05), (0.1, 0.1), 0.04)
EVEN, UPRIGHT = (0.27, 0.45), 0.12  # 4 sd, and what weight does


@dataclass(frozen=True)
class Packing:
    """Of the core of a filling: solid share, contacts a seed, the mean square of their
    vertical components, and the share that stands upright (within 18°)."""

    solid: float
    contacts: float
    vertical2: float
    upright: float

    def is_random(self, spheres: bool, rolling: float) -> bool:
        solid, contacts = OF_SPHERES.get(rolling, OTHERWISE) if spheres else OTHERWISE
        return (
            solid[0] < self.solid < solid[1]
            and contacts[0] < self.contacts < contacts[1]
            and EVEN[0] < self.vertical2 < EVEN[1]
            and self.upright < UPRIGHT
        )


def bench(balls: int, rolling: float) -> Bench:
    """Soft seeds, quick to compute: under 5 cm of them they overlap by .3 %."""
    return Bench(
        seed_seed=replace(SOYBEAN_SOYBEAN, rolling_friction=rolling),
        sizes=SIZES[balls],
        spheres=balls,
        shear_modulus_pa=1e6,
        air_density_kg_m3=0.0,
        laws=NO_AIR,
    )


def filled(vessel: str, of: Bench, seed: int = 1) -> tuple[Filled, np.ndarray]:
    """A filling of the vessel, and the corners of a box within it [m]."""
    rng, one = np.random.default_rng(seed), Ours(1)
    if vessel == "drum":
        rig = drum.Drum(drum_m=(0.1, 0.03))
        box = [(-0.025, -0.009, -0.040), (0.025, 0.009, -0.016)]
        return drum._fill(rig, of, rng, one, no_watch), np.array(box)
    made, box = {
        "box": (
            pile.vessel(
                pile.Pile((0.04, 0.04, 0.05), (0.03, 0.05), (0.1, 0.1), 0.04), of
            ),
            [(0.006, -0.014, 0.006), (0.034, 0.014, 0.034)],
        ),
        "cylinder": (
            cylinder.vessel(LiftedCylinder((0.05, 0.05), (0.2, 0.2), 0.04), of),
            [(-0.013, -0.013, 0.006), (0.013, 0.013, 0.034)],
        ),
        "draw-down": (
            drawdown.vessel(drawdown.Drawdown((0.06, 0.03, 0.1)), of),
            [(0.006, -0.009, 0.006), (0.054, 0.009, 0.054)],
        ),
    }[vessel]
    return fill(made, of, rng, one, no_watch), np.array(box)


def packing_of(filled: Filled, core: np.ndarray) -> Packing:
    """Counted at a hundred thousand points of the core, and at all contacts of seeds
    whose centre lies in it."""
    centres, radii, owner = balls_of(filled)
    low, high = core
    points = np.random.default_rng(0).uniform(low, high, (100_000, 3))
    tree, solid = cKDTree(centres), np.zeros(len(points), bool)
    for radius in np.unique(radii):
        near, _ = cKDTree(centres[radii == radius]).query(points)
        solid |= near < radius
    i, j = tree.query_pairs(2 * radii.max(), output_type="ndarray").T
    apart = centres[j] - centres[i]
    far = np.linalg.norm(apart, axis=1)
    touch = (far < radii[i] + radii[j]) & (owner[i] != owner[j])
    pairs, which = np.unique(
        np.sort(np.column_stack([owner[i], owner[j]])[touch], axis=1),
        axis=0,
        return_index=True,
    )
    upward = (apart[touch, 2] / far[touch])[which]
    at = filled.positions_m
    inside = ((low < at) & (at < high)).all(axis=1)
    of_core = inside[pairs].any(axis=1)
    return Packing(
        float(solid.mean()),
        float(inside[pairs].sum() / inside.sum()),
        float((upward[of_core] ** 2).mean()),
        float((np.abs(upward[of_core]) > np.cos(np.radians(18))).mean()),
    )


def balls_of(filled: Filled) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Centres [m] and radii [m] of all balls, and the seed that each belongs to."""
    seeds = [filled.shapes[k] for k in filled.shape_of]
    centres = [
        x + turned(q, seed.centres_m)
        for seed, x, q in zip(seeds, filled.positions_m, filled.orientations)
    ]
    radii = [np.atleast_1d(seed.radii_m) for seed in seeds]
    owner = np.repeat(np.arange(len(seeds)), [len(r) for r in radii])
    return np.concatenate(centres), np.concatenate(radii), owner


def test_spheres_that_roll_hard_do_not_stand_in_towers():
    found = packing_of(*filled("box", bench(1, 0.04)))
    assert found.is_random(True, 0.04), found


def test_spheres_that_rain_from_a_lattice_stand_in_towers(monkeypatch):
    """The control: what such a rain leaves is told from a random packing."""
    monkeypatch.setattr(filling, "_drawn", _lattice)
    found = packing_of(*filled("box", bench(1, 0.04)))
    assert not found.is_random(True, 0.04)
    assert found.upright > 0.9, found


def _lattice(group: Scattered, count: int, rng: np.random.Generator) -> np.ndarray:
    """A simple cubic one, shaken by 2 % of a radius."""
    low, high = np.asarray(group.low), np.asarray(group.high)
    radius = max(seed.bounding_radius_m for seed in group.shapes)
    per_side = ((high - low) / (2.08 * radius)).astype(int)
    at = np.array(list(np.ndindex(*per_side[::-1])))[:count, ::-1]
    shake = rng.uniform(-0.02, 0.02, at.shape) * radius
    return low + 2.08 * radius * (at + 0.5) + shake


@pytest.mark.slow
@pytest.mark.parametrize("rolling", FRICTIONS)
@pytest.mark.parametrize("balls", sorted(SIZES))
@pytest.mark.parametrize("vessel", ["box", "cylinder", "drum", "draw-down"])
def test_every_filling_is_a_random_packing(vessel, balls, rolling):
    found = packing_of(*filled(vessel, bench(balls, rolling)))
    print(f"{vessel:9} {balls} {rolling:4} {found}")
    assert found.is_random(balls == 1, rolling), found
