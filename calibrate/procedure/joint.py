"""What all recordings together say of all parameters: posterior, resolved directions,
what else to measure."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import pandas as pd
from benchtwin.calibrate.procedure.pile import PileFit
from benchtwin.calibrate.procedure.pile_surrogate import PileObservables
from benchtwin.calibrate.procedure.rigs import PILE_RESPONSE, SEED_FACTORS
from benchtwin.calibrate.procedure.steel import SteelFit
from benchtwin.calibrate.statistics.box import Box
from benchtwin.calibrate.statistics.posterior import (
    Observable,
    Posterior,
    on_grid,
    summary,
)
from benchtwin.calibrate.statistics.prior import Prior
from benchtwin.calibrate.statistics.resolution import Candidate, directions, narrowing
from benchtwin.calibrate.statistics.sampling import sample
from benchtwin.calibrate.statistics.shrinkage import shrink

GRID_CELLS = (
    40_001  # of a single parameter: fine beside any interval, and quicker than a chain
)
ON_SEED = {
    "seed_restitution": "drop of seed on a bed of seeds",
    "seed_static_friction": "slide of seeds on a plate of seeds",
    "seed_rolling_friction": "roll of a seed on a plate of seeds",
}
ON_STEEL = {
    "seed_restitution": "drop",
    "seed_static_friction": "slide",
    "seed_rolling_friction": "roll",
}


@dataclass(frozen=True, eq=False)
class DirectReading:
    """An observable that is one parameter itself, as a drop of seed on seed gives the
    restitution."""

    box: Box
    df: float = np.inf

    def evaluate(self, natural) -> tuple[np.ndarray, np.ndarray]:
        """Mean and variance (n,) at natural points (n, 1)."""
        x = np.asarray(natural, dtype=float)[:, 0]
        return x, np.zeros_like(x)


@dataclass(frozen=True, eq=False)
class Joint:
    """posterior over the parameters that were fitted, table: its summary beside the
    sequential answers (sequential, level), directions of the seed–seed parameters, best
    resolved first; narrowing: further observables, best first, with their assumed
    noise; notes."""

    posterior: Posterior
    table: pd.DataFrame
    directions: pd.DataFrame
    narrowing: pd.DataFrame
    notes: tuple[str, ...]


def fit_joint(
    steel: dict[str, SteelFit],
    pile: PileFit | None,
    *,
    rng: np.random.Generator,
    level: float = 0.95,
    priors: dict[str, tuple[float, float]] | None = None,
    candidates: Sequence[Candidate] = (),
    ess: int = 1000,
    seen: PileObservables | None = None,
) -> Joint | None:
    """Posterior over all fitted parameters; None where nothing was fitted.

    seen: what stands for the piles, by default the angle's surface over the seed–seed
    parameters alone; priors: {parameter: (mean, sd)} of normal ones, else uniform over
    what was simulated; candidates: further observables of the piles; to them come drop,
    slide and roll of seed on seed, measured as well as on steel."""
    observables = [
        Observable(f"{n}: {f.rig.response}", f.surrogate, f.bench)
        for n, f in steel.items()
    ]
    ranges = {
        f.rig.parameter: (f.surrogate.low, f.surrogate.high) for f in steel.values()
    }
    correlation = None
    if pile is not None:
        ranges |= {
            n: (float(a), float(b))
            for n, a, b in zip(pile.box.names, pile.box.low, pile.box.high)
        }
        angle = Observable(f"pile: {PILE_RESPONSE}", shrink(pile.surface), pile.bench)
        of_pile = seen.observables if seen is not None else (angle,)
        correlation = seen.correlation if seen is not None else None
        observables += of_pile
        ranges = {n: _shared_range(n, ends, of_pile) for n, ends in ranges.items()}
    if not observables:
        return None
    known = {n: v for n, v in (priors or {}).items() if n in ranges}
    posterior = _joint_posterior(
        observables, Prior(Box.of(ranges), known), rng, ess, correlation
    )
    sequential = {f.rig.parameter: f.inverse.value for f in steel.values()} | (
        pile.optimum.point if pile else {}
    )
    table = summary(posterior, level)
    table.insert(1, "sequential", [sequential[n] for n in table["factor"]])
    notes = [posterior.note] if posterior.note else []
    if pile is None:
        return Joint(posterior, table, pd.DataFrame(), pd.DataFrame(), tuple(notes))
    seeds = _seed_marginal(posterior)
    to_measure = narrowing(seeds, [*candidates, *_seed_rig_candidates(steel, pile)])
    return Joint(posterior, table, directions(seeds), to_measure, tuple(notes))


def _shared_range(
    name: str, ends: tuple[float, float], observables: tuple[Observable, ...]
) -> tuple[float, float]:
    """The part of a parameter's range that all surfaces cover which know it."""
    for box in (o.surrogate.box for o in observables):
        if name in box.names:
            low, high = _range(box, name)
            ends = (max(ends[0], low), min(ends[1], high))
    return ends


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
        part = _prior_of(prior, names)
        if len(names) == 1:
            parts.append(on_grid(inside, part, rng=rng, cells=GRID_CELLS))
        else:
            shared = _correlation_of(inside, correlation)
            parts.append(sample(inside, part, rng=rng, ess=ess, correlation=shared))
    n = min(len(p.draws) for p in parts)
    picked = [rng.permutation(len(p.draws))[:n] for p in parts]
    draws = pd.concat(
        [p.draws.iloc[i].reset_index(drop=True) for p, i in zip(parts, picked)], axis=1
    )
    order = list(prior.box.names)
    quality = pd.DataFrame(
        {
            "r_hat": np.concatenate([p.r_hat for p in parts]),
            "ess": np.concatenate([p.ess for p in parts]),
        },
        index=list(draws.columns),
    ).loc[order]
    log_density = np.sum([p.log_density[i] for p, i in zip(parts, picked)], axis=0)
    return Posterior(
        prior,
        draws[order],
        log_density,
        quality["r_hat"].to_numpy(),
        quality["ess"].to_numpy(),
        all(p.converged for p in parts),
        pd.concat([p.tension for p in parts], ignore_index=True),
        "; ".join(p.note for p in parts if p.note),
    )


