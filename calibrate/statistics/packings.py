"""Runs that share packings: their correlation, and the matrix that decorrelates them.

Runs on packing b scatter together, y = Xβ + u_b + e, V = cov(y)/σ_e² = 1 + λ ZZᵀ, λ =
σ_u²/σ_e². λ maximises the restricted likelihood
    −2ℓ(λ) = log|V| + log|XᵀV⁻¹X| + (n − p) log(rᵀV⁻¹r)
(Patterson & Thompson 1971); multiplied by V^(−½), runs and model matrix are those of an
ordinary regression with variance σ_e²."""

import numpy as np
from scipy.optimize import minimize_scalar

# λ beyond which packings explain everything: the scatter within them is then 1 % of
# that between
MOST = 1e4


def decorrelate(
    x: np.ndarray, y: np.ndarray, packing: np.ndarray
) -> tuple[float, np.ndarray]:
    """λ and V^(−½) (n, n) for model matrix x (n, p), responses y (n,) and packing
    labels (n,).

    λ = 0 where the likelihood sees nothing shared. Raises ValueError where no packing
    has two runs, or all runs have the same."""
    labels, index = np.unique(packing, return_inverse=True)
    if len(labels) == len(y) or len(labels) == 1:
        raise ValueError(
            f"packing: {len(labels)} packings in {len(y)} runs; some must be shared,"
            " and there must be several"
        )
    same = (index[:, None] == index[None, :]).astype(float)
    d, u = np.linalg.eigh(same)
    ux, uy = u.T @ x, u.T @ y

    def deviance(ratio: float) -> float:
        w = 1 / (1 + ratio * np.maximum(d, 0))
        gram = (ux * w[:, None]).T @ ux
        r = uy - ux @ np.linalg.solve(gram, (ux * w[:, None]).T @ uy)
        return float(
            -np.log(w).sum()
            + np.linalg.slogdet(gram)[1]
            + (len(y) - x.shape[1]) * np.log(np.sum(w * r**2))
        )

    least = np.log(1e-4)
    found = minimize_scalar(
        lambda t: deviance(np.exp(t)), bounds=(least, np.log(MOST)), method="bounded"
    )
    ratio = float(np.exp(found.x)) if found.fun < deviance(0.0) else 0.0
    return ratio, (u / np.sqrt(1 + ratio * np.maximum(d, 0))) @ u.T
