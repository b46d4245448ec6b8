"""How unevenly a seed that is no ball rolls: resistance that changes along its way, in each run otherwise.

Not what all runs have in common, which is physics, but what each run has of its own: with c_k ~ N(0, s²) the resistance over
weight in the k-th part of its way, ln L(s) = ½ Σ [ s²λ/(1 + s²λ) f − ln(1 + s²λ) ] over the eigenvalues λ of AᵀA, A the columns
of the parts, f the fall of χ² along each (Patterson & Thompson 1971: all that is common is taken out first).
"""

import numpy as np

from calibrate.diagnose.linear import stacked
from calibrate.diagnose.problem import Fit
from calibrate.diagnose.roll.problem import parts

LEAST_RUNS = 3  # with fewer it is not seen what runs have in common
GRID = np.concatenate([[0.0], np.geomspace(1e-6, 1e-2, 41)])  # of s, over weight
SEEN = 5.0  # rise of ln L: p = 1e-3


def roughness(base: Fit) -> np.ndarray:
    """s of each run (R,), not less than that of all together; 0 where none is seen."""
    model = base.problem.model
    count, nil = len(model.runs), np.zeros(len(model.runs))
    if model.seed.round or count < LEAST_RUNS:
        return nil
    columns = [parts(model, r, base.starts[r], base.by_name) for r in range(count)]
    reduced = base.problem.reduce(base.starts, base.values, columns)[0]
    a, b = stacked(reduced)
    scaled = a / np.sqrt((a**2).sum(0)).clip(1e-300)
    left = b - scaled @ np.linalg.lstsq(scaled, b, rcond=1e-8)[0]
    rows = np.cumsum([0, *(len(r.b) for r in reduced)])
    each = np.array([
        _ln_likelihood(r.a[:, len(base.names) :], left[low:high])
        for r, low, high in zip(reduced, rows[:-1], rows[1:], strict=True)
    ])  # fmt: skip
    if each.sum(0).max() < SEEN:
        return nil
    lost = np.sqrt(count / (count - 1))  # what is common was taken from the same runs
    return lost * np.maximum(GRID[each.argmax(1)], GRID[each.sum(0).argmax()])


def _ln_likelihood(columns: np.ndarray, left: np.ndarray) -> np.ndarray:
    """ln L over GRID, of one run."""
    values, vectors = np.linalg.eigh(columns.T @ columns)
    kept = values > 1e-10 * values.max()
    fall = (vectors[:, kept].T @ (columns.T @ left)) ** 2 / values[kept]
    power = GRID[:, None] ** 2 * values[kept]
    return 0.5 * (power / (1 + power) * fall - np.log1p(power)).sum(1)
