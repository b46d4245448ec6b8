"""Problems whose recordings are series of one quantity each (travel of a block, way of a seed, height of a pile's surface).

predict(r, own (L,), values) → (n_r,) says what recording r shows for its locals `own` and the globals by name. Derivatives are
differences; rows are whitened with each recording's own noise; locals are eliminated by QR.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np
from scipy.linalg import solve_triangular

from diagnose.effects.effect import Effect
from diagnose.engine.descent import Cheap
from diagnose.engine.linear import Reduced
from diagnose.engine.noise import Noise
from diagnose.engine.problem import Problem

STEP = 1e-3  # of a prior's sd, for derivatives; less where predictions are exact and bend much within a sd


@dataclass(frozen=True, eq=False)
class Series:
    """One recording: data (n,), sigma (n,) or scalar [data's unit], lag (n,) (noise.frame_lag), its noise, curves (n, s) that
    nothing asked about needs, and own (n, q): what it adds of its own by chance, each column with a factor of sd 1."""

    recording: str
    data: np.ndarray
    sigma: np.ndarray | float
    lag: np.ndarray
    noise: Noise
    smooth: np.ndarray
    own: np.ndarray | None = None


@dataclass(frozen=True, eq=False)
class Locals:
    """What is each recording's own: start (R, L), step (L,) for derivatives, sd (L,) about `start` (inf: free; those
    first)."""

    start: np.ndarray
    step: np.ndarray
    sd: np.ndarray


def problem_of(
    rig: str,
    series: tuple[Series, ...],
    own: Locals,
    predict: Callable,
    effects: dict[str, Effect],
    nuisances: dict[str, float],
    known_sd: dict[str, float],
    model: Any,
    *,
    turns: int = 12,
    step: float = STEP,
    smooth: bool = False,
) -> Problem:
    """effects: candidates with their laws in `predict`; nuisances: further globals with their typical size (for derivatives);
    known_sd: sd of each global in the baseline, absent: fixed at nil. smooth: predictions have no kinks, so that a step which
    worsens χ² itself, and not only its linear forecast, is too long."""
    sizes = {n: e.prior_sd for n, e in effects.items()} | nuisances
    rows = sum(len(s.data) for s in series) - int(np.isinf(own.sd).sum()) * len(series)
    level = max(s.noise.log_level_sd for s in series)
    return Problem(
        rig, tuple(s.recording for s in series), effects, tuple(sizes), known_sd, own.start,
        partial(reduce, series, own, predict, sizes, step=step, smooth=smooth), rows, level, model, turns,
        cheap=_cheap(series, own, predict, sizes, step) if smooth else None,
    )  # fmt: skip


def _cheap(series, own: Locals, predict: Callable, sizes: dict[str, float], step: float) -> Cheap | None:
    """None where recordings add something of their own by chance: χ² alone does not tell it."""
    if any(s.own is not None for s in series):
        return None

    def lean(starts, values, wanted):
        return reduce(series, own, predict, sizes, starts, values, step=step, smooth=True, wanted=wanted)

    return Cheap(partial(cost, series, own, predict, tuple(sizes)), lean)


def cost(series, own: Locals, predict: Callable, names: tuple[str, ...], starts: np.ndarray, values: np.ndarray) -> float:
    """See Cheap.cost: the sum of what `reduce` tells as its recordings' costs."""
    at, total = dict(zip(names, values, strict=True)), 0.0
    held = np.isfinite(own.sd)
    for r, s in enumerate(series):
        rows = (s.data - predict(r, starts[r], at)) / s.sigma
        white = s.noise.whiten(rows[:, None], s.lag)
        total += float((white**2).sum()) + float((((own.start[r] - starts[r]) / own.sd)[held] ** 2).sum())
    return total


def reduce(
    series,
    own: Locals,
    predict: Callable,
    sizes: dict[str, float],
    starts: np.ndarray,
    values: np.ndarray,
    extra=None,
    *,
    step: float = STEP,
    smooth: bool = False,
    wanted: np.ndarray | None = None,
):
    """See Problem.reduce; extra: K further columns, one array (n_r, K) a recording; wanted (G,): globals whose columns are asked
    for, the others' are nil."""
    asked = sizes if wanted is None else {n: size for (n, size), w in zip(sizes.items(), wanted, strict=True) if w}
    at = dict(zip(sizes, values, strict=True))
    more = [None] * len(series) if extra is None else extra
    made = [_reduced(s, own, predict, asked, r, starts[r], at, more[r], step) for r, s in enumerate(series)]
    width = made[0][0].a.shape[1] - len(values)
    theta = np.concatenate([values, np.zeros(width)])
    reduced = tuple(replace(m, b=m.b + m.a @ theta, cost=m.cost if smooth else None) for m, _ in made)

    def change(moved: np.ndarray) -> np.ndarray:
        """moved (G,), or (R, G) where a recording has its own."""
        each = np.broadcast_to(moved, (len(made), moved.shape[-1]))
        return np.array([back(own) for (_, back), own in zip(made, each, strict=True)])

    return reduced, change


def _reduced(one: Series, own: Locals, predict, asked, r: int, start: np.ndarray, at: dict[str, float], extra, share: float):
    """Reduced of one recording at the point of linearisation, and a function (change of globals) → change of its locals. asked:
    sizes of the globals that are."""
    seen = predict(r, start, at)
    columns = [(predict(r, start + step, at) - seen) / own.step[k] for k, step in enumerate(np.diag(own.step))]
    for name in at:
        small = share * asked.get(name, 0.0)
        columns.append((predict(r, start, at | {name: at[name] + small}) - seen) / small if small else np.zeros(len(seen)))
    more = [] if extra is None else list(extra.T)
    chance = [] if one.own is None else list(one.own.T)
    columns = columns[: len(start)] + chance + columns[len(start) :]
    rows = np.column_stack([*columns, *more, one.smooth, one.data - seen]) / np.reshape(one.sigma, (-1, 1))
    white = one.noise.whiten(rows, one.lag)
    count = len(start) + len(chance)
    sd = np.concatenate([own.sd, np.ones(len(chance))])
    off = np.concatenate([own.start[r] - start, np.zeros(len(chance))])
    held = np.isfinite(sd)
    prior = np.zeros((int(held.sum()), white.shape[1]))
    prior[:, :count] = np.diag(1 / sd)[held]
    prior[:, -1] = (off / sd)[held]
    triangle = np.asarray(np.linalg.qr(np.vstack([white, prior]), mode="r"))  # one array, whatever numpy's types say
    across, last = len(at) + len(more), triangle.shape[1] - 1
    below = triangle[count:]
    cost = float((white[:, -1] ** 2).sum() + (prior[:, -1] ** 2).sum())
    bulk = float(np.log(np.abs(np.diag(triangle)[:count][held]) * sd[held]).sum())  # what the free ones hold is the same for all
    made = Reduced(below[:, count : count + across], below[:, count + across : last], below[:, last], cost, bulk)

    def back(moved: np.ndarray) -> np.ndarray:
        right = triangle[:count, last] - triangle[:count, count : count + len(at)] @ moved[: len(at)]
        return solve_triangular(triangle[:count, :count] + 1e-300 * np.eye(count), right)[: len(start)]

    return made, back
