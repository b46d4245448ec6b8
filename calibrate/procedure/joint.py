"""What all recordings together say of all parameters: one posterior, what it leaves
open, which test next."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import pandas as pd

from benchtwin.calibrate.procedure.next_tests import next_tests
from benchtwin.calibrate.procedure.observed import PileObservables, joined
from benchtwin.calibrate.procedure.rigs import SEED_FACTORS
from benchtwin.calibrate.procedure.steel import GRID_CELLS, SteelFit
from benchtwin.calibrate.statistics.box import Box
from benchtwin.calibrate.statistics.next_test import BenchTest
from benchtwin.calibrate.statistics.posterior import (
    Observable,
    Posterior,
    on_grid,
    summary,
    trade_offs,
)
from benchtwin.calibrate.statistics.prior import Prior
from benchtwin.calibrate.statistics.sampling import sample


@dataclass(frozen=True, eq=False)
class Joint:
    """posterior over the parameters that were fitted; table: how far it is to be
    believed, a row a parameter; ties: pairs of seed–seed parameters that are told
    together rather than apart; next_tests: what each further test would leave, best
    first."""

    posterior: Posterior
    table: pd.DataFrame
    ties: pd.DataFrame
    next_tests: pd.DataFrame


def fit_joint(
    steel: Mapping[str, SteelFit],
    seeds: Mapping[str, PileObservables],
    *,
    rng: np.random.Generator,
    priors: dict[str, tuple[float, float]] | None = None,
    ess: int = 1000,
    others: tuple[BenchTest, ...] = (),
) -> Joint:
    """Posterior over all fitted parameters.

    steel, seeds: what each rig says of seed on steel and of seed on seed; others: tests
    that the bench has not run. priors: {parameter: (mean, sd)} of normal ones, else
    uniform over what was simulated; ess: effective draws."""
    of_seeds, correlation = joined(tuple(seeds.values()))
    observables = [*(fit.observable for fit in steel.values()), *of_seeds]
    believed = {n: key for part in seeds.values() for n, key in part.believed.items()}
    boxes = [o.surrogate.box for o in observables]
    ranges = {n: _shared_range(n, boxes) for box in boxes for n in box.names}
    known = {n: (key.mean, key.sd) for n, key in believed.items()}
    known |= {n: v for n, v in (priors or {}).items() if n in ranges}
    prior = Prior(Box.of(ranges), known)
    posterior = _posterior(observables, prior, rng, ess, correlation)
    of = [n for n in SEED_FACTORS if n in ranges]
    tests = next_tests(posterior, seeds, others, of) if of else pd.DataFrame()
    return Joint(posterior, summary(posterior), trade_offs(posterior, of), tests)


def _shared_range(name: str, boxes: list[Box]) -> tuple[float, float]:
    """The part of a parameter's range that all surrogates cover which know it."""
    lows, highs = zip(*(b.range(name) for b in boxes if name in b.names))
    return max(lows), min(highs)


def _posterior(
    observables: list[Observable],
    prior: Prior,
    rng: np.random.Generator,
    ess: int,
    correlation: pd.DataFrame,
) -> Posterior:
    """The posterior over all parameters, drawn block by block: what shares no
    observable is independent."""
    parts = []
    for names in _blocks(observables, prior):
        inside = [o for o in observables if set(o.surrogate.box.names) <= names]
        part = prior.of(names)
        if len(names) == 1:
            parts.append(on_grid(inside, part, rng=rng, cells=GRID_CELLS))
        else:
            shared = _correlation_of(inside, correlation)
            parts.append(sample(inside, part, rng=rng, ess=ess, correlation=shared))
    n = min(len(p.draws) for p in parts)
    picked = [p.draws.iloc[rng.permutation(len(p.draws))[:n]] for p in parts]
    draws = pd.concat([d.reset_index(drop=True) for d in picked], axis=1)
    columns, order = list(draws.columns), list(prior.box.names)
    at = [columns.index(name) for name in order]
    modes = {name: value for p in parts for name, value in p.mode.items()}
    return Posterior(
        prior=prior,
        draws=draws[order],
        mode={name: modes[name] for name in order},
        r_hat=np.concatenate([p.r_hat for p in parts])[at],
        ess=np.concatenate([p.ess for p in parts])[at],
        converged=all(p.converged for p in parts),
        tension=pd.concat([p.tension for p in parts], ignore_index=True),
        note="; ".join(p.note for p in parts if p.note),
    )


def _correlation_of(
    observables: list[Observable], correlation: pd.DataFrame
) -> np.ndarray:
    """The correlation of these observables' errors; those it does not name are
    independent."""
    names = [o.name for o in observables]
    full = pd.DataFrame(np.eye(len(names)), index=names, columns=names)
    full.update(correlation)
    return full.to_numpy()


def _blocks(observables: list[Observable], prior: Prior) -> list[set[str]]:
    """Parameters that observables tie together."""
    blocks: list[set[str]] = []
    for o in observables:
        names = set(o.surrogate.box.names)
        tied = [b for b in blocks if b & names]
        blocks = [b for b in blocks if b not in tied] + [names.union(*tied)]
    return sorted(blocks, key=lambda b: min(prior.box.names.index(n) for n in b))
