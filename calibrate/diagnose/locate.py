"""Locate a mismatch: which sector explains it, in which window, and along which axis the residual collapses.

Everything is asked of the reduced space: freeing a sector is a projection, a window is a column of acceleration that acts only
there. The excess χ² is what freeing everything (all sectors, and a smooth curve in every flight) would remove beyond chance.
"""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from scipy import stats

from calibrate.diagnose.drop.baseline import Fit
from calibrate.diagnose.drop.flight import NODES, accelerations, positions_at_nodes
from calibrate.diagnose.drop.model import forces
from calibrate.diagnose.drop.reduction import reduce
from calibrate.diagnose.drop.scores import explained, fall_of_chi2, projector, stacked
from calibrate.diagnose.effects.drop import EFFECTS
from calibrate.diagnose.noise import maximum_draws

SECTORS = ("flight", "measurement")
BINS = 5
DRAWS = 20_000


@dataclass(frozen=True)
class Sector:
    """explained: share of the excess χ² (NaN where there is none to share); p: of a fall in χ² as great by chance."""

    name: str
    explained: float
    p: float


@dataclass(frozen=True)
class Window:
    """Where along `axis` an acceleration is missing most: low, high in the axis's unit; p: global, over all windows and axes."""

    axis: str
    low: float
    high: float
    p: float


@dataclass(frozen=True)
class Location:
    """excess: χ² above chance that freeing everything would remove; p: of it; sectors, best first; window, None where its p is
    not below .05; collapse: the axis of which the missing acceleration is best a function, "" without a window."""

    excess: float
    p: float
    sectors: tuple[Sector, ...]
    window: Window | None
    collapse: str


def locate(fit: Fit, rng: np.random.Generator) -> Location:
    """All three answers for a fitted baseline."""
    doubt = np.exp(fit.noise.level_sd * rng.standard_normal(4000))
    by_sector = {s: tuple(n for n in fit.names if n in EFFECTS and EFFECTS[n].sector == s) for s in SECTORS}
    fall, count = explained(fit, sum(by_sector.values(), ()), smooth=True)
    excess = max(fall - count, 0.0)
    found = []
    for name, columns in by_sector.items():
        part, freedom = explained(fit, columns)
        share = float(np.clip((part - freedom) / excess, 0, 1)) if excess > 0 else float("nan")
        found.append(Sector(name, share, chance(part, freedom, doubt)))
    found.sort(key=lambda sector: (-np.nan_to_num(sector.explained), sector.p))
    window, collapse = windows(fit, rng)
    return Location(excess, chance(fall, count, doubt), tuple(found), window, collapse)


def chance(fall: float, freedom: int, doubt: np.ndarray) -> float:
    """P(χ² > fall), averaged over what is not known of the noise's power."""
    return float(stats.chi2.sf(fall / doubt, freedom).mean())


def axes_of(fit: Fit) -> dict[str, np.ndarray]:
    """Where each flight's Chebyshev nodes (F, POINTS) lie on each axis."""
    s = fit.model.session
    push = accelerations(fit.starts[:, 2:], s.half, forces(fit.model, fit.by_name))
    places, speeds = positions_at_nodes(fit.starts, s.half, push)
    begun = np.array([s.middle[s.recording == r].min() - s.half[s.recording == r].max() for r in s.recording])
    number = np.array([int((s.recording[:f] == s.recording[f]).sum()) for f in range(len(s.middle))])
    floor = np.array([places[s.recording == r, :, 1].min() for r in s.recording])
    shape = np.ones_like(NODES)
    return {
        "t_s": s.middle[:, None] + s.half[:, None] * NODES - begun[:, None],
        "z_mm": 1e3 * (places[..., 1] - floor[:, None]),
        "v_m_s": np.linalg.norm(speeds, axis=-1),
        "n_bounce": number[:, None] * shape,
    }


def windows(fit: Fit, rng: np.random.Generator) -> tuple[Window | None, str]:
    """The window with the greatest score, global p by the bootstrap of the maximum, and the axis with the greatest fall in χ²."""
    s, axes = fit.model.session, axes_of(fit)
    push = accelerations(fit.starts[:, 2:], s.half, forces(fit.model, fit.by_name))
    along = positions_at_nodes(fit.starts, s.half, push)[1]
    along = along / np.maximum(np.linalg.norm(along, axis=-1, keepdims=True), 1e-9)
    across = np.broadcast_to([1.0, 0.0], along.shape)
    pushes, where = [], []
    for axis, values in axes.items():
        for low, high in _edges(values, axis):
            inside = ((values >= low) & (values <= high))[..., None]
            pushes += [inside * along, inside * across]
            where += [(axis, low, high)] * 2
    a, b = stacked(reduce(fit.model, fit.noise, fit.starts, fit.values, np.array(pushes))[0])
    a, columns = np.split(a, [len(fit.names)], axis=1)
    project = projector(a, fit.prior_sd)
    right, gram = project(b), columns.T @ project(columns)
    size = np.sqrt(np.maximum(np.diag(gram), 1e-300))
    z = columns.T @ right / size
    z[size < 1e-6 * size.max()] = 0.0
    draws = maximum_draws(gram / np.outer(size, size), rng, level_sd=fit.noise.level_sd, draws=DRAWS)
    best = int(np.argmax(np.abs(z)))
    p = float((1 + (draws >= abs(z[best])).sum()) / (1 + len(draws)))
    if p >= 0.05:
        return None, ""
    gains = {}
    for axis in axes:
        own = [i for i, entry in enumerate(where) if entry[0] == axis]
        fall, freedom = fall_of_chi2(columns[:, own], project, b)
        gains[axis] = fall - freedom
    return Window(*where[best], p), max(gains, key=gains.get)


def _edges(values: np.ndarray, axis: str) -> list[tuple[float, float]]:
    """Bins of equal width; the bounce count has one a flight."""
    if axis == "n_bounce":
        return [(k - 0.5, k + 0.5) for k in range(int(values.max()) + 1)]
    edges = np.linspace(values.min(), values.max(), BINS + 1)
    return list(pairwise(edges))
