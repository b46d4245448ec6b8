"""A plate of seeds: seeds of the lot glued to a board in one layer, flat as laid and
turned at random, on which other seeds fall, slide or roll."""

from dataclasses import dataclass, replace

import numpy as np

from benchtwin.bench.section import COVERAGE_LIMITS
from benchtwin.sim.engine.walls import Balls, Rectangle, Wall
from benchtwin.sim.material import Contact, Material
from benchtwin.sim.motion import Part
from benchtwin.sim.rigs.bench import Bench, reach
from benchtwin.sim.rigs.parts import slab
from benchtwin.sim.rotation import about, turned
from benchtwin.sim.seed import Seed

BOARD_M = 5e-3
# of the pitch: how far hands lay a seed from a regular pattern; then pushes by which
# those that overlap make room, until they do by no more than a share of their width
JITTER, PUSHES, PUSH, OVERLAP = 0.25, 300, 0.3, 0.02


@dataclass(frozen=True, eq=False)
class SeedPlate:
    """Glued seeds and where they lie: positions_m (n, 3) of the centres of mass,
    orientations (n, 4); the board's top is at z = 0, from `low` to `high` (x, y)
    [m]."""

    seeds: tuple[Seed, ...]
    positions_m: np.ndarray
    orientations: np.ndarray
    low: tuple[float, float]
    high: tuple[float, float]

    @property
    def top_m(self) -> float:
        """Of the highest seed."""
        return max(
            float(x[2]) + reach(s, q, (0, 0, 1))
            for s, x, q in zip(self.seeds, self.positions_m, self.orientations)
        )

    def board(self, bench: Bench) -> Wall:
        """What the seeds are glued to."""
        (x, y), (far_x, far_y) = self.low, self.high
        along, across = (far_x - x, 0.0, 0.0), (0.0, far_y - y, 0.0)
        return Rectangle("board", bench.wall, (x, y, 0.0), along, across)

    def walls(self, bench: Bench) -> list[Wall]:
        """The board, and each seed as a wall of a material of its own, glued."""
        return [self.board(bench)] + [
            Balls(
                f"seed-{k}", glued(bench.grain), x + turned(q, s.centres_m), s.radii_m
            )
            for k, (s, x, q) in enumerate(
                zip(self.seeds, self.positions_m, self.orientations)
            )
        ]

    def parts(self) -> tuple[Part, ...]:
        """Board and seeds as a camera sees them."""
        (x, y), (far_x, far_y) = self.low, self.high
        poses = np.column_stack([self.positions_m, self.orientations])
        return (
            slab("board", (x, y, -BOARD_M), (far_x, far_y, 0.0)),
            *(
                Part(f"seed-{k}", seed.mesh(), "seed", pose[None])
                for k, (seed, pose) in enumerate(zip(self.seeds, poses))
            ),
        )


def glued(grain: Material) -> Material:
    """The seeds' material, glued to a board."""
    return replace(grain, name=f"glued {grain.name}")


def on_glued(bench: Bench, glue_loss: float = 0.0) -> Contact:
    """What happens between a seed and a glued one: as between seeds, but that the glue
    takes a share of what an impact gives back of the energy, e² less by it."""
    free = bench.seed_seed
    return replace(
        free,
        between=(bench.grain.name, glued(bench.grain).name),
        restitution=free.restitution * float(np.sqrt(1 - glue_loss)),
    )


def laid(
    bench: Bench,
    rng: np.random.Generator,
    coverage: float,
    low: tuple[float, float],
    high: tuple[float, float],
) -> SeedPlate:
    """Seeds of the lot that cover a share of the board, seen from above: of n seeds on
    an area A, n π/4 · length · width / A. ValueError for a coverage that no single
    layer has."""
    least, most = COVERAGE_LIMITS
    if not least <= coverage <= most:
        raise ValueError(
            f"coverage = {coverage:g}: must be {least:g} to {most:g}, the share of the"
            " plate that seeds cover"
        )
    length, width, _ = bench.mean_dimensions_m
    size = np.subtract(high, low)
    count = coverage * size.prod() / (np.pi / 4 * length * width)
    places = _places(rng, size, count, np.sqrt(length * width)) + low
    seeds = bench.draw(rng, len(places))
    turns = np.array(
        [about((0, 0, 1), angle) for angle in rng.uniform(0, 2 * np.pi, len(seeds))]
    )
    heights = [reach(s, q, (0, 0, -1)) for s, q in zip(seeds, turns)]
    return SeedPlate(tuple(seeds), np.column_stack([places, heights]), turns, low, high)


def _places(
    rng: np.random.Generator, size: np.ndarray, count: float, width: float
) -> np.ndarray:
    """Places (n, 2) [m] of about `count` circles of a width on a board of a size, an
    irregular pattern that hardly overlaps; what leaves at one end comes in at the
    other."""
    pitch = np.sqrt(2 / np.sqrt(3) * size.prod() / count)
    columns = max(round(size[0] / pitch), 1)
    rows = max(round(count / columns), 1)
    row, column = np.divmod(np.arange(rows * columns), columns)
    grid = np.column_stack([(column + row % 2 / 2) / columns, (row + 0.5) / rows])
    x = grid * size + rng.normal(0.0, JITTER * pitch, grid.shape)
    for _ in range(PUSHES):
        apart = x[:, None] - x
        apart -= size * np.round(apart / size)
        far = np.linalg.norm(apart, axis=2) + np.diag(np.full(len(x), np.inf))
        over = np.clip(width - far, 0.0, None)
        if over.max() < OVERLAP * width:
            break
        x = x + PUSH * (apart * (over / far)[..., None]).sum(axis=1)
    return x % size
