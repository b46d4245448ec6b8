"""What there is: seeds, walls, materials and their contacts, laws, gravity. A frozen
description; `step.init` makes a state of it."""

import math
from dataclasses import dataclass
from itertools import combinations_with_replacement

import numpy as np

from benchtwin.bench.constants import G_M_S2
from benchtwin.sim.engine import assemble
from benchtwin.sim.engine.bodies import traits
from benchtwin.sim.engine.tiles import COLUMNS
from benchtwin.sim.engine.walls import Wall, WallTables, tabulate
from benchtwin.sim.laws import LAWS
from benchtwin.sim.laws.hertz_mindlin import damping_factor
from benchtwin.sim.laws.law import ALONE, CONTACT_KINDS, Chosen
from benchtwin.sim.material import Contact, Material, effective_moduli, within

Vector = tuple[float, float, float]


@dataclass(frozen=True, eq=False)
class Placed:
    """Seeds put where they are told: seed k has shapes[shape_of[k]]; positions of
    centres of mass (n, 3) [m]; orientations (n, 4) unit quaternions (w, x, y, z) from
    the principal frame; velocities (n, 3) [m/s]; spins (n, 3) [rad/s], world axes."""

    shapes: tuple
    material: Material
    positions: np.ndarray
    orientations: np.ndarray | None = None
    velocities: np.ndarray | None = None
    spins: np.ndarray | None = None
    shape_of: np.ndarray | None = None


@dataclass(frozen=True, eq=False)
class Scattered:
    """`count` seeds in the box low … high, or in the upright cylinder that fits into it
    (`round`), at random places where they do not touch, turned at random, each of a
    shape of `shapes`: that of `shape_of` (count,), or drawn."""

    shapes: tuple
    material: Material
    count: int
    low: Vector
    high: Vector
    velocity: Vector = (0.0, 0.0, 0.0)
    round: bool = False
    shape_of: np.ndarray | None = None


