"""Which test to run next for the parameters of seed on seed."""

from collections.abc import Collection, Mapping, Sequence

import numpy as np
import pandas as pd

from benchtwin.bench.language import tr
from benchtwin.bench.tells import BySurface
from benchtwin.calibrate.procedure.observed import (
    PileObservables,
    correlation_of,
    scatter_apart,
    surrogate_of,
)
from benchtwin.calibrate.procedure.rigs import BESIDE, PILE
from benchtwin.calibrate.statistics.box import Box
from benchtwin.calibrate.statistics.next_test import (
    BenchTest,
    gain_in_words,
    what_next,
    worth_it,
)
from benchtwin.calibrate.statistics.posterior import Posterior
from benchtwin.calibrate.statistics.surrogate import Surrogate

MINUTES = 20.0  # of a rig's test: an afternoon's repeats
MOST_SAID = 3  # tests, each together with those said before it


def recorded_tests(name: str, seen: PileObservables) -> list[BenchTest]:
    """More of what the bench has recorded already; and what a bench can state of the
    same recordings, and this one does not."""
    rig = PILE if name == PILE.name else BESIDE[name]
    surrogates = seen.surrogates
    tests = [_more(rig, surrogates, seen.correlation, seen.runs)]
    steel = _steel_of(seen, surrogates)
    # weights of a slice are not the bench's
    for column in (*rig.rig.readings, *(rig.rig.weighed if seen.alike else ())):
        told = column in seen.used
        through = None if told else surrogate_of(seen.runs, column, seen.box, steel)
        if through is not None:
            what = column.rsplit("_", 1)[0].replace("_", " ")
            runs = seen.bench.n
            noise = np.array([[through[0].noise_sd ** 2 / runs]])
            named = tr(
                "the {} of the {} that are recorded already", what, rig.in_plural
            )
            tests.append(BenchTest(named, (through[0],), noise, runs, 0.0))
    return tests


def _steel_of(seen: PileObservables, surrogates: Sequence[Surrogate]) -> Box | None:
    """What varied along in the runs."""
    wide = surrogates[0].box
    ranges = {n: wide.range(n) for n in wide.names if n not in seen.box.names}
    return Box.of(ranges) if ranges else None


def unrecorded_test(
    rig: BySurface, runs: pd.DataFrame, box: Box, steel: Box | None
) -> BenchTest | None:
    """What the bench has none of, from simulated runs of it; None where they show
    nothing."""
    surrogates, errors = [], {}
    for column in (*rig.rig.readings, *rig.rig.weighed):
        if (through := surrogate_of(runs, column, box, steel)) is not None:
            surrogates.append(through[0])
            errors[column] = through[1]
    if not surrogates:
        return None
    return _more(rig, surrogates, correlation_of(errors), runs)


def _more(
    rig: BySurface,
    surrogates: Sequence[Surrogate],
    correlation: pd.DataFrame,
    simulated: pd.DataFrame,
) -> BenchTest:
    runs = max(int(MINUTES // rig.minutes), 1)
    apart = np.array([scatter_apart(s, simulated, rig) for s in surrogates])
    readings = runs * rig.per_run
    sd = np.sqrt(apart[:, 0] ** 2 + apart[:, 1] ** 2 / readings)
    noise = np.outer(sd, sd) * correlation.to_numpy()
    how = f" ({rig.made})" if rig.made else ""
    name = tr("{} more {}{}", readings, rig.in_plural, how)
    return BenchTest(name, tuple(surrogates), noise, readings, runs * rig.minutes)


def next_tests(
    posterior: Posterior,
    seen: Mapping[str, PileObservables],
    others: Sequence[BenchTest],
    of: Sequence[str],
) -> pd.DataFrame:
    """What each test would leave of the factors `of`: `MINUTES` more of those that the
    bench has recorded, and `others`."""
    own = [test for name, one in seen.items() for test in recorded_tests(name, one)]
    known = set(posterior.draws.columns)
    tests = [
        test
        for test in (*own, *others)
        if all(set(s.box.names) <= known | set(test.believed) for s in test.surrogates)
    ]
    return what_next(posterior, tests, of) if tests else pd.DataFrame()


def in_words(tests: pd.DataFrame) -> list[str]:
    """A sentence on each of the first tests that are worth adding."""
    if tests.empty:
        return []
    return [
        tr("worth adding: {}", row.test)
        + (tr(" (about {:.0f} min)", row.minutes) if row.minutes else "")
        + f", {gain_in_words(row.variance_left_after, with_others=k > 0)}"
        for k, row in enumerate(worth_it(tests).head(MOST_SAID).itertuples())
    ]


def untried_in_words(left: Sequence[str], recorded: Collection[str]) -> list[str]:
    """A sentence on each test that tells by itself one of the parameters `left` open,
    and of which the bench has recorded none; a last one on how to learn what tests
    would leave."""
    if not left:
        return []
    untried = [
        tr(
            "{}: {} tell it by themselves; {}",
            tr(" and ").join(told),
            rig.in_plural,
            rig.made,
        )
        for name, rig in BESIDE.items()
        if name not in recorded and (told := [p for p in left if p in rig.answers])
    ]
    return [
        *untried,
        tr(
            "{}: --next-test simulates the tests that this bench has none of, and says"
            " what each would leave",
            tr(" and ").join(left),
        ),
    ]
