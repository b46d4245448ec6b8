"""The steps of a publication (`calibrate --method surface`, `--tables`): steepest
ascent, Box–Behnken design, response surface, analysis of variance, optimum."""

from dataclasses import dataclass, replace

import numpy as np
import pandas as pd

from benchtwin.bench.language import tr
from benchtwin.calibrate.procedure.observed import PileObservables, observed
from benchtwin.calibrate.procedure.pile_stage import PileStage
from benchtwin.calibrate.procedure.rigs import PILE
from benchtwin.calibrate.procedure.simulator import usable
from benchtwin.calibrate.statistics.ascent import Centre, choose_centre, equal_steps
from benchtwin.calibrate.statistics.bench import BenchMean
from benchtwin.calibrate.statistics.box import Box
from benchtwin.calibrate.statistics.designs import box_behnken
from benchtwin.calibrate.statistics.optimum import Optimum, optimum
from benchtwin.calibrate.statistics.surface import (
    Surface,
    anova_table,
    coefficients,
    contributions,
    fit_surface,
    quality,
    residual_table,
)

STEPS = 6  # groups of the path, the paper's
# share of a design's runs: with fewer it is another design
USABLE = 0.8
# first packing number of the path and of the design
PATH_PACKINGS, DESIGN_PACKINGS = 0, 100


@dataclass(frozen=True, kw_only=True, eq=False)
class SurfaceFit:
    """What the steps of a publication give of the piles' angle.

    path: steepest ascent and the levels it chose; design: the runs, factors in natural
    units; optimum: of the many points that give the bench's angle one; notes."""

    bench: BenchMean
    box: Box
    design: pd.DataFrame
    surface: Surface
    coefficients: pd.DataFrame
    anova: pd.DataFrame
    quality: pd.DataFrame
    contributions: pd.DataFrame
    residuals: pd.DataFrame
    optimum: Optimum
    notes: tuple[str, ...]
    path: Centre | None = None


def fit_pile(
    design: pd.DataFrame,
    box: Box,
    bench: BenchMean,
    *,
    near: dict[str, float] | None = None,
) -> SurfaceFit:
    """Surface through the design's runs and everything read from it.

    near: of the many points that give the bench's angle the one nearest to this is the
    optimum, by default to the box's centre. Raises ValueError as `fit_surface`
    (singular designs …)."""
    surface = fit_surface(design, PILE.response, box)
    table, taken = anova_table(surface), optimum(surface, bench.value, near=near)
    return SurfaceFit(
        bench=bench,
        box=box,
        design=design,
        surface=surface,
        coefficients=coefficients(surface),
        anova=table,
        quality=quality(surface),
        contributions=contributions(table, len(box.names)),
        residuals=residual_table(surface),
        optimum=taken,
        notes=(taken.statement,),
    )


def simulate_surface(stage: PileStage) -> tuple[SurfaceFit, PileObservables]:
    """Path, design and fit on simulated piles; and what the same piles say in the
    posterior. ValueError, SimulationFailed."""
    if stage.readings is None:
        raise ValueError(tr("{}: the bench has no recording of it", PILE.name))
    target = float(stage.readings.values.mean())
    steps = equal_steps(stage.box, STEPS)
    table, walked = stage.piles(steps, PATH_PACKINGS)
    there, notes = usable(table, PILE.response)
    angles = table[PILE.response].where(there).to_numpy()
    done = steps.assign(**{PILE.response: angles}).dropna(subset=PILE.response)
    centre = choose_centre(done, PILE.response, target, stage.box.names)
    by = centre.levels.set_index("coded")[list(stage.box.names)]
    levels = Box(stage.box.names, *by.loc[[-1, 1]].to_numpy(float))
    design = box_behnken(levels, centre_points=stage.effort.centre)
    table, runs = stage.piles(design, DESIGN_PACKINGS)
    there, lost = usable(table, PILE.response, least=USABLE)
    design = design.assign(**{PILE.response: table[PILE.response]})[there]
    piles = pd.concat([walked, runs], ignore_index=True)
    seen = observed(piles, stage.readings, levels, None, alike=stage.alike)
    bench = seen.bench if seen.observables else stage.readings.mean()
    fit = fit_pile(design.reset_index(drop=True), levels, bench)
    said = dict.fromkeys((*notes, *lost, *seen.notes, *fit.notes))
    return replace(fit, path=centre, notes=tuple(said)), seen


def angle_alone(fit: SurfaceFit) -> PileObservables:
    """What a design of which only the angle is known says in the posterior."""
    from benchtwin.calibrate.statistics.posterior import Observable
    from benchtwin.calibrate.statistics.surrogate import fit_surrogate

    name = f"{PILE.name}: {PILE.response}"
    surrogate = fit_surrogate(fit.design, PILE.response, fit.box)
    return PileObservables(
        observables=(Observable(name, surrogate, fit.bench),),
        box=fit.box,
        correlation=pd.DataFrame(np.eye(1), index=[name], columns=[name]),
        runs=fit.design,
    )
