"""How much recordings differ within themselves: the size of what each has of its own
beside a common law.

Rows of recording r: b = A θ + D u + ε, u ~ N(0, σ²) its own. Restricted maximum
likelihood takes everything common, effects included, as free, so that what all
recordings have alike does not count as scatter:

    ln L(σ) = −½ Σ ln det V_r − ½ ln det Σ AᵀV⁻¹A − ½ Σ bᵀP b,   V = I + σ² D Dᵀ

Source: Patterson & Thompson (1971), Biometrika 58, 545."""

import numpy as np

from benchtwin.infer.linear import Reduced

SIZES = np.geomspace(0.03, 60.0, 22)  # times the usual one
DOUBT = 1.5  # sd of ln of a usual size
TURNS = 2  # in which each kind is estimated beside the others
SHOWN = 1.92  # rise of ln L at the end of a 95 % interval that holds 0


def own_scatter(
    reduced: tuple[Reduced, ...],
    common: int,
    usual: np.ndarray | float,
    always: np.ndarray | bool = False,
) -> np.ndarray:
    """σ (K,) of each recording's own columns, which stand behind the first `common`:
    the root of its mean square; 0 where recordings do not show any, but of what is
    there `always` (K,). usual (K,): what it usually is; columns of one usual size have
    one size."""
    y = [r.b for r in reduced]
    size = np.sqrt(sum((r.a[:, :common] ** 2).sum(0) for r in reduced))
    kept = size > 0
    x = [r.a[:, :common][:, kept] / size[kept] for r in reduced]
    own = [r.a[:, common:] for r in reduced]
    usual = usual * np.ones(own[0].shape[1])
    found = np.zeros(len(usual))
    for kind in TURNS * [usual == u for u in dict.fromkeys(usual)]:
        tried = found * ~kind + np.append(0.0, SIZES)[:, None] * usual * kind
        nothing, *rest = (_ln_likelihood(sd, x, own, y) for sd in tried)
        found = found * ~kind
        if (always & kind).any() or max(rest) > nothing + SHOWN:
            ln = np.array(rest) - 0.5 * (np.log(SIZES) / DOUBT) ** 2
            weight = np.exp(ln - ln.max())
            found += usual * kind * np.sqrt((weight * SIZES**2).sum() / weight.sum())
    return found


def _ln_likelihood(
    sd: np.ndarray, x: list[np.ndarray], own: list[np.ndarray], y: list[np.ndarray]
) -> float:
    """Restricted, up to a constant; sd (K,)."""
    width = x[0].shape[1]
    gram, ln_det = np.zeros((width + 1, width + 1)), 0.0
    for a, d, b in zip(x, own, y, strict=True):
        rows, scaled = np.column_stack([a, b]), d * sd
        inner = np.eye(d.shape[1]) + scaled.T @ scaled
        across = scaled.T @ rows
        gram += rows.T @ rows - across.T @ np.linalg.solve(inner, across)
        ln_det += float(np.linalg.slogdet(inner)[1])
    values, vectors = np.linalg.eigh(gram[:-1, :-1])
    seen = values > 1e-9 * max(values.max(initial=0.0), 1e-300)
    along = vectors[:, seen].T @ gram[:-1, -1]
    left = gram[-1, -1] - float((along**2 / values[seen]).sum())
    return -0.5 * (ln_det + float(np.log(values[seen]).sum()) + left)
