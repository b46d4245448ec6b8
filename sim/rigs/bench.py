"""What the four rigs of one bench share: seeds, steel, what happens where they touch,
air, gravity, and how it is computed."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any, TypedDict

import numpy as np
from numpy.typing import ArrayLike

from benchtwin.bench.constants import G_M_S2
from benchtwin.sim.engine.state import State
from benchtwin.sim.engine.walls import Slide, Vector, Wall
from benchtwin.sim.engine.world import Placed, Scattered, World
from benchtwin.sim.laws import LAWS, Chosen
from benchtwin.sim.material import (
    Q235,
    SOYBEAN,
    SOYBEAN_Q235,
    SOYBEAN_SOYBEAN,
    Contact,
    Material,
)
from benchtwin.sim.rotation import turned
from benchtwin.sim.seed import Seed
from benchtwin.sim.seed.lot import Lot
from benchtwin.sim.seed.sizes import SOYBEAN as SOYBEAN_SIZES
from benchtwin.sim.seed.sizes import Sizes

# sizes in a heap: as many as callipers measured; each is meshed once for the picture
DIFFERENT = 100

Watch = Callable[[str, float], None]  # (stage, share of it that is done)


@dataclass(frozen=True)
class Bench:
    """One pair of materials on a bench.

    sizes: how the sizes of ellipsoids scatter (`sim.seed.sizes.Sizes`), one (length,
    width, thickness) [m] for every seed, or a lot measured seed by seed
    (`sim.seed.lot.Lot`). spheres, arrangement, mass_of: of ellipsoids, as in
    `Seed.from_dimensions`; density_kg_m3 of the seeds. shear_modulus_pa: what the
    seeds' modulus is softened to, None for the real one. inertia_factor: I/(m r²) as
    the seed rolls across its length, r its mean half width, where it is not that of a
    solid one (a shell: 2/3); the other moments go with it. air_density_kg_m3: 0 leaves
    the air out. laws: plug- ins besides the contacts' own and drag. rayleigh_fraction,
    pull_at_end, share_damping, cap_damped: as in `World`. sleep: so too, of heaps."""

    seed_wall: Contact = SOYBEAN_Q235
    seed_seed: Contact = SOYBEAN_SOYBEAN
    seed: Material = SOYBEAN
    wall: Material = Q235
    sizes: Sizes | tuple[float, float, float] | Lot = SOYBEAN_SIZES
    spheres: int = 5
    arrangement: str = "axial"
    mass_of: str = "union"
    inertia_factor: float | None = None
    shear_modulus_pa: float | None = 3.0e7
    air_density_kg_m3: float = 1.20
    air_viscosity_pa_s: float = 1.81e-5
    laws: tuple[Chosen, ...] = ()
    rayleigh_fraction: float = 0.2
    pull_at_end: bool = True
    share_damping: bool = True
    cap_damped: bool = False
    sleep: bool = True

    @property
    def grain(self) -> Material:
        """The seeds' material as it is computed with."""
        if (
            self.shear_modulus_pa is None
            or self.shear_modulus_pa >= self.seed.shear_modulus_pa
        ):
            return self.seed
        return self.seed.softened(self.shear_modulus_pa)

    def draw(self, rng: np.random.Generator, count: int) -> list[Seed]:
        """`count` seeds, of at most DIFFERENT sizes unless a lot has more: seeds of one
        size are one object."""
        if isinstance(self.sizes, Lot):
            return Lot(tuple(self._hollow(seed) for seed in self.sizes.seeds)).draw(
                rng, count
            )
        how: dict[str, Any] = {
            "spheres": self.spheres,
            "density_kg_m3": self.seed.density_kg_m3,
            "arrangement": self.arrangement,
            "mass_of": self.mass_of,
        }
        if isinstance(self.sizes, Sizes):
            lot = [
                self._hollow(seed)
                for seed in self.sizes.sample_batch(rng, min(count, DIFFERENT), **how)
            ]
            return [lot[k % len(lot)] for k in range(count)]
        return [self._hollow(Seed.from_dimensions(*self.sizes, **how))] * count

    @property
    def mean_dimensions_m(self) -> tuple[float, float, float]:
        """Mean length, width and thickness of the seeds [m]."""
        if isinstance(self.sizes, Sizes):
            sizes = self.sizes
            return (sizes.length.mean_m, sizes.width.mean_m, sizes.thickness.mean_m)
        if isinstance(self.sizes, Lot):
            length, width, thickness = (
                float(v) for v in self.sizes.dimensions_m.mean(axis=0)
            )
            return length, width, thickness
        return self.sizes

    def mean_seed(self) -> Seed:
        """A seed of the mean dimensions; of a lot, the one nearest to them."""
        if isinstance(self.sizes, Lot):
            return self._hollow(self.sizes.typical())
        return replace(self, sizes=self.mean_dimensions_m).draw(
            np.random.default_rng(0), 1
        )[0]

    def _hollow(self, seed: Seed) -> Seed:
        """The seed with the stated inertia."""
        if self.inertia_factor is None or seed.dimensions_m is None:
            return seed
        half_width = float(seed.dimensions_m[1:].mean() / 2)
        wanted = self.inertia_factor * seed.mass_kg * half_width**2
        return replace(
            seed, inertia_kg_m2=seed.inertia_kg_m2 * wanted / seed.inertia_kg_m2[0]
        )

    def world(
        self,
        seeds: Placed | Scattered,
        walls: Sequence[Wall],
        *,
        domain: tuple[Vector, Vector] | None = None,
        contacts: Sequence[Contact] = (),
        **options: Any,
    ) -> World:
        """Seeds and walls under this bench's gravity, air, contacts and laws.

        Where no wall moves, the first is given a law by which it stands: the step loop
        is compiled (half a minute) for a set of laws, and so it is the same for all
        rigs."""
        laws, walls = self.laws, list(walls)
        if not any(wall.moves for wall in walls):
            moves = (Slide(LAWS["motion_steady"].use(rate=0.0), (0.0, 0.0, 1.0)),)
            walls[0] = replace(walls[0], moves=moves)
        if self.air_density_kg_m3 > 0 and not any(c.law.name == "drag" for c in laws):
            density, viscosity = self.air_density_kg_m3, self.air_viscosity_pa_s
            laws = (LAWS["drag"].use(air_density=density, viscosity=viscosity), *laws)
        return World(
            (seeds,),
            tuple(walls),
            (self.seed_wall, self.seed_seed, *contacts),
            laws,
            (0.0, 0.0, -G_M_S2),
            domain,
            rayleigh_fraction=self.rayleigh_fraction,
            pull_at_end=self.pull_at_end,
            share_damping=self.share_damping,
            cap_damped=self.cap_damped,
            **options,
        )


