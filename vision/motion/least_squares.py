"""Linear least squares under AR(1) noise, since errors of successive frames are
correlated.

cov(n_i, n_j) = σ² ρ^|i−j| for frame numbers i and j, so lost frames need no filling in.
White-noise error bars would be far too small. ρ is estimated by restricted maximum
likelihood (REML; Patterson & Thompson 1971, Biometrika 58, 545), which unlike the
residuals' autocorrelation is not biased towards zero by the fit."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from benchtwin.bench.distributions import chi2 as chi_square
from benchtwin.bench.distributions import t as student

# beyond this a few thousand frames cannot tell correlated noise from a drift
RHO_MAX = 0.995
LEAST_P = 0.01  # of a χ² as large by chance, below which stated sds are doubted


@dataclass(frozen=True)
class Fit:
    """Parameters of a linear fit, their covariance (scaled so that ± 1.96 √var is a 95
    % interval), noise, residuals."""

    params: np.ndarray  # (p,)
    cov: np.ndarray  # (p, p)
    noise: float  # σ, marginal, in the data's unit
    rho: float
    residuals: np.ndarray  # (n,)


def whiten(rows: np.ndarray, lag: np.ndarray, rho: float) -> np.ndarray:
    """Rows (n, …) with AR(1) noise → rows with independent noise of the same σ; lag
    (n,): frames since the row before."""
    carried = rho**lag
    carried[0] = 0.0
    shape = (-1,) + (1,) * (rows.ndim - 1)
    before = np.roll(rows, 1, axis=0)
    return (rows - carried.reshape(shape) * before) / np.sqrt(1 - carried**2).reshape(
        shape
    )


def frame_lag(frame: np.ndarray) -> np.ndarray:
    """Frames since the row before; inf for the first row."""
    return np.concatenate([[np.inf], np.maximum(np.diff(frame), 1e-9)]).astype(float)


def estimate_rho(design: np.ndarray, data: np.ndarray, lag: np.ndarray) -> float:
    """ρ of AR(1) noise about the linear model `design` (n, p), by REML; 0 for fewer
    than 5 degrees of freedom."""
    n, p = design.shape
    if n - p < 5:
        return 0.0
    from scipy import optimize  # loads for a third of a second

    both = np.column_stack([design, data])

    def loss(rho: float) -> float:
        carried = rho**lag
        carried[0] = 0.0
        triangle = np.abs(np.diag(np.linalg.qr(whiten(both, lag, rho), mode="r")))
        triangle = np.maximum(triangle, 1e-300)
        spread = 2 * np.log(triangle[:p]).sum()
        return (n - p) * 2 * np.log(triangle[p]) + np.log(1 - carried**2).sum() + spread

    found = optimize.minimize_scalar(
        loss, bounds=(0.0, RHO_MAX), method="bounded", options={"xatol": 2e-3}
    )
    return float(found.x) if loss(found.x) < loss(0.0) else 0.0


def fit(
    design: np.ndarray,
    data: np.ndarray,
    lag: np.ndarray,
    *,
    weight: np.ndarray | None = None,
    rho: float | None = None,
) -> Fit:
    """Generalised least squares of `data` (n,) on `design` (n, p) under AR(1) noise.
    weight (n,): 1 / relative sd of each row. The covariance is widened by Student's t
    for the n − p degrees of freedom behind σ."""
    n = len(design)
    weight = np.ones(n) if weight is None else weight
    scaled, target = design * weight[:, None], data * weight
    rho = estimate_rho(scaled, target, lag) if rho is None else rho
    white, aim = whiten(scaled, lag, rho), whiten(target, lag, rho)
    alone = np.linalg.lstsq(white, aim, rcond=None)[0]
    freedom = max(n - np.linalg.matrix_rank(white), 1)
    noise = float(np.sqrt(((aim - white @ alone) ** 2).sum() / freedom))
    widen = (student.ppf(0.975, freedom) / 1.96) ** 2
    # a simulated track may be exact, or exactly 0
    noise = max(noise, 1e-12 * float(np.abs(data).max()), 1e-9)
    white, aim = white / noise, aim / noise
    inverse = np.linalg.pinv(white.T @ white, hermitian=True)
    params = np.linalg.lstsq(white, aim, rcond=None)[0]
    return Fit(params, inverse * widen, noise, rho, data - design @ params)


def all_stated(sd: np.ndarray) -> bool:
    """Whether every row has an sd."""
    return bool(np.isfinite(sd).all() and (sd > 0).all())


def variance_factor(
    chi2: float, degrees_of_freedom: int, stated: bool
) -> tuple[float, str]:
    """Factor of a least-squares covariance so that ± 1.96 √var is a 95 % interval, and
    a doubt ("" for none). 1 where the sds of the rows are stated and χ² does not
    contradict them; else χ²/ν, widened by Student's t."""
    if stated and (
        degrees_of_freedom < 1 or chi_square.sf(chi2, degrees_of_freedom) >= LEAST_P
    ):
        return 1.0, ""
    reduced = chi2 / degrees_of_freedom
    doubt = (
        f"the rows scatter {np.sqrt(reduced):.2g} times as much as their stated sd"
        if stated
        else ""
    )
    return reduced * (student.ppf(0.975, degrees_of_freedom) / 1.96) ** 2, doubt


def correlated_mean(values: np.ndarray, frame: np.ndarray) -> tuple[float, float]:
    """Mean of a stretch of correlated values and its sd; one value alone has no sd of
    its own (NaN)."""
    if len(values) < 2:
        return float(values[0]), float("nan")
    found = fit(np.ones((len(values), 1)), values, frame_lag(frame))
    return float(found.params[0]), float(np.sqrt(found.cov[0, 0]))


def believed_sds(moved: np.ndarray, prior_sd: np.ndarray) -> np.ndarray:
    """sds (m,) of quantities by the priors alone, infinite where one depends on a
    parameter without a prior; moved (m, p): their slopes, prior_sd (p,): of the
    parameters, infinite without one."""
    by = np.zeros_like(moved)
    np.multiply(moved, prior_sd, out=by, where=moved != 0)
    return np.sqrt((by**2).sum(axis=1))


def slopes(
    function: Callable[[np.ndarray], ArrayLike], params: np.ndarray, sds: np.ndarray
) -> np.ndarray:
    """Derivatives (m, p) of `function(params)`, by central differences of 1e-3 sd."""
    steps = 1e-3 * sds + 1e-12 * np.abs(params) + 1e-300
    columns = [
        np.asarray(function(params + shift)) - np.asarray(function(params - shift))
        for shift in np.diag(steps)
    ]
    return np.column_stack(columns) / (2 * steps)
