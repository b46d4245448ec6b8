"""Which test to run next: what so many more minutes of it at the bench would leave of
the parameters, from the posterior's draws, before anything is measured."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd
from benchtwin.calibrate.statistics.posterior import Posterior, Surrogate


@dataclass(frozen=True, eq=False)
class BenchTest:
    """A test that the bench may run. surrogates: of the m things that one run of it
    shows; scatter: (m, m) covariance of one run's readings about them; minutes: that a
    run takes at the bench."""

    name: str
    surrogates: tuple[Surrogate, ...]
    scatter: np.ndarray
    minutes: float


def after_minutes(
    posterior: Posterior,
    tests: Sequence[BenchTest],
    of: Sequence[str],
    minutes: float,
) -> pd.DataFrame:
    """What each test leaves of the factors `of` after `minutes` of it, best first.

    Linear-Gaussian from the draws: with g (m) a test's predictions over them, n runs,
    and F the surrogates' own variances,

        Cov' = Cov − C (Cov g + scatter/n + F)⁻¹ Cᵀ,  C = cov(θ, g).

    Columns test, minutes (of one run), runs (n, at least 1), variance_left (trace of
    Cov' over that of Cov, in the prior's sds), sd_left_<factor> (shares)."""
    scale = posterior.prior.sd
    names = list(posterior.draws.columns)
    counted = [names.index(name) for name in of]
    theta = (posterior.draws.to_numpy() / scale)[:, counted]
    k = len(counted)
    before = np.cov(theta, rowvar=False).reshape(k, k)
    rows = []
    for test in tests:
        columns = [
            posterior.draws[list(s.box.names)].to_numpy() for s in test.surrogates
        ]
        seen = [s.evaluate(c) for s, c in zip(test.surrogates, columns)]
        g = np.column_stack([mean for mean, _ in seen])
        own = np.diag([float(np.mean(variance)) for _, variance in seen])
        runs = max(int(minutes // test.minutes), 1)
        m = g.shape[1]
        both = np.cov(np.column_stack([theta, g]), rowvar=False)
        across, spread = both[:k, k:], both[k:, k:].reshape(m, m)
        noise = np.asarray(test.scatter, float) / runs + own
        after = before - across @ np.linalg.solve(spread + noise, across.T)
        left = np.sqrt(np.clip(np.diag(after) / np.diag(before), 0.0, 1.0))
        trace = float(np.trace(after) / np.trace(before))
        rows.append((test.name, test.minutes, runs, trace, *left))
    columns = ["test", "minutes", "runs", "variance_left"]
    columns += [f"sd_left_{n}" for n in of]
    table = pd.DataFrame(rows, columns=columns)
    return table.sort_values("variance_left", ignore_index=True)
