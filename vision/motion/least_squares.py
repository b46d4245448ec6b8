"""Standard deviations of least squares: stated ones held against the residuals, those
of the priors alone, derivatives that carry them on."""

from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike

from benchtwin.bench.distributions import chi2 as chi_square
from benchtwin.bench.distributions import t as student
from benchtwin.bench.language import tr

LEAST_P = 0.01  # of a χ² as large by chance, below which stated sds are doubted


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
        tr("the rows scatter {:.2g} times as much as their stated sd", np.sqrt(reduced))
        if stated
        else ""
    )
    return reduced * (student.ppf(0.975, degrees_of_freedom) / 1.96) ** 2, doubt


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
