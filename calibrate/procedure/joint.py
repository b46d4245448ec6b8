"""What all recordings together say of all parameters: posterior, resolved directions,
which test next."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike

from benchtwin.calibrate.procedure.next_tests import next_tests
from benchtwin.calibrate.procedure.pile import PileFit
from benchtwin.calibrate.procedure.pile_surrogate import PileObservables, joined
from benchtwin.calibrate.procedure.rigs import ON_SEED, PILE
from benchtwin.calibrate.procedure.steel import SteelFit, together
from benchtwin.calibrate.statistics.box import Box
from benchtwin.calibrate.statistics.next_test import BenchTest
from benchtwin.calibrate.statistics.posterior import (
    Observable,
    Posterior,
    on_grid,
    summary,
)
from benchtwin.calibrate.statistics.prior import Prior
from benchtwin.calibrate.statistics.resolution import directions
from benchtwin.calibrate.statistics.sampling import sample
from benchtwin.calibrate.statistics.shrinkage import shrink

# of a single parameter: fine beside any interval, and quicker than a chain
GRID_CELLS = 40_001
LEVEL = 0.95
# relative noise of a rig with seeds in the steel's place where it was not calibrated on
# steel, and the least, in the parameter's range
UNKNOWN_NOISE, LEAST_NOISE = 0.1, 1e-3


@dataclass(frozen=True, eq=False)
class DirectReading:
    """An observable that is one parameter itself, as a drop of seed on seed gives the
    restitution."""

    box: Box
    df: float = np.inf

    def evaluate(self, natural: ArrayLike) -> tuple[np.ndarray, np.ndarray]:
        """Mean and variance (n,) at natural points (n, 1)."""
        x = np.asarray(natural, dtype=float)[:, 0]
        return x, np.zeros_like(x)


@dataclass(frozen=True, eq=False)
class Joint:
    """posterior over the parameters that were fitted, table: its summary beside the
    sequential answers (sequential, level), directions of the seed–seed parameters, best
    resolved first; notes; next_tests: what each further test would leave, best
    first."""

    posterior: Posterior
    table: pd.DataFrame
    directions: pd.DataFrame = field(default_factory=pd.DataFrame)
    notes: tuple[str, ...] = ()
    next_tests: pd.DataFrame = field(default_factory=pd.DataFrame)


def fit_joint(
    steel: dict[str, SteelFit],
    pile: PileFit | None,
    beside: Mapping[str, PileObservables] | None = None,
    *,
    rng: np.random.Generator,
    priors: dict[str, tuple[float, float]] | None = None,
    ess: int = 1000,
    others: tuple[BenchTest, ...] = (),
) -> Joint | None:
    """Posterior over all fitted parameters; None where nothing was fitted.

    The piles stand in it by what they showed (`PileFit.seen`), else by the angle's
    surface over the seed–seed parameters alone; beside: what further rigs say of seed
    on seed; others: tests that the bench has not run. priors: {parameter: (mean, sd)}
    of normal ones, else uniform over what was simulated; ess: effective draws.
    Next tests: more of what is recorded, others, what else the piles show, and drop,
    slide and roll of seed on seed, measured as well as on steel."""
    observables = [
        Observable(f"{n}: {f.rig.response}", f.surrogate, f.bench)
        for n, f in steel.items()
    ]
    of_rigs = {**_of_pile(pile), **(beside or {})}
    of_seeds, correlation = joined(tuple(of_rigs.values()))
    observables += of_seeds
    if not observables:
        return None
    sequential = {name: value for name, (value, _) in together(steel.values()).items()}
    sequential |= pile.optimum.point if pile is not None else {}
    believed = {n: key for part in of_rigs.values() for n, key in part.believed.items()}
    sequential |= {n: key.mean for n, key in believed.items()}
    ranges = {name: _shared_range(name, observables) for name in sequential}
    known = {n: (key.mean, key.sd) for n, key in believed.items()}
    known |= {n: v for n, v in (priors or {}).items() if n in ranges}
    prior = Prior(Box.of(ranges), known)
    posterior = _joint_posterior(observables, prior, rng, ess, correlation)
    table = summary(posterior, LEVEL)
    table.insert(1, "sequential", [sequential[n] for n in table["factor"]])
    notes = (posterior.note,) if posterior.note else ()
    if pile is None:
        return Joint(posterior, table, notes=notes)
    seeds = _seed_marginal(posterior)
    others = (*others, *pile.to_read, *_with_seeds(steel, pile))
    next_ = next_tests(posterior, of_rigs, others, pile.box.names)
    return Joint(posterior, table, directions(seeds), notes, next_)


def _of_pile(pile: PileFit | None) -> dict[str, PileObservables]:
    """What the piles say in the posterior."""
    if pile is None:
        return {}
    if pile.seen is not None:
        return {PILE.name: pile.seen}
    name = f"{PILE.name}: {PILE.response}"
    angle = Observable(name, shrink(pile.surface), pile.bench)
    alone = pd.DataFrame([[1.0]], index=[name], columns=[name])
    seen = PileObservables(
        observables=(angle,), correlation=alone, used=(PILE.response,), notes=()
    )
    return {PILE.name: seen}


def _shared_range(name: str, observables: list[Observable]) -> tuple[float, float]:
    """The part of a parameter's range that all surfaces cover which know it."""
    boxes = [o.surrogate.box for o in observables]
    lows, highs = zip(*(b.range(name) for b in boxes if name in b.names))
    return max(lows), min(highs)


