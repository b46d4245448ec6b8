"""Unlisted physics: pushes in windows of an axis, one by one and as a Gaussian process.

A window is a column of acceleration (or of the rig's own kind) that acts in one bin of
an axis. The windows of one axis with a smooth prior (squared exponential, LENGTH_BINS
bins) are a Gaussian process common to all recordings."""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from benchtwin.infer.evidence import Component, Kind
from benchtwin.infer.linear import Reduced, fall_of_chi2, projector, stacked
from benchtwin.infer.noise import maximum_draws
from benchtwin.infer.problem import Fit

WINDOW_P = 0.05
LENGTH_BINS = 1.5  # correlation length of unlisted physics


@dataclass(frozen=True)
class Window:
    """Where along `axis` most is missing, in its unit; p: over all windows and axes."""

    axis: str
    low: float
    high: float
    p: float


@dataclass(frozen=True)
class Bin:
    """One window: low to high of an axis, for a kind of push (along, aside …), in a
    sector."""

    axis: str
    low: float
    high: float
    push: str
    sector: str


@dataclass(frozen=True, eq=False)
class Windows:
    """extra: K columns in the form that Problem.reduce takes; bins (K,)."""

    extra: Any
    bins: tuple[Bin, ...]


def window_columns(
    fit: Fit, windows: Windows
) -> tuple[tuple[Reduced, ...], np.ndarray]:
    """The fit's linearisation and the windows' columns (M, K) in it, summed over
    sessions."""
    count, width = len(windows.bins), len(fit.names)
    if not count:
        return fit.reduced, np.zeros((sum(len(r.b) for r in fit.reduced), 0))
    reduced = fit.problem.reduce(fit.starts, fit.values, windows.extra)[0]
    columns = [r.a[:, width:].reshape(len(r.b), -1, count).sum(axis=1) for r in reduced]
    return tuple(replace(r, a=r.a[:, :width]) for r in reduced), np.vstack(columns)


def unlisted_components(windows: Windows, columns: np.ndarray) -> list[Component]:
    """One Gaussian process for each axis and kind of push."""
    groups: dict[tuple[str, str, str], list[int]] = {}
    for k, b in enumerate(windows.bins):
        groups.setdefault((b.sector, b.push, b.axis), []).append(k)
    out = []
    for (sector, push, axis), own in groups.items():
        at = np.arange(len(own))
        smooth = np.exp(-0.5 * ((at[:, None] - at) / LENGTH_BINS) ** 2) + 1e-6 * np.eye(
            len(at)
        )
        mixed = columns[:, own] @ np.linalg.cholesky(smooth)
        unit = np.ones(len(own)), np.ones(len(own), dtype=bool)
        name = f"(unlisted) {sector}: {push} by {axis}"
        out.append(Component(name, Kind.UNLISTED, sector, mixed, *unit))
    return out


def strongest_window(
    reduced: tuple[Reduced, ...],
    prior_sd: np.ndarray,
    windows: Windows,
    columns: np.ndarray,
    level_sd: float,
    rng: np.random.Generator,
) -> tuple[Window | None, str]:
    """The window with the greatest score, if significant; the axis with the greatest
    fall."""
    if not windows.bins:
        return None, ""
    a, b = stacked(reduced)
    project = projector(a, prior_sd)
    right, gram = project(b), columns.T @ project(columns)
    size = np.sqrt(np.maximum(np.diag(gram), 1e-300))
    z = columns.T @ right / size
    z[size < 1e-6 * size.max()] = 0.0
    draws = maximum_draws(gram / np.outer(size, size), rng, level_sd=level_sd)
    best = int(np.argmax(np.abs(z)))
    p = float((1 + (draws >= abs(z[best])).sum()) / (1 + len(draws)))
    if p >= WINDOW_P:
        return None, ""
    gains = {}
    for axis in dict.fromkeys(w.axis for w in windows.bins):
        own = [i for i, w in enumerate(windows.bins) if w.axis == axis]
        fall, freedom = fall_of_chi2(columns[:, own], project, b)
        gains[axis] = fall - freedom
    where = windows.bins[best]
    return Window(where.axis, where.low, where.high, p), max(
        gains, key=lambda axis: gains[axis]
    )
