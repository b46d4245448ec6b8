"""What the simulations of a rig that tells of seed on seed need, and how it is run."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Self

import numpy as np
import pandas as pd

from benchtwin.bench.tells import Believed, BySurface
from benchtwin.calibrate.procedure.bench import RigReadings
from benchtwin.calibrate.procedure.effort import Effort
from benchtwin.calibrate.procedure.rigs import PILE
from benchtwin.calibrate.procedure.simulator import Run, Simulator, seed_numbers
from benchtwin.calibrate.statistics.box import Box


@dataclass(frozen=True, kw_only=True, eq=False)
class PileStage:
    """What the simulations of the piles, or of another `rig`, need. readings: of the
    bench, None where it has none; fixed: seed–steel parameters; box: of the seed–seed
    ones; steel: seed–steel parameters that vary along; steel_found: their (value, sd)
    from their own rigs; left_open: keys of the rig's section that vary along with them;
    notes: where another pile is simulated than the bench's."""

    readings: RigReadings | None
    fixed: dict[str, float]
    description: dict
    simulate: Simulator
    effort: Effort
    seed: int
    box: Box
    steel: Box | None = None
    steel_found: dict[str, tuple[float, float]] = field(default_factory=dict)
    notes: tuple[str, ...] = ()
    rig: BySurface = PILE
    left_open: Mapping[str, Believed] = field(default_factory=dict)

    def varying(self, keys: Mapping[str, Believed]) -> Self:
        """With keys of the rig's section that vary along as seed–steel parameters
        do."""
        if not keys:
            return self
        box = Box.of({name: key.ends for name, key in keys.items()})
        return replace(
            self,
            steel=box if self.steel is None else self.steel.with_factors(box),
            fixed={**self.fixed, **{n: key.mean for n, key in keys.items()}},
            steel_found={
                **self.steel_found,
                **{n: (key.mean, key.sd) for n, key in keys.items()},
            },
            left_open=keys,
        )

    @property
    def alike(self) -> bool:
        """Whether the bench's pile is simulated as it is."""
        return not self.notes

    @property
    def wide(self) -> Box:
        """All that varies: seed–seed parameters first."""
        return self.box.with_factors(self.steel)

    @property
    def middle(self) -> dict[str, float]:
        """Seed–steel parameters of piles that do not vary them."""
        if self.steel is None:
            return self.fixed
        return self.fixed | dict(zip(self.steel.names, map(float, self.steel.centre)))

    def values(self, points: pd.DataFrame) -> pd.DataFrame:
        """All parameters, a row a row of `points`: those that it names, in natural
        units, the others in the middle."""
        known = [n for n in (*self.box.names, *self.fixed) if n in points]
        values = points[known].reset_index(drop=True)
        rest = {n: v for n, v in self.middle.items() if n not in values}
        return values.assign(**rest)

    def runs(self, points: pd.DataFrame, packings: np.ndarray) -> list[Run]:
        """One pile a row of `points` on that row's packing."""
        return [
            self._run({str(n): float(v) for n, v in row.items()}, packing)
            for row, packing in zip(self.values(points).to_dict("records"), packings)
        ]

    def _run(self, values: dict[str, float], packing: int) -> Run:
        name, described = self.rig.rig.name, self.description
        keys = {n.rpartition(".")[2]: values.pop(n) for n in self.left_open}
        if keys:
            described = described | {name: described.get(name, {}) | keys}
        rng = seed_numbers(self.seed, self.rig.name, packing)
        return Run(name, values, rng, described)

    def piles(
        self, points: pd.DataFrame, first: int
    ) -> tuple[pd.DataFrame, pd.DataFrame]:
        """The table of these runs, on packings numbered from `first`; and of those that
        were measured parameters, runs and packing, which is what a surface is laid
        through."""
        packings = first + np.arange(len(points))
        table = self.simulate(self.runs(points, packings)).reset_index(drop=True)
        there = table["status"].eq("done")
        done = pd.concat([self.values(points), table], axis=1)[there]
        return table, done.assign(packing=packings[there])
