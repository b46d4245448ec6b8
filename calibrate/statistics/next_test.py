"""Which test to run next: what it would leave of the parameters, from the posterior's
draws, before anything is measured."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Protocol

import numpy as np
import pandas as pd

from benchtwin.bench.language import tr
from benchtwin.calibrate.statistics.posterior import Posterior, Surrogate

LEAST_GAIN = 0.01  # of the variance, for a test to be worth a word


class Normal(Protocol):
    """What is believed of a factor."""

    @property
    def mean(self) -> float: ...
    @property
    def sd(self) -> float: ...


@dataclass(frozen=True, eq=False)
class BenchTest:
    """A test that the bench may run. surrogates: of the m things that it shows; noise:
    (m, m) covariance of the means of all its runs about them; runs, and the minutes
    that these take at the bench (0: what is recorded already is read again). believed:
    factors of which there are no draws, with mean and sd of each."""

    name: str
    surrogates: tuple[Surrogate, ...]
    noise: np.ndarray
    runs: int
    minutes: float
    believed: Mapping[str, Normal] = field(default_factory=dict)


def what_next(
    posterior: Posterior, tests: Sequence[BenchTest], of: Sequence[str]
) -> pd.DataFrame:
    """What each test leaves of the factors `of`, best first.

    Linear-Gaussian from the draws: with g (m) a test's predictions over them and F the
    surrogates' own variances,

        Cov' = Cov − C (Cov g + noise + F)⁻¹ Cᵀ,  C = cov(θ, g).

    Columns test, runs, minutes, variance_left (trace of Cov' over that of Cov, in the
    prior's sds), sd_left_<factor> (shares), pick (order in which to add them, each
    given those before) and variance_left_after (with that and all earlier picks).
    Raises ValueError for no tests, and for one of a factor without draws."""
    if not tests:
        raise ValueError(tr("tests: none given"))
    theta = (posterior.draws / posterior.prior.sd)[list(of)].to_numpy()
    predicted, noise = zip(*(_shown(test, posterior) for test in tests))
    both = np.atleast_2d(np.cov(np.column_stack([theta, *predicted]), rowvar=False))
    k = len(of)
    ends = k + np.cumsum([0, *(len(r) for r in noise)])
    at = [np.arange(first, last) for first, last in pairwise(ends)]
    rows = []
    for test, columns, r in zip(tests, at, noise):
        after = np.diag(observing(both, columns, r))[:k]
        left = np.sqrt(np.clip(after / np.diag(both)[:k], 0.0, 1.0))
        trace = after.sum() / np.trace(both[:k, :k])
        rows.append((test.name, test.runs, test.minutes, trace, *left))
    names = ["test", "runs", "minutes", "variance_left"]
    table = pd.DataFrame(rows, columns=[*names, *(f"sd_left_{n}" for n in of)])
    table["pick"], table["variance_left_after"] = _picked(both, at, noise, k)
    return table.sort_values("variance_left", ignore_index=True)


def _shown(test: BenchTest, posterior: Posterior) -> tuple[np.ndarray, np.ndarray]:
    """What the test would show at the draws (n, m), and its noise (m, m)."""
    draws = posterior.draws
    draws = draws.assign(
        **{
            name: of.mean + of.sd * np.random.default_rng(k).normal(size=len(draws))
            for k, (name, of) in enumerate(test.believed.items())
            if name not in draws
        }
    )
    wanted = {n for s in test.surrogates for n in s.box.names}
    if unknown := sorted(wanted - set(draws.columns)):
        said = tr("{} depends on {}", test.name, ", ".join(unknown))
        raise ValueError(tr("{}, of which there are no draws", said))
    seen = [s.evaluate(draws[list(s.box.names)].to_numpy()) for s in test.surrogates]
    own = np.diag([float(np.mean(variance)) for _, variance in seen])
    return np.column_stack([mean for mean, _ in seen]), test.noise + own


def _picked(
    both: np.ndarray,
    at: Sequence[np.ndarray],
    noise: Sequence[np.ndarray],
    k: int,
) -> tuple[list[int], list[float]]:
    """Of every test its place in the order of adding, and the share of the variance of
    the first k variables that is left with it and those before it."""
    place, left = [0] * len(at), [0.0] * len(at)
    state, rest = both, set(range(len(at)))
    for n in range(len(at)):
        after = {i: observing(state, at[i], noise[i]) for i in sorted(rest)}
        best = min(after, key=lambda i: float(np.trace(after[i][:k, :k])))
        state = after[best]
        rest.remove(best)
        place[best] = n + 1
        left[best] = float(np.trace(state[:k, :k]) / np.trace(both[:k, :k]))
    return place, left


def observing(covariance: np.ndarray, at: np.ndarray, noise: np.ndarray) -> np.ndarray:
    """Covariance after the variables `at` (m) have been observed with noise (m, m)."""
    across, own = covariance[:, at], covariance[np.ix_(at, at)]
    return covariance - across @ np.linalg.solve(own + noise, across.T)


def worth_it(tests: pd.DataFrame) -> pd.DataFrame:
    """The tests in the order of adding them, those that gain next to nothing left
    out."""
    picked = tests.sort_values("pick", ignore_index=True)
    gain = -picked["variance_left_after"].diff().fillna(-1.0)
    return picked[gain > LEAST_GAIN]


def gain_in_words(variance_left: float, *, with_others: bool) -> str:
    """What a test is expected to do to the intervals, a share of the variance being
    left."""
    narrower = 1 - float(np.sqrt(variance_left))
    also = tr(" together with the tests above") if with_others else ""
    return tr(
        "expected to make the intervals of the seed–seed parameters {:.0%} narrower{}",
        narrower,
        also,
    )
