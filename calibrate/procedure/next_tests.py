"""Which test to run next for the parameters of seed on seed."""

from collections.abc import Mapping, Sequence

import numpy as np
import pandas as pd

from benchtwin.bench.tells import BySurface
from benchtwin.calibrate.procedure.pile_surrogate import (
    PileObservables,
    correlation_of,
    surface_through,
)
from benchtwin.calibrate.procedure.rigs import BESIDE, PILE
from benchtwin.calibrate.statistics.box import Box
from benchtwin.calibrate.statistics.next_test import BenchTest, what_next
from benchtwin.calibrate.statistics.posterior import Posterior
from benchtwin.calibrate.statistics.shrinkage import ShrinkageSurface, shrink

MINUTES = 20.0  # of a rig's test: an afternoon's repeats
MOST_SAID = 3  # tests, each together with those said before it
LEAST_GAIN = 0.01  # of the variance, for a test to be worth a word


def recorded_test(name: str, seen: PileObservables) -> BenchTest | None:
    """More of what the bench has recorded already."""
    surfaces = [
        o.surrogate
        for o in seen.observables
        if isinstance(o.surrogate, ShrinkageSurface)
    ]
    if not surfaces or len(surfaces) < len(seen.observables):
        return None
    rig = PILE if name == PILE.name else BESIDE[name]
    return _test(rig, surfaces, seen.correlation)


def unrecorded_test(
    rig: BySurface, runs: pd.DataFrame, box: Box, steel: Box | None
) -> BenchTest | None:
    """What the bench has none of, from simulated runs of it; None where they show
    nothing."""
    wide, surfaces, errors = box.with_factors(steel), [], {}
    for column in (*rig.rig.readings, *rig.rig.weighed):
        source = column if column in runs else f"true_{column}"
        if source not in runs or runs[source].nunique() < 2:
            continue
        there = runs[runs[source].notna()]
        through, _ = surface_through(there, source, wide, len(box.names), None)
        surfaces.append(shrink(through))
        errors[column] = pd.Series(surfaces[-1].residuals, index=there.index)
    return _test(rig, surfaces, correlation_of(errors)) if surfaces else None


def _test(
    rig: BySurface, surfaces: Sequence[ShrinkageSurface], correlation: pd.DataFrame
) -> BenchTest:
    sd = np.array([s.noise_sd for s in surfaces])
    scatter = np.outer(sd, sd) * correlation.to_numpy()
    runs = max(int(MINUTES // rig.minutes), 1)
    name, minutes = f"more {rig.in_plural}", runs * rig.minutes
    return BenchTest(name, tuple(surfaces), scatter / runs, runs, minutes)


def next_tests(
    posterior: Posterior,
    seen: Mapping[str, PileObservables],
    others: Sequence[BenchTest],
    of: Sequence[str],
) -> pd.DataFrame:
    """What each test would leave of the factors `of`: `MINUTES` more of those that the
    bench has recorded, and `others`."""
    own = [recorded_test(name, one) for name, one in seen.items()]
    known = set(posterior.draws.columns)
    tests = [
        test
        for test in (*own, *others)
        if test is not None and all(set(s.box.names) <= known for s in test.surrogates)
    ]
    return what_next(posterior, tests, of) if tests else pd.DataFrame()


def worth_it(tests: pd.DataFrame) -> pd.DataFrame:
    """The tests in the order of adding them, those that gain next to nothing left
    out."""
    picked = tests.sort_values("pick", ignore_index=True)
    gain = -picked["variance_left_after"].diff().fillna(-1.0)
    return picked[gain > LEAST_GAIN]


def in_words(tests: pd.DataFrame) -> list[str]:
    """A sentence on each of the first tests that are worth adding."""
    if tests.empty:
        return []
    return [
        f"next: {row.test}, {row.runs} in {row.minutes:.0f} min, would leave"
        f" {row.variance_left_after:.0%} of the variance of the seed–seed parameters"
        + (" with what stands above" if k else "")
        for k, row in enumerate(worth_it(tests).head(MOST_SAID).itertuples())
    ]
