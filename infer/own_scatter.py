"""How much recordings differ within themselves: the size of what each has of its own
beside a common law, and which of them are odd.

Rows of recording r: b = A θ + D u + ε, u ~ N(0, λ²σ²) its own. λ is 1, and for an odd
recording the likeliest value of ODD. Restricted maximum likelihood takes everything
common, effects included, as free, so that what all recordings have alike does not
count as scatter:

    ln L(σ, λ) = −½ Σ ln det V_r − ½ ln det Σ AᵀV⁻¹A − ½ Σ bᵀP b,   V = I + λ²σ² D Dᵀ

Source: Patterson & Thompson (1971), Biometrika 58, 545."""

from dataclasses import dataclass

import numpy as np
from scipy.special import logsumexp

from benchtwin.infer.linear import Reduced

SIZES = np.geomspace(0.03, 60.0, 22)  # times the usual one
DOUBT = 1.5  # sd of ln of a usual size
TURNS = 2  # in which each kind is estimated beside the others
SHOWN = 1.92  # rise of ln L at the end of a 95 % interval that holds 0
# times the size of the others' own: one that is far off must not make all others wide
ODD = (10.0, 100.0)
NOT_TOLD = 1e-9  # of the information on a column, below which it is not told


@dataclass(frozen=True, eq=False)
class OwnScatter:
    """sd (K,): what recordings have of their own, the mean of its likely sizes; times
    (R,): λ; shown: whether the recordings show any (ln L rises by SHOWN or more), else
    its size is what was believed before; beyond: rise of ln L above that of any size up
    to what recordings differ by at most."""

    sd: np.ndarray
    times: np.ndarray
    shown: bool
    beyond: float


def own_scatter(
    reduced: tuple[Reduced, ...],
    common: int,
    usual: np.ndarray | float,
    always: np.ndarray | bool = False,
    odd_share: float = 0.0,
    most: float = np.inf,
) -> OwnScatter:
    """Of each recording's own columns, which stand behind the first `common`: 0 where
    recordings do not show any, but of what is there `always` (K,). usual (K,): what it
    usually is; columns of one usual size have one size. odd_share: of recordings that
    are odd; they are found one by one as long as that is likelier. most: of the last
    kind, that recordings differ by."""
    size = np.sqrt(sum((r.a[:, :common] ** 2).sum(0) for r in reduced))
    kept = size > 0
    parts = [
        (np.column_stack([r.a[:, :common][:, kept] / size[kept], r.b]), r.a[:, common:])
        for r in reduced
    ]
    usual = usual * np.ones(parts[0][1].shape[1])
    times = np.ones(len(parts))
    sd, ln, shown, beyond = _sizes(parts, usual, always, times, most)
    others = np.eye(len(parts), dtype=bool)
    while odd_share and (times == 1).any():
        tried = [np.where(one, odd, times) for one in others[times == 1] for odd in ODD]
        # an odd one has raised the size of all
        alike = [_ln_likelihood(sd / np.sqrt(t.max()), parts, t) for t in tried]
        one = tried[int(np.argmax(alike))]
        again, higher, seen, more = _sizes(parts, usual, always, one, most)
        if higher + np.log(odd_share / len(ODD) / (1 - odd_share)) <= ln:
            break
        sd, ln, shown, beyond, times = again, higher, seen, more, one
    return OwnScatter(sd, times, shown, beyond)


def _sizes(
    parts: list[tuple[np.ndarray, np.ndarray]],
    usual: np.ndarray,
    always: np.ndarray | bool,
    times: np.ndarray,
    most: float,
) -> tuple[np.ndarray, float, bool, float]:
    """σ (K,), ln L averaged over the sizes of the last kind, whether any is shown, and
    by how much ln L is higher beyond `most` than within; parts: of each recording,
    common columns and data (n, C + 1) and its own (n, K)."""
    found = np.zeros(len(usual))
    shown, beyond = False, 0.0
    for kind in TURNS * [usual == u for u in dict.fromkeys(usual)]:
        tried = found * ~kind + np.append(0.0, SIZES)[:, None] * usual * kind
        nothing, *rest = (_ln_likelihood(sd, parts, times) for sd in tried)
        found = found * ~kind
        ln = np.array(rest) - 0.5 * (np.log(SIZES) / DOUBT) ** 2
        seen = max(rest) > nothing + SHOWN
        if (always & kind).any() or seen:
            weight = np.exp(ln - ln.max())
            found += usual * kind * (weight @ SIZES) / weight.sum()
        shown = shown or seen
        within = np.array(rest)[usual[kind][0] * SIZES <= most]
        beyond = max(rest) - float(within.max())
    return found, float(logsumexp(ln)), shown, beyond


def _ln_likelihood(sd: np.ndarray, parts, times: np.ndarray) -> float:
    """Restricted, up to a constant; sd (K,)."""
    width = parts[0][0].shape[1] - 1
    gram, ln_det = np.zeros((width + 1, width + 1)), 0.0
    for (rows, own), more in zip(parts, times, strict=True):
        scaled = own * sd * more
        inner = np.eye(scaled.shape[1]) + scaled.T @ scaled
        across = scaled.T @ rows
        gram += rows.T @ rows - across.T @ np.linalg.solve(inner, across)
        ln_det += float(np.linalg.slogdet(inner)[1])
    values, vectors = np.linalg.eigh(gram[:-1, :-1])
    seen = values > NOT_TOLD * max(values.max(initial=0.0), 1e-300)
    along = vectors[:, seen].T @ gram[:-1, -1]
    left = gram[-1, -1] - float((along**2 / values[seen]).sum())
    return -0.5 * (ln_det + float(np.log(values[seen]).sum()) + left)
