"""What the simulations of a pile need, and how a pile is run."""

from dataclasses import dataclass, field

import numpy as np
import pandas as pd
from benchtwin.calibrate.procedure.bench import RigReadings
from benchtwin.calibrate.procedure.effort import Effort
from benchtwin.calibrate.procedure.simulator import Run, Simulator, seed_numbers
from benchtwin.calibrate.statistics.box import Box

RANGES = {
    "seed_restitution": (0.45, 0.70),
    "seed_static_friction": (0.20, 0.70),
    "seed_rolling_friction": (0.01, 0.06),
}


@dataclass(frozen=True)
class PileStage:
    """What the pile's simulations need. fixed: seed–steel parameters; ranges: of the
    factors, for the path; path: one that is prescribed, group and the factors; levels:
    a box that is prescribed instead of the path's; near: the point of the sheet to
    report; steel: seed–steel parameters that vary along in the design; steel_found:
    their (value, sd) from their own rigs; alike: whether the bench's pile is simulated
    as it is; done: every pile run so far, for the surrogate."""

    readings: RigReadings
    fixed: dict[str, float]
    description: dict
    simulate: Simulator
    effort: Effort
    seed: int
    ranges: dict[str, tuple[float, float]]
    levels: Box | None = None
    near: dict[str, float] | None = None
    steel: Box | None = None
    steel_found: dict[str, tuple[float, float]] = field(default_factory=dict)
    alike: bool = True
    path: pd.DataFrame | None = None
    done: list[pd.DataFrame] = field(default_factory=list)

    @property
    def middle(self) -> dict[str, float]:
        """Seed–steel parameters of piles that do not vary them."""
        return (
            self.fixed
            if self.steel is None
            else self.fixed | dict(zip(self.steel.names, map(float, self.steel.centre)))
        )

    def piles(
        self, points: pd.DataFrame, packings, *, keep: bool = True
    ) -> pd.DataFrame:
        """One pile a row of `points` (factors in natural units, and seed–steel
        parameters where they are not the middle ones) on that row's packing; the table
        of runs. keep: for the surrogate too."""
        packings = np.asarray(packings)
        values = points[
            [n for n in (*self.ranges, *self.fixed) if n in points]
        ].reset_index(drop=True)
        values = values.assign(
            **{n: v for n, v in self.middle.items() if n not in values}
        )
        runs = [
            Run(
                "pile",
                {n: float(v) for n, v in row.items()},
                seed_numbers(self.seed, "pile", p),
                self.description,
            )
            for row, p in zip(values.to_dict("records"), packings)
        ]
        table = self.simulate(runs).reset_index(drop=True)
        if keep:
            there = table["status"].eq("done")
            self.done.append(
                pd.concat([values, table], axis=1)[there].assign(
                    packing=packings[there]
                )
            )
        return table
