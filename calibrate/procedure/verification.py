"""Repeats at the answer, beside the bench: the last step of every rig."""

from collections.abc import Sequence
from dataclasses import replace
from typing import TypeVar

from benchtwin.bench.tells import Reading
from benchtwin.calibrate.procedure.pile import PileFit
from benchtwin.calibrate.procedure.simulator import Run, Simulator, usable
from benchtwin.calibrate.procedure.steel import SteelFit
from benchtwin.calibrate.statistics.bench import verify

Fit = TypeVar("Fit", SteelFit, PileFit)


def verified(fit: Fit, rig: Reading, runs: Sequence[Run], simulate: Simulator) -> Fit:
    """The fit with the runs at its answer beside the bench, and notes of runs that gave
    nothing and where they disagree; without any where there are not two to see scatter.
    """
    if len(runs) < 2:
        return fit
    notes: list[str]
    table = simulate(runs)
    there, notes = usable(table, rig.response)
    values = table.loc[there, rig.response].to_numpy(float)
    found = verify(values, fit.bench, name=rig.name) if values.size > 1 else None
    if found is not None and not found.agrees:
        notes.append(
            f"verification disagrees: {found.simulated:.4g} {rig.unit} simulated,"
            f" {found.bench:.4g} {rig.unit} at the bench (p = {found.p:.2g})"
        )
    return replace(fit, verification=found, notes=(*fit.notes, *notes))