@dataclass(frozen=True, eq=False)
class World:
    """Everything that a run needs to know besides the random generator.

    contacts: one `sim.material.Contact` for each pair of materials that may touch; its
    rolling_convention names the rolling law. laws: chosen plug-ins (`sim.laws`) on top
    of those. domain: (low, high), seeds whose centre leaves it are removed and counted;
    None: no end. time_step_s: None for `rayleigh_fraction` of the smallest ball's
    Rayleigh time, or what a chosen law asks for (`time_step`) if that is less.
    pull_at_end: whether the damped contact force may be attractive at the end of
    contact. True lets e come out as entered; False clips it at zero and e comes out
    larger (.5 → .55; see `sim.laws.hertz_mindlin.damping_factor`).
    share_damping: whether balls of one seed on the same wall or seed share the damping
    (`contacts.shares`). True makes e independent of the number of balls that
    touch; False is EDEM's way, each ball damping with the whole masses, in shorter
    steps. cap_damped:
    whether the caps of friction and rolling take the whole normal force, damping
    included (LAMMPS's way), instead of its elastic part (EDEM's). sleep: seeds that lie
    still are left out until the forces on them change (`sleeping.CALM_FORCE`): a heap
    whose most seeds rest costs less. Of the seeds' push on walls only that of waking
    ones is counted between two looks. Not together with `ledger`. ledger: keep account
    of where the energy goes (`observe.energy`); costs a few per cent. most_overlap: a
    run stops when an overlap exceeds this part of the smaller ball's radius.
    most_speed_m_s: or a seed this speed. most_gain: or all together have more energy
    than before by this share of what is there (`audit`)."""

    seeds: tuple[Placed | Scattered, ...]
    walls: tuple[Wall, ...] = ()
    contacts: tuple[Contact, ...] = ()
    laws: tuple[Chosen, ...] = ()
    gravity: Vector = (0.0, 0.0, -G_M_S2)
    domain: tuple[Vector, Vector] | None = None
    time_step_s: float | None = None
    rayleigh_fraction: float = 0.2
    pull_at_end: bool = True
    share_damping: bool = True
    cap_damped: bool = False
    sleep: bool = False
    ledger: bool = False
    most_overlap: float = 0.1
    most_speed_m_s: float = 1000.0
    most_gain: float = 0.01

    def __post_init__(self):
        if not self.seeds:
            raise ValueError(
                "seeds: a world needs at least one group of seeds (Placed or Scattered)"
            )
        if self.sleep and self.ledger:
            raise ValueError(
                "ledger: energies are those of all contacts, and sleeping seeds' are"
                " left out; say sleep = False"
            )
        _finite("gravity", self.gravity, 3)
        if self.domain is not None and not all(
            a < b for a, b in zip(*self.domain, strict=True)
        ):
            raise ValueError(
                f"domain: low = {self.domain[0]} must be below high = {self.domain[1]}"
                " along every axis"
            )
        if self.time_step_s is not None:
            within("time_step_s", self.time_step_s, 1e-12, 1.0, "s")
        within("rayleigh_fraction", self.rayleigh_fraction, 1e-4, 0.5, "")
        within("most_overlap", self.most_overlap, 1e-6, 1.0, "of the radius")
        within("most_speed_m_s", self.most_speed_m_s, 1e-3, 1e5, "m/s")
        within("most_gain", self.most_gain, 1e-6, math.inf, "")
        names = [wall.name for wall in self.walls]
        if len(set(names)) < len(names):
            raise ValueError(f"walls: names must differ, not {', '.join(names)}")
        materials = self.materials
        for user in (*self.seeds, *self.walls):
            if materials[user.material.name] != user.material:
                raise ValueError(
                    f"materials: two different ones are called {user.material.name!r}"
                )
        for chosen in self.laws:
            if chosen.law.kind == "motion":
                raise ValueError(
                    f"law {chosen.law.name!r} moves a wall: give it to Slide or Turn of"
                    " that wall, not to laws"
                )
            for name in chosen.between or ():
                if name not in materials:
                    raise ValueError(
                        f"law {chosen.law.name!r}: no seed or wall is made of {name!r},"
                        " named in `between`"
                    )
        for a, b in combinations_with_replacement(materials, 2):
            here = [c.law for c in self.active_laws if c.acts_between(a, b)]
            for kind in ALONE:
                names = [repr(law.name) for law in here if law.kind == kind]
                if len(names) > 1:
                    raise ValueError(
                        f"laws: {len(names)} of kind {kind} between {a} and {b},"
                        f" {' and '.join(names)}: choose one"
                    )

    @property
    def materials(self) -> dict[str, Material]:
        """Every material in this world, by name."""
        return {
            user.material.name: user.material for user in (*self.seeds, *self.walls)
        }

    @property
    def active_laws(self) -> tuple[Chosen, ...]:
        """The rolling laws that the contacts name, then the chosen laws. One chosen in
        `laws` replaces its namesake."""
        conventions = sorted({c.rolling_convention for c in self.contacts})
        named = {c.law.name for c in self.laws}
        rolling = []
        for convention in conventions:
            law = LAWS[f"rolling_{convention}"]
            if law.name not in named:
                pairs = [
                    c.between
                    for c in self.contacts
                    if c.rolling_convention == convention
                ]
                rolling += (
                    [law.use()]
                    if len(conventions) == 1
                    else [law.use(between=pair) for pair in pairs]
                )
        return (*rolling, *self.laws)

    def wall_index(self, name: str) -> int:
        """Row of a wall in per-wall results."""
        for k, wall in enumerate(self.walls):
            if wall.name == name:
                return k
        raise ValueError(
            f"no wall {name!r}; there are"
            f" {', '.join(wall.name for wall in self.walls) or 'none'}"
        )


@dataclass(frozen=True, eq=False)
class Tables:
    """A world as the kernels see it: arrays."""

    # (materials², columns): E*, G*, γ, μ, μ_r, e, then each contact law's switch and
    # parameters
    pairs: np.ndarray
    materials: tuple[str, ...]
    wall_material: np.ndarray
    walls: WallTables
    body_numbers: np.ndarray
    shape: np.ndarray  # (shapes, 9): see `bodies`
    trait: np.ndarray  # (shapes, 2): see `bodies.traits`
    shape_start: np.ndarray
    shape_ball: np.ndarray  # (balls, 4): centre in the principal frame, radius
    shape_material: np.ndarray


def _finite(name: str, values, count: int) -> np.ndarray:
    array = np.asarray(values, float)
    if array.shape != (count,) or not np.isfinite(array).all():
        raise ValueError(f"{name} = {values} must be {count} finite numbers")
    return array


