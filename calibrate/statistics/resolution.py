"""Which directions of the parameters the bench resolves, and which further observable
would narrow the rest most."""

from dataclasses import dataclass

import numpy as np
import pandas as pd
from benchtwin.calibrate.statistics.posterior import Posterior, Surrogate


def directions(posterior: Posterior, resolved_below: float = 0.5) -> pd.DataFrame:
    """Principal directions of the posterior in units of the prior's sd, best resolved
    first.

    Columns direction (1 …), one a factor (components of the unit vector), sd_ratio
    (posterior over prior sd along it), resolved (sd_ratio < resolved_below), statement.
    """
    names = list(posterior.draws.columns)
    spread, vectors = np.linalg.eigh(_covariance(posterior, posterior.draws.to_numpy()))
    rows = []
    for i, (variance, vector) in enumerate(zip(spread, vectors.T)):
        vector = vector * np.sign(vector[np.argmax(abs(vector))])
        ratio = float(np.sqrt(max(variance, 0)))
        mix = " ".join(
            f"{'−' if c < 0 else '+'} {abs(c):.2f} {n}"
            for c, n in zip(vector, names)
            if abs(c) >= 0.1
        )
        resolved = "resolved" if ratio < resolved_below else "not resolved"
        said = (
            f"{resolved}: {mix.removeprefix('+ ')}; the bench narrows it by"
            f" {max(0, 100 * (1 - ratio)):.0f} %"
        )
        rows.append([i + 1, *vector, ratio, ratio < resolved_below, said])
    return pd.DataFrame(
        rows, columns=["direction", *names, "sd_ratio", "resolved", "statement"]
    )


def _covariance(posterior: Posterior, values: np.ndarray) -> np.ndarray:
    """Covariance of the factors in units of their prior sd, with anything else that
    stands in further columns of `values` as it is."""
    scale = np.ones(values.shape[1])
    scale[: len(posterior.prior.sd)] = posterior.prior.sd
    return np.atleast_2d(np.cov(values / scale, rowvar=False))


@dataclass(frozen=True, eq=False)
class Candidate:
    """An observable not yet measured: its surrogate, and the sd that its bench mean
    would have (scatter of the mean and measuring)."""

    name: str
    surrogate: Surrogate
    noise_sd: float


def narrowing(posterior: Posterior, candidates: list[Candidate]) -> pd.DataFrame:
    """What each candidate is expected to add, before it is measured, best first.

    Linear-Gaussian preposterior from the draws: with g the candidate's predictions over
    them and r² its noise (bench and surrogate),

        Cov' = Cov − c cᵀ/(var g + r²),  c = cov(θ, g),
        information = ½ log(1 + var g/r²) nats.

    Columns candidate, information_nats, variance_left (trace of Cov' over Cov, prior-sd
    units), sd_left_<factor> (fractions), pick (order in which to add them, each given
    those before) and variance_left_after (with that and all earlier picks). Raises
    ValueError: no candidates, noise_sd ≤ 0, a surrogate of a factor without prior."""
    if not candidates:
        raise ValueError("candidates: none given")
    joint, variances = _joint(posterior, candidates)
    noise = [float(v) for v in variances]
    k = len(posterior.draws.columns)
    rows = []
    for i, candidate in enumerate(candidates):
        after = condition(joint, k + i, noise[i])
        left = np.diag(after)[:k] / np.diag(joint)[:k]
        trace = np.trace(after[:k, :k]) / np.trace(joint[:k, :k])
        nats = 0.5 * np.log1p(joint[k + i, k + i] / noise[i])
        rows.append((candidate.name, nats, trace, *np.sqrt(left)))
    columns = ["candidate", "information_nats", "variance_left"]
    columns += [f"sd_left_{n}" for n in posterior.draws.columns]
    table = pd.DataFrame(rows, columns=columns)
    picks: dict[int, tuple[int, float]] = {}
    state, open_ = joint, set(range(len(candidates)))
    before = np.trace(joint[:k, :k])
    while open_:
        rest = {i: condition(state, k + i, noise[i])[:k, :k] for i in sorted(open_)}
        best = min(rest, key=lambda i: float(np.trace(rest[i])))
        state = condition(state, k + best, noise[best])
        open_.remove(best)
        picks[best] = (len(picks) + 1, float(np.trace(state[:k, :k]) / before))
    table["pick"] = [picks[i][0] for i in range(len(candidates))]
    table["variance_left_after"] = [picks[i][1] for i in range(len(candidates))]
    return table.sort_values("variance_left", ignore_index=True)


def _joint(
    posterior: Posterior, candidates: list[Candidate]
) -> tuple[np.ndarray, np.ndarray]:
    """Covariance of (factors, candidates' predictions) over the draws, and each
    candidate's noise variance."""
    names, predictions, noise = list(posterior.draws.columns), [], []
    for c in candidates:
        if not c.noise_sd > 0:
            raise ValueError(f"{c.name}: noise_sd must be above 0")
        unknown = [n for n in c.surrogate.box.names if n not in names]
        if unknown:
            raise ValueError(
                f"{c.name} depends on {', '.join(unknown)}, for which there is no prior"
            )
        draws = posterior.draws[list(c.surrogate.box.names)].to_numpy()
        mean, variance = c.surrogate.evaluate(draws)
        predictions.append(mean)
        noise.append(c.noise_sd**2 + float(np.mean(variance)))
    both = np.column_stack([posterior.draws.to_numpy(), *predictions])
    return _covariance(posterior, both), np.array(noise)


def condition(covariance: np.ndarray, index: int, noise: float) -> np.ndarray:
    """Covariance after variable `index` has been observed with variance `noise`."""
    c = covariance[:, index]
    return covariance - np.outer(c, c) / (c[index] + noise)