def _blocks(observables: list[Observable], prior: Prior) -> list[set[str]]:
    """Parameters that observables tie together."""
    blocks: list[set[str]] = []
    for o in observables:
        names = set(o.surrogate.box.names)
        tied = [b for b in blocks if b & names]
        blocks = [b for b in blocks if b not in tied] + [names.union(*tied)]
    return sorted(blocks, key=lambda b: min(prior.box.names.index(n) for n in b))


def _prior_of(prior: Prior, names: set[str]) -> Prior:
    """The prior of some of the parameters, which are independent."""
    keep = [i for i, n in enumerate(prior.box.names) if n in names]
    box = Box(
        tuple(prior.box.names[i] for i in keep),
        prior.box.low[keep],
        prior.box.high[keep],
    )
    return Prior(box, {n: v for n, v in prior.given.items() if n in names})


def _seed_marginal(posterior: Posterior) -> Posterior:
    """The posterior of the seed–seed parameters alone."""
    prior = _prior_of(posterior.prior, set(SEED_FACTORS))
    names = list(prior.box.names)
    keep = [list(posterior.draws.columns).index(n) for n in names]
    r_hat, ess = posterior.r_hat[keep], posterior.ess[keep]
    return replace(
        posterior, prior=prior, draws=posterior.draws[names], r_hat=r_hat, ess=ess
    )


def _seed_rig_candidates(steel: dict[str, SteelFit], pile: PileFit) -> list[Candidate]:
    """The three rigs with seeds in the steel's place: noise as the same rig has on
    steel, relative to the parameter."""
    found = []
    for name in pile.box.names:
        fit, (low, high) = steel.get(ON_STEEL.get(name, "")), _range(pile.box, name)
        relative = (
            fit.inverse.sd / abs(fit.inverse.value)
            if fit is not None and fit.inverse.value
            else 0.1
        )
        noise = float(max(relative * (low + high) / 2, 1e-3 * (high - low)))
        reading = DirectReading(Box.of({name: (low, high)}))
        found.append(
            Candidate(f"{ON_SEED.get(name, name)} (± {noise:.2g})", reading, noise)
        )
    return found


def _range(box: Box, name: str) -> tuple[float, float]:
    i = box.names.index(name)
    return float(box.low[i]), float(box.high[i])
