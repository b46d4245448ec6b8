"""Seed on seed: from the piles of a design to the response surface, its optimum, and
all that the optimum hides."""

from dataclasses import dataclass

import numpy as np
import pandas as pd

from benchtwin.calibrate.procedure.pile_surrogate import PileObservables
from benchtwin.calibrate.procedure.rigs import PILE
from benchtwin.calibrate.statistics.anova import anova_table, contributions
from benchtwin.calibrate.statistics.ascent import Centre
from benchtwin.calibrate.statistics.assessment import Quality, coefficients, quality
from benchtwin.calibrate.statistics.bench import BenchMean, Verification
from benchtwin.calibrate.statistics.box import Box
from benchtwin.calibrate.statistics.next_test import BenchTest
from benchtwin.calibrate.statistics.optimum import (
    Optimum,
    SolutionSet,
    optimum,
    solution_set,
)
from benchtwin.calibrate.statistics.reduction import Reduction, reduce
from benchtwin.calibrate.statistics.replicates import Noise, Pairing, Plan
from benchtwin.calibrate.statistics.residuals import (
    Normality,
    normality,
    residual_table,
)
from benchtwin.calibrate.statistics.surface import Surface, fit_surface

ALPHA = 0.05  # the paper's level


@dataclass(frozen=True, kw_only=True, eq=False)
class PileFit:
    """The seed–seed parameters that a pile leaves possible.

    path: steepest ascent and the levels it chose; noise, pairing, plan: packing noise,
    what common packings save, replicates; design: the runs, factors in natural units;
    optimum: the point that is reported, central: the one nearest to the box's centre;
    sheet: all points that give the bench's angle; verification: repeats at the optimum;
    informative: what else of the bench's piles shows, beyond packing noise, what the
    parameters do (`filled_mass_g` …); seen: what stands for the piles in the posterior,
    None for the angle's surface alone; to_read: what else the same piles show."""

    bench: BenchMean
    box: Box
    design: pd.DataFrame
    surface: Surface
    coefficients: pd.DataFrame
    anova: pd.DataFrame
    quality: Quality
    contributions: pd.DataFrame
    reduction: Reduction
    residuals: pd.DataFrame
    normality: Normality | None
    optimum: Optimum
    central: Optimum
    sheet: SolutionSet
    notes: tuple[str, ...]
    path: Centre | None = None
    noise: Noise | None = None
    pairing: Pairing | None = None
    plan: Plan | None = None
    verification: Verification | None = None
    informative: tuple[str, ...] = ()
    seen: PileObservables | None = None
    to_read: tuple[BenchTest, ...] = ()

    @property
    def weak(self) -> bool:
        """Whether the runs do not show that the factors do anything at all."""
        return not model_p(self.anova) < ALPHA

    @property
    def findings(self) -> list[str]:
        """Notes that are findings for a diagnosis."""
        return [note for note in self.notes if note.startswith("finding")]


def fit_pile(
    design: pd.DataFrame,
    box: Box,
    bench: BenchMean,
    *,
    rng: np.random.Generator,
    near: dict[str, float] | None = None,
    packing: str | None = None,
) -> PileFit:
    """Surface through the design's runs and everything read from it.

    near: of the many points that give the bench's angle the one nearest to this is
    reported, by default to the box's centre. Raises ValueError as `fit_surface`
    (singular designs …)."""
    surface = fit_surface(design, PILE.response, box, packing=packing)
    table = anova_table(surface)
    central = optimum(surface, bench.value)
    taken = optimum(surface, bench.value, near=near) if near else central
    return PileFit(
        bench=bench,
        box=box,
        design=design,
        surface=surface,
        coefficients=coefficients(surface),
        anova=table,
        quality=quality(surface),
        contributions=contributions(table, len(box.names)),
        reduction=reduce(surface),
        residuals=residual_table(surface),
        normality=_normality(surface),
        optimum=taken,
        central=central,
        sheet=solution_set(surface, bench.value, rng=rng, band_sd=bench.sd),
        notes=tuple(_notes(surface, taken, bench, model_p(table))),
    )


def _normality(surface: Surface) -> Normality | None:
    try:
        return normality(surface)
    except ValueError:
        return None


def model_p(anova: pd.DataFrame) -> float:
    """p of the whole surface against its residual."""
    return float(anova["p"].iloc[0])


def _notes(surface: Surface, taken: Optimum, bench: BenchMean, p: float) -> list[str]:
    """Where the optimum stands, whether packing noise hides the surface, whose p is
    given, and lack of fit."""
    notes = [taken.statement]
    if taken.outcome != "reached":
        low, high = taken.reachable
        notes.append(
            f"finding for diagnosis: the bench's {bench.value:.4g}° lies outside"
            f" {low:.4g} to {high:.4g}°, all that the box gives"
        )
    if not p < ALPHA:
        notes.append(
            "packing noise hides what the parameters do (the whole surface has p ="
            f" {p:.2g}): more piles a point are needed"
        )
    if surface.lack_sd:
        notes.append(
            f"lack of fit: the quadratic is off by about {surface.lack_sd:.2g}° beyond"
            " noise; it is in all intervals"
        )
    return notes