def contact_between(world: World, a: str, b: str) -> Contact:
    """The contact parameters of two materials; ValueError if nobody gave them, or two
    did."""
    found = [c for c in world.contacts if set(c.between) == {a, b}]
    if len(found) != 1:
        raise ValueError(f"contacts: {a}–{b} needs one Contact, there are {len(found)}")
    return found[0]


def restitution_between(world: World, a: str, b: str, speed: float) -> float:
    """Restitution of two materials at an impact's speed [m/s], by the chosen laws."""
    e = contact_between(world, a, b).restitution
    for chosen in world.laws:
        if chosen.law.kind == "restitution" and chosen.acts_between(a, b):
            e = chosen.law.function(speed, e, *chosen.numbers)
    return e


def _pair_table(world: World, names: tuple[str, ...]) -> np.ndarray:
    laws = [c for c in world.active_laws if c.law.kind in CONTACT_KINDS]
    columns = [at.column for at in assemble.places(tuple(c.law for c in laws))]
    placed = list(zip(laws, columns, strict=True))
    width = COLUMNS + sum(1 + len(c.numbers) for c in laws)
    table = np.zeros((len(names) ** 2, width))
    seeds = {group.material.name for group in world.seeds}
    for i, a in enumerate(names):
        for j, b in enumerate(names):
            if a not in seeds and b not in seeds:
                continue  # walls do not meet each other
            row = table[i * len(names) + j]
            row[:COLUMNS] = _pair_numbers(world, a, b)
            for chosen, column in placed:
                row[COLUMNS + column] = float(chosen.acts_between(a, b))
                row[
                    COLUMNS + column + 1 : COLUMNS + column + 1 + len(chosen.numbers)
                ] = chosen.numbers
    return table


def _pair_numbers(world: World, a: str, b: str) -> tuple[float, ...]:
    contact = contact_between(world, a, b)
    young, shear = effective_moduli(world.materials[a], world.materials[b])
    e = contact.restitution
    return (
        young,
        shear,
        damping_factor(e),
        contact.static_friction,
        contact.rolling_friction,
        e,
    )


def _shape_tables(world: World, names: tuple[str, ...]):
    rows, starts, balls, materials = [], [0], [], []
    for group in world.seeds:
        for seed in group.shapes:
            centres = np.asarray(seed.centres_m, float).reshape(-1, 3)
            radii = np.atleast_1d(np.asarray(seed.radii_m, float))
            inertia = np.asarray(seed.inertia_kg_m2, float)
            numbers = np.concatenate([centres.ravel(), radii, inertia, [seed.mass_kg]])
            if (
                not np.isfinite(numbers).all()
                or not (radii > 0).all()
                or not (inertia > 0).all()
                or not seed.mass_kg > 0
            ):
                raise ValueError(
                    "seed: radii_m, inertia_kg_m2 and mass_kg must be finite and > 0,"
                    f" centres_m finite, in {seed}"
                )
            bound = float(np.max(np.linalg.norm(centres, axis=1) + radii))
            diameter = (6.0 * seed.volume_m3 / math.pi) ** (1.0 / 3.0)
            same = float(np.ptp(inertia) <= 1e-9 * inertia.max())
            single = float(len(radii) == 1 and not centres.any())
            mass = seed.mass_kg
            rows.append(
                [*(1.0 / inertia), mass, diameter, bound, same, single, 1.0 / mass]
            )
            balls.append(np.column_stack([centres, radii]))
            starts.append(starts[-1] + len(radii))
            materials.append(names.index(group.material.name))
    return (
        np.array(rows),
        np.array(starts, np.int64),
        np.concatenate(balls),
        np.array(materials, np.uint32),
    )


def tabulate_world(world: World) -> Tables:
    """The arrays of a world, everything in it checked."""
    names = tuple(world.materials)
    shape, start, balls, material = _shape_tables(world, names)
    body = [c.numbers for c in world.active_laws if c.law.kind == "body"]
    return Tables(
        pairs=_pair_table(world, names),
        materials=names,
        wall_material=np.array(
            [names.index(w.material.name) for w in world.walls], np.uint32
        ),
        walls=tabulate(world.walls),
        body_numbers=np.array([v for row in body for v in row], float),
        shape=shape,
        trait=traits(shape),
        shape_start=start,
        shape_ball=balls,
        shape_material=material,
    )
