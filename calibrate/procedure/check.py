"""The predictive check: every rig simulated at the most probable set, each thing seen
beside the bench."""

from collections.abc import Mapping

import pandas as pd

from benchtwin.calibrate.procedure.observed import (
    PileObservables,
    simulated_column,
    with_ratios,
)
from benchtwin.calibrate.procedure.pile_stage import PileStage
from benchtwin.calibrate.procedure.steel import SteelFit, SteelStage
from benchtwin.calibrate.statistics.bench import Verification, verify

CHECK_PACKINGS = 1000  # first packing number: none that was fitted


def check_steel(
    stage: SteelStage, fit: SteelFit, at: Mapping[str, float]
) -> dict[str, Verification]:
    """{observable: simulations at `at` beside the bench} of a seed–steel rig; nothing
    where there are not two runs to see scatter."""
    many = stage.effort.check
    runs = stage.runs([at[stage.rig.parameter]], many, "check")
    return _beside(stage.simulate(runs), {stage.rig.response: fit.observable})


def check_seeds(
    stage: PileStage, seen: PileObservables, at: Mapping[str, float]
) -> dict[str, Verification]:
    """{observable: simulations at `at` beside the bench} of a rig that tells of seed on
    seed."""
    points = pd.DataFrame([dict(at)] * stage.effort.check)
    table, _ = stage.piles(points, CHECK_PACKINGS)
    table = with_ratios(table, stage.rig)
    return _beside(table, dict(zip(seen.used, seen.observables)))


def _beside(table: pd.DataFrame, of: Mapping) -> dict[str, Verification]:
    found, done = {}, table["status"].eq("done")
    for column, observable in of.items():
        source = simulated_column(table, column)
        if source not in table:
            continue
        values = table[source].where(done).dropna()
        if len(values) > 1:
            name = observable.name
            found[name] = verify(values.to_numpy(float), observable.bench, name=name)
    return found
