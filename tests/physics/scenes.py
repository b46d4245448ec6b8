"""Small worlds for the physics tests: a ball or a clump over a floor, plain materials,
one compiled kernel for all of them."""

import math

import numpy as np

from benchtwin.sim.engine.step import init, run
from benchtwin.sim.engine.walls import Plane
from benchtwin.sim.engine.world import Placed, World
from benchtwin.sim.laws import LAWS
from benchtwin.sim.material import Contact, Material
from benchtwin.sim.seed import Seed

# A drag that is zero. The step loop is compiled for each set of laws, which takes half
# a minute: a world with this drag has the rigs' set.
NO_AIR = (LAWS["drag"].use(factor=0.0),)
RIGID = Material(
    "rigid", 8000.0, 1e12, 0.0
)  # as rigid as a material may be: 1/E* of the partner changes by less than 1e-3 here


def ball(radius: float, density: float) -> Seed:
    return Seed.from_spheres([[0.0, 0.0, 0.0]], [radius], density)


def flat_clump(
    radius: float, density: float, balls: int = 5, pitch: float = 1.0
) -> Seed:
    """Equal balls in a row along x, `pitch` radii apart: lying flat, all touch a floor
    at once."""
    x = (np.arange(balls) - (balls - 1) / 2) * pitch * radius
    return Seed.from_spheres(
        np.column_stack([x, 0 * x, 0 * x]), [radius] * balls, density
    )


def ball_like_clump(radius: float, density: float) -> Seed:
    """Five balls that make, to a hundredth of a radius, one ball: a centre and four
    around it; mass and inertia of the ball."""
    d = 0.01 * radius
    centres = [[0, 0, 0], [d, 0, 0], [-d, 0, 0], [0, d, 0], [0, -d, 0]]
    return Seed.from_spheres(centres, [radius] + [0.995 * radius] * 4, density)


def own(
    material: Material, e: float = 0.5, mu: float = 0.3, mu_r: float = 0.0
) -> Contact:
    return Contact((material.name, material.name), e, mu, mu_r)


def on_floor(
    seed, material, *, e, mu, mu_r=0.0, floor=RIGID, normal=(0, 0, 1), **options
) -> World:
    """One group of seeds over a plane through the origin. options go to Placed
    (positions, velocities, spins …) and World."""
    names = ("positions", "orientations", "velocities", "spins", "shape_of")
    placed = {k: np.asarray(options.pop(k), float) for k in names if k in options}
    contacts = (
        Contact((material.name, floor.name), e, mu, mu_r),
        own(material, e, mu, mu_r),
    )
    walls = (Plane("floor", floor, (0, 0, 0), normal),)
    return World((Placed((seed,), material, **placed),), walls, contacts, **options)


def go(world: World, until, **options):
    return run(world, init(world, np.random.default_rng(0)), until, **options)


def hertz(modulus, radius, mass, speed):
    """Largest force, overlap, and time of an elastic impact; effective values."""
    overlap = (15 * mass * speed**2 / (16 * modulus * math.sqrt(radius))) ** 0.4
    return (
        4 / 3 * modulus * math.sqrt(radius) * overlap**1.5,
        overlap,
        2.943275 * overlap / speed,
    )
