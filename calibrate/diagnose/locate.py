"""Locate a mismatch: which sector explains it, in which window, and along which axis the residual collapses.

Everything is asked of the reduced space: freeing a sector is a projection, a window is a column of acceleration (or of the rig's
own kind) that acts only there. The excess χ² is what freeing everything (all sectors, and the smooth curves) would remove beyond
chance.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

from calibrate.diagnose.linear import chance, fall_of_chi2, projector, stacked
from calibrate.diagnose.noise import maximum_draws
from calibrate.diagnose.problem import Fit
from calibrate.diagnose.scores import explained

DRAWS = 20_000
WINDOW_P = 0.05


@dataclass(frozen=True)
class Sector:
    """explained: share of the excess χ² (NaN where there is none to share), of χ² its fall less twice the freedom that it takes
    (Akaike 1974: sectors of many terms and of few compare); p: of a fall as great by chance."""

    name: str
    explained: float
    p: float


@dataclass(frozen=True)
class Window:
    """Where along `axis` something is missing most: low, high in the axis's unit; p: global, over all windows and axes."""

    axis: str
    low: float
    high: float
    p: float


@dataclass(frozen=True)
class Location:
    """excess: χ² above chance that freeing everything would remove; p: of it; sectors, best first; window, None where its p is
    not below .05; collapse: the axis of which what is missing is best a function, "" without a window.

    Common terms without a name (`Unnamed`) share in all this; p is then the lesser of both, doubled.
    """

    excess: float
    p: float
    sectors: tuple[Sector, ...]
    window: Window | None
    collapse: str


@dataclass(frozen=True, eq=False)
class Windows:
    """extra: K columns in the form that the problem's `reduce` takes; where (K,): axis, low, high of each."""

    extra: Any
    where: tuple[tuple[str, float, float], ...]


def locate(fit: Fit, windows: Windows, rng: np.random.Generator) -> Location:
    """All three answers for a fitted baseline."""
    doubt = noise_doubt(fit, rng)
    by_sector = {s: tuple(n for n in fit.names if _sector(fit, n) == s) for s in fit.problem.sectors}
    fall, count = explained(fit, sum(by_sector.values(), ()), smooth=True)
    p, terms = chance(fall, count, doubt), unnamed(fit)
    if terms:
        common, freedom = terms.fall(())
        p = min(1.0, 2 * min(p, chance(common, freedom, doubt)))
        fall = max(fall, common - freedom + count)
    excess = max(fall - count, 0.0)
    found = []
    for name, columns in by_sector.items():
        ways = [explained(fit, columns)] + ([terms.fall(columns, name)] if terms else [])
        part, freedom = max(ways, key=lambda way: way[0] - 2 * way[1])
        share = float(np.clip((part - 2 * freedom) / excess, 0, 1)) if excess > 0 else float("nan")
        found.append(Sector(name, share, chance(part, freedom, doubt)))
    found.sort(key=lambda sector: (-np.nan_to_num(sector.explained), sector.p))
    window, collapse = strongest_window(fit, windows, rng)
    return Location(excess, p, tuple(found), window, collapse)


@dataclass(frozen=True, eq=False)
class Unnamed:
    """A fit's reduced space a (M, G), b (M,), and columns (M, k) by sector of terms of no candidate's (Problem.nameless)."""

    fit: Fit
    a: np.ndarray
    b: np.ndarray
    columns: dict[str, np.ndarray]

    def fall(self, effects: tuple[str, ...], sector: str | None = None) -> tuple[float, int]:
        """Fall of χ² and its freedom when the terms of `sector` (None: of all) and `effects` are freed."""
        terms = [c for s, c in self.columns.items() if sector in (None, s)]
        own = self.a[:, [self.fit.names.index(n) for n in effects]]
        return fall_of_chi2(np.hstack([own, *terms]), projector(self.a, self.fit.prior_sd), self.b)


def unnamed(fit: Fit) -> Unnamed | None:
    """None where a rig has no such terms."""
    return Unnamed(fit, *fit.problem.nameless(fit)) if fit.problem.nameless else None


def noise_doubt(fit: Fit, rng: np.random.Generator) -> np.ndarray:
    """Draws of true over estimated noise power."""
    return np.exp(fit.problem.level_sd * rng.standard_normal(4000))


def _sector(fit: Fit, name: str) -> str:
    return fit.problem.effects[name].sector if name in fit.problem.effects else ""


def strongest_window(fit: Fit, windows: Windows, rng: np.random.Generator) -> tuple[Window | None, str]:
    """The window with the greatest score, global p by the bootstrap of the maximum, and the axis with the greatest fall in χ²."""
    if not windows.where:
        return None, ""
    a, b = stacked(fit.problem.reduce(fit.starts, fit.values, windows.extra)[0])
    a, columns = np.split(a, [len(fit.names)], axis=1)
    project = projector(a, fit.prior_sd)
    right, gram = project(b), columns.T @ project(columns)
    size = np.sqrt(np.maximum(np.diag(gram), 1e-300))
    z = columns.T @ right / size
    z[size < 1e-6 * size.max()] = 0.0
    draws = maximum_draws(gram / np.outer(size, size), rng, level_sd=fit.problem.level_sd, draws=DRAWS)
    best = int(np.argmax(np.abs(z)))
    p = float((1 + (draws >= abs(z[best])).sum()) / (1 + len(draws)))
    if p >= WINDOW_P:
        return None, ""
    gains = {}
    for axis in dict.fromkeys(entry[0] for entry in windows.where):
        own = [i for i, entry in enumerate(windows.where) if entry[0] == axis]
        fall, freedom = fall_of_chi2(columns[:, own], project, b)
        gains[axis] = fall - freedom
    return Window(*windows.where[best], p), max(gains, key=lambda axis: gains[axis])
