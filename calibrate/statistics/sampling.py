"""The posterior by emcee's affine-invariant ensembles, which need no tuning on the thin
sheets that one angle leaves.

Source: Goodman & Weare (2010), Comm. App. Math. Comp. Sci. 5, 65; Foreman-Mackey et al.
(2013), PASP 125, 306; split R̂ as in Gelman et al., Bayesian Data Analysis (3rd ed.),
11.4, over the halves of independent ensembles."""

import emcee
import numpy as np

from benchtwin.calibrate.statistics.posterior import (
    Observable,
    Posterior,
    finish,
    log_posterior,
)
from benchtwin.calibrate.statistics.prior import Prior

# independent, from different starts: walkers of one ensemble know each other and cannot
# vouch for each other
ENSEMBLES = 4
WALKERS = 100  # a step of many costs what one of few costs
BLOCK = 500  # steps between two looks at convergence
KEPT = 20_000  # draws: more would only make the tables longer
CONVERGED_R_HAT = 1.01  # Vehtari et al. (2021), Bayesian Anal. 16, 667


def sample(
    observables: list[Observable],
    prior: Prior,
    *,
    rng: np.random.Generator,
    ess: int = 1000,
    max_steps: int = 8000,
    correlation: np.ndarray | None = None,
) -> Posterior:
    """Draw from the posterior until every factor has `ess` effective draws and R̂ <
    1.01, or max_steps are done (then not converged).

    rng: seeds starts and ensembles; the same rng state gives the same draws."""
    box, k = prior.box, len(prior.box.names)
    walkers = max(WALKERS, 4 * k)

    def log_density(coded: np.ndarray) -> np.ndarray:
        return log_posterior(box.natural(coded), observables, prior, correlation)

    samplers, states = [], []
    for _ in range(ENSEMBLES):
        sampler = emcee.EnsembleSampler(walkers, k, log_density, vectorize=True)
        sampler.random_state = np.random.MT19937(int(rng.integers(2**32))).state
        samplers.append(sampler)
        states.append(box.coded(prior.draw(walkers, rng)))
    steps = 0
    while steps < max_steps:
        block = min(BLOCK, max_steps - steps)
        states = [
            s.run_mcmc(state, block, skip_initial_state_check=True)
            for s, state in zip(samplers, states)
        ]
        steps += block
        # the first third is on the way from the prior
        chains = np.array([s.get_chain(discard=steps // 3) for s in samplers])
        r_hat, effective = split_r_hat(chains), effective_draws(chains)
        converged = (r_hat < CONVERGED_R_HAT).all() and (effective >= ess).all()
        if converged:
            break
    density = np.array([s.get_log_prob(discard=steps // 3) for s in samplers])
    thin = max(1, chains.shape[1] * ENSEMBLES * walkers // KEPT)
    draws, logs = chains[:, ::thin].reshape(-1, k), density[:, ::thin].ravel()
    return finish(
        box.natural(draws),
        logs,
        observables,
        prior,
        correlation,
        r_hat=r_hat,
        ess=effective,
        converged=bool(converged),
    )


def split_r_hat(chains: np.ndarray) -> np.ndarray:
    """R̂ (k,) of chains (ensembles, steps, walkers, k), each ensemble cut into two
    halves: √(((n − 1)/n W + B/n)/W)."""
    half = chains.shape[1] // 2
    parts = np.concatenate([chains[:, :half], chains[:, half : 2 * half]])
    parts = parts.reshape(len(parts), -1, chains.shape[-1])
    n = parts.shape[1]
    within = parts.var(axis=1, ddof=1).mean(axis=0)
    return np.sqrt((n - 1) / n + parts.mean(axis=1).var(axis=0, ddof=1) / within)


def effective_draws(chains: np.ndarray) -> np.ndarray:
    """Effective number of draws (k,): all of them over the integrated autocorrelation
    time, averaged over the ensembles; none where a walker has never moved, whose
    autocorrelation is not defined."""
    with np.errstate(invalid="ignore"):
        times = [emcee.autocorr.integrated_time(c, tol=0) for c in chains]
    tau = np.mean(times, axis=0)
    return np.where(np.isnan(tau), 0.0, chains[..., 0].size / np.maximum(tau, 1.0))
