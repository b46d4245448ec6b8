"""How well times of impacts are known that state no sd: by their rounding and scatter.
An error of a time changes two intervals in opposite ways, a scatter of the restitution
does not."""

import math

import numpy as np

PRIOR_SD_S, PRIOR_FACTOR = 2e-4, 2.0  # log-normal prior of the sd of an impact time


def estimate_time_sds(times: np.ndarray) -> np.ndarray:
    """(n,), all equal: estimated sd [s] of impact times without a stated one. Posterior
    mean from the scatter of ln Δt, in which errors of times and of e differ in
    correlation; at least the rounding."""
    least = _rounding(times) / math.sqrt(12)
    sigma = np.maximum(np.geomspace(2e-6, 2e-2, 41), least)
    log_weight = -0.5 * (np.log(sigma / PRIOR_SD_S) / math.log(PRIOR_FACTOR)) ** 2
    gap = np.diff(times)
    if len(gap) > 2:
        y = np.diff(np.log(gap))
        slope = np.zeros((len(y), len(times)))  # of y with the times
        for k in range(len(y)):
            slope[k, k : k + 3] = (
                1 / gap[k],
                -1 / gap[k] - 1 / gap[k + 1],
                1 / gap[k + 1],
            )
        centred = np.linalg.svd(np.ones((len(y), 1)))[0][:, 1:].T  # e itself is unknown
        values, shape = centred @ y, centred @ slope @ slope.T @ centred.T
        axes, turned = np.linalg.eigh(shape)
        power = (turned.T @ values) ** 2
        variance = (
            sigma[:, None, None] ** 2 * np.maximum(axes, 0)
            + np.geomspace(1e-3, 0.2, 15)[:, None] ** 2
        )
        each = -0.5 * (np.log(variance) + power / variance).sum(axis=2)
        log_weight = log_weight + np.logaddexp.reduce(each, axis=1)
    weight = np.exp(log_weight - log_weight.max())
    return np.full(
        len(times), max(np.exp(weight @ np.log(sigma) / weight.sum()), least)
    )


def _rounding(times: np.ndarray) -> float:
    """The step to which the times were rounded when written: 0.001 for 0.271, 0.522."""
    exact = (
        np.allclose(times, np.round(times, digits), rtol=0, atol=1e-9)
        for digits in range(7)
    )
    return next(
        (10.0**-digits for digits, is_exact in enumerate(exact) if is_exact), 0.0
    )