def no_watch(stage: str, share: float) -> None:
    """Nobody looks on."""


class Columns(TypedDict):
    """The moving columns of a `Motion`."""

    t_s: np.ndarray
    positions_m: np.ndarray
    orientations: np.ndarray
    velocities_m_s: np.ndarray
    spins_rad_s: np.ndarray


class Frames:
    """An observer for `Every(1/fps, …)`: where the seeds are at multiples of 1/fps [s],
    in the order of `init`.

    The engine looks at the nearest step; the rest of the way, at most half a step, is
    made up for at the seed's own speed."""

    def __init__(self, count: int, fps: float, begin_s: float = 0.0) -> None:
        self.count, self.fps, self.begin_s = count, fps, begin_s
        self.t_s: list[float] = []
        self.rows: list[tuple[np.ndarray, ...]] = []

    def __call__(self, world: World, state: State) -> None:
        self.take(state, round(state.time_s * self.fps) / self.fps)

    def take(self, state: State, exact: float) -> None:
        """Keep the places of this state as those of the moment `exact` [s]."""
        self.t_s.append(exact - self.begin_s)
        row = [np.full((self.count, width), np.nan) for width in (3, 4, 3, 3)]
        which = np.sort(state.ids)
        values = (
            state.positions + (exact - state.time_s) * state.velocities,
            state.orientations,
            state.velocities,
            state.spins,
        )
        for column, value in zip(row, values, strict=True):
            column[which] = value
        self.rows.append(tuple(row))

    def columns(self) -> Columns:
        """All that was kept."""
        x, q, v, w = (np.stack(column) for column in zip(*self.rows, strict=True))
        t_s = np.array(self.t_s)
        return Columns(
            t_s=t_s, positions_m=x, orientations=q, velocities_m_s=v, spins_rad_s=w
        )


def reach(seed: Seed, q: np.ndarray, direction: ArrayLike) -> float:
    """How far [m] the turned seed's balls reach from its centre of mass along a unit
    direction."""
    return float(
        np.max(turned(q, seed.centres_m) @ np.asarray(direction, float) + seed.radii_m)
    )
