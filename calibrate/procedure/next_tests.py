"""Which test of seed on seed to run next, per minute at the bench."""

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
from benchtwin.calibrate.statistics.next_test import BenchTest, after_minutes
from benchtwin.calibrate.statistics.posterior import Posterior
from benchtwin.calibrate.statistics.shrinkage import ShrinkageSurface, shrink

MINUTES = 20.0  # that are compared: an afternoon's repeats of any one test


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
    return BenchTest(rig.rig.in_plural, tuple(surfaces), scatter, rig.minutes)


def next_tests(
    posterior: Posterior,
    seen: Mapping[str, PileObservables],
    others: Sequence[BenchTest],
    of: Sequence[str],
) -> pd.DataFrame:
    """What `MINUTES` more of each test would leave of the factors `of`: of those that
    the bench has recorded, and of `others`."""
    own = [recorded_test(name, one) for name, one in seen.items()]
    known = set(posterior.draws.columns)
    tests = [
        test
        for test in (*own, *others)
        if test is not None and all(set(s.box.names) <= known for s in test.surrogates)
    ]
    return after_minutes(posterior, tests, of, MINUTES) if tests else pd.DataFrame()


def in_words(tests: pd.DataFrame) -> list[str]:
    """A sentence on each test that may be run next, best first."""
    return [
        f"next: {row.runs} more {row.test} ({row.runs * row.minutes:.0f} min) would"
        f" leave {row.variance_left:.0%} of the variance of the seed–seed parameters"
        for row in tests.itertuples()
    ]