def _correlation_of(
    observables: list[Observable], correlation: pd.DataFrame | None
) -> np.ndarray | None:
    """The correlation of these observables' errors; those it does not name are
    independent."""
    names = [o.name for o in observables]
    if correlation is None or not set(names) & set(correlation.index):
        return None
    full = pd.DataFrame(np.eye(len(names)), index=names, columns=names)
    full.update(correlation)
    return full.to_numpy()


def _joint_posterior(
    observables: list[Observable],
    prior: Prior,
    rng: np.random.Generator,
    ess: int,
    correlation: pd.DataFrame | None,
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
    picked = [(p, rng.permutation(len(p.draws))[:n]) for p in parts]
    draws = pd.concat(
        [p.draws.iloc[i].reset_index(drop=True) for p, i in picked], axis=1
    )
    columns, order = list(draws.columns), list(prior.box.names)
    at = [columns.index(name) for name in order]
    return Posterior(
        prior=prior,
        draws=draws[order],
        log_density=np.sum([p.log_density[i] for p, i in picked], axis=0),
        r_hat=np.concatenate([p.r_hat for p in parts])[at],
        ess=np.concatenate([p.ess for p in parts])[at],
        converged=all(p.converged for p in parts),
        tension=pd.concat([p.tension for p in parts], ignore_index=True),
        note="; ".join(p.note for p in parts if p.note),
    )


def _blocks(observables: list[Observable], prior: Prior) -> list[set[str]]:
    """Parameters that observables tie together."""
    blocks: list[set[str]] = []
    for o in observables:
        names = set(o.surrogate.box.names)
        tied = [b for b in blocks if b & names]
        blocks = [b for b in blocks if b not in tied] + [names.union(*tied)]
    return sorted(blocks, key=lambda b: min(prior.box.names.index(n) for n in b))


def _seed_marginal(posterior: Posterior) -> Posterior:
    """The posterior of the seed–seed parameters alone."""
    prior = posterior.prior.of(set(ON_SEED))
    names = list(prior.box.names)
    keep = [list(posterior.draws.columns).index(n) for n in names]
    r_hat, ess = posterior.r_hat[keep], posterior.ess[keep]
    draws = posterior.draws[names]
    return replace(posterior, prior=prior, draws=draws, r_hat=r_hat, ess=ess)


def _with_seeds(steel: dict[str, SteelFit], pile: PileFit) -> list[BenchTest]:
    """The rigs with seeds in the steel's place: noise as the same rig has on steel,
    relative to the parameter."""
    found = []
    for rig in (ON_SEED[name] for name in pile.box.names):
        low, high = pile.box.range(rig.seed)
        relative, runs = UNKNOWN_NOISE, 1
        if (fit := steel.get(rig.name)) is not None and fit.inverse.value:
            relative, runs = fit.inverse.sd / abs(fit.inverse.value), fit.bench.n
        noise = float(max(relative * (low + high) / 2, LEAST_NOISE * (high - low)))
        reading = DirectReading(Box.of({rig.seed: (low, high)}))
        name, minutes = f"{rig.on_seed} (± {noise:.2g})", runs * rig.minutes
        found.append(BenchTest(name, (reading,), np.array([[noise**2]]), runs, minutes))
    return found
