"""How long a step may be under the laws that are chosen, and what their contacts can
hold."""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import product

import numpy as np

from benchtwin.sim.engine.world import World, restitution_between
from benchtwin.sim.laws.hertz_mindlin import damping_factor, normal_stiffness
from benchtwin.sim.laws.law import Chosen
from benchtwin.sim.material import effective_moduli

# Of a linear contact's time π √(m/k) a fiftieth, of a damper's m/c a tenth, where a
# fifth of the Rayleigh time is taken: the rebound is then right to 0.1 %.
USUAL, OF_CONTACT, OF_DAMPER = 0.2, 1 / 50, 1 / 10
# Of m/c of dashpots side by side that do not share a seed's mass: no accuracy, but from
# .9 on beds of such seeds blow up.
OF_DASHPOTS = 0.7
RAYLEIGH = "the Rayleigh time"
SHARES = np.linspace(0.0, 1.0, 65)[1:]  # of the greatest overlap
BACK = 1 - 1e-6  # of an overlap, by which a slope is taken
MOST_STEPS = 1e9  # a second, hours of computing for one seed
SPEED, SPIN = 1.0, 100.0  # m/s, rad/s: at which damping is looked at
IMPACTS = (0.01, 0.1, 1.0, 10.0)  # m/s: at which restitution is


@dataclass(frozen=True)
class Meeting:
    """Balls of two materials, or of one and a wall: radius R* [m], modulus E* [Pa] and
    least restitution; mass m* [kg], and the greatest overlap that a run allows [m]."""

    of_pair: tuple[float, float, float]
    mass_kg: float
    overlap_m: float


def time_step(world: World) -> float:
    """The step of a run [s]: as given, or the shortest that its balls and laws ask for;
    ValueError for one that would need more than MOST_STEPS a second."""
    if world.time_step_s is not None:
        return world.time_step_s
    steps = longest_steps(world)
    stiffest = min(steps, key=lambda name: steps[name])
    if steps[stiffest] * MOST_STEPS < 1.0:
        raise ValueError(
            f"time step: {stiffest} asks for {steps[stiffest]:.2g} s,"
            f" {1 / steps[stiffest]:.2g} for a second: choose what is softer"
        )
    return steps[stiffest]


def longest_steps(world: World) -> dict[str, float]:
    """The longest step [s] by what asks for it: the Rayleigh time of all balls, and
    every law that pushes or damps."""
    balls = (
        group.material.rayleigh_step_s(float(np.min(seed.radii_m)))
        for group in world.seeds
        for seed in group.shapes
    )
    share = world.rayleigh_fraction
    steps = {RAYLEIGH: share * min(balls)}
    for chosen in world.laws:
        rates = _RATES.get(chosen.law.kind)
        if rates is not None:
            fastest = max(rates(world, chosen), default=0.0)
            steps[f"law {chosen.law.name!r}"] = share / USUAL / max(fastest, 1e-300)
    if not world.share_damping:
        fastest = max(_dashpot_rates(world))
        steps["damping by single balls"] = OF_DASHPOTS / max(fastest, 1e-300)
    return steps


def _dashpot_rates(world: World) -> Iterator[float]:
    """1/s: at which all balls of a seed together damp, each with its whole mass."""
    shapes = [seed for group in world.seeds for seed in group.shapes]
    balls = max(len(np.atleast_1d(seed.radii_m)) for seed in shapes)
    for at in _meetings(world, largest=True):
        radius, modulus, e = at.of_pair
        stiffness = normal_stiffness(at.overlap_m, radius, modulus)
        yield balls * damping_factor(e) * math.sqrt(stiffness / at.mass_kg)


def farthest_reach_m(world: World) -> float:
    """How far apart surfaces may be and still act on each other."""
    reaches = [
        chosen.law.reach(*at.of_pair[:2], *chosen.numbers)
        for chosen in world.laws
        if chosen.law.reach
        for at in _meetings(world, chosen, largest=True)
    ]
    return max(reaches, default=0.0)


def held_j(world: World) -> float:
    """The most that attraction can have given to one contact, and takes back when it
    parts [J]: the work of adhesive laws from their reach on."""
    total = 0.0
    for chosen in world.laws:
        if chosen.law.kind == "normal":
            held = [
                _attraction_j(chosen, meeting)
                for meeting in _meetings(world, chosen, largest=True)
            ]
            total += max(held, default=0.0)
    return total


def _meetings(
    world: World, chosen: Chosen | None = None, *, largest: bool = False
) -> Iterator[Meeting]:
    """All, or those between which a law acts, of the smallest or the largest balls and
    lightest seeds."""
    pick = max if largest else min
    seeds = {
        group.material.name: (
            pick(float(pick(np.atleast_1d(seed.radii_m))) for seed in group.shapes),
            min(seed.mass_kg for seed in group.shapes),
        )
        for group in world.seeds
    }
    for (a, (r, m)), b in product(seeds.items(), world.materials):
        if chosen is None or chosen.acts_between(a, b):
            other, mass = seeds.get(b, (math.inf, math.inf))
            modulus, _ = effective_moduli(world.materials[a], world.materials[b])
            radius, reduced = 1 / (1 / r + 1 / other), 1 / (1 / m + 1 / mass)
            e = min(restitution_between(world, a, b, speed) for speed in IMPACTS)
            yield Meeting((radius, modulus, e), reduced, world.most_overlap * r)


def _normal_rates(world: World, chosen: Chosen) -> Iterator[float]:
    """1/s: of the contact time by the slope of its force, loading and unloading, and of
    what it damps. Where a spring is no stiffer than Hertz's, the Rayleigh time does."""
    for at in _meetings(world, chosen):
        hertz = at.of_pair[:2] if chosen.law.kind == "spring" else (0.0, 0.0)
        for overlap in SHARES * at.overlap_m:
            (rest, *_), memory = chosen.along_normal(overlap, 0.0, at.of_pair)
            for before in (None, memory):
                back, _ = chosen.along_normal(BACK * overlap, 0.0, at.of_pair, before)
                stiffness = (rest - back[0]) / (overlap - BACK * overlap)
                if stiffness > 1.01 * normal_stiffness(overlap, *hertz):
                    yield math.sqrt(stiffness / at.mass_kg) / math.pi / OF_CONTACT
            for speed in (SPEED, -SPEED):
                moving, _ = chosen.along_normal(overlap, speed, at.of_pair)
                yield abs(moving[0] - rest) / SPEED / at.mass_kg / OF_DAMPER


def _body_rates(world: World, chosen: Chosen) -> Iterator[float]:
    """1/s: by which it changes speed and spin of the lightest seeds."""
    for group in world.seeds:
        seed = min(group.shapes, key=lambda seed: seed.mass_kg)
        size = (6.0 * seed.volume_m3 / math.pi) ** (1 / 3)
        scale = np.repeat([SPEED, SPIN], 3)
        inert = np.repeat([seed.mass_kg, float(np.min(seed.inertia_kg_m2))], 3)
        rest = np.array(chosen.law.function(*np.zeros(6), size, *chosen.numbers))
        for k in range(6):
            moving = np.zeros(6)
            moving[k] = scale[k]
            pushed = chosen.law.function(*moving, size, *chosen.numbers)
            change = np.abs(np.array(pushed) - rest)[k // 3 * 3 : k // 3 * 3 + 3]
            yield float(change.max() / scale[k] / inert[k] / OF_DAMPER)


_RATES = {"normal": _normal_rates, "spring": _normal_rates, "body": _body_rates}


def _attraction_j(chosen: Chosen, at: Meeting) -> float:
    """What it gives to surfaces that part after the greatest overlap, taken back."""
    reach = chosen.law.reach or (lambda radius, modulus, *numbers: 0.0)
    overlap = np.linspace(-reach(*at.of_pair[:2], *chosen.numbers), at.overlap_m, 257)
    _, memory = chosen.along_normal(at.overlap_m, 0.0, at.of_pair)
    force = [
        chosen.along_normal(float(o), 0.0, at.of_pair, memory)[0][0] for o in overlap
    ]
    return float(np.trapezoid(np.maximum(-np.array(force), 0.0), overlap))
