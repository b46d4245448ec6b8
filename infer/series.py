"""Problems in which each recording is a series of one quantity: travel, way, height of
a surface.

predict(r, own (L,), values) → (n_r,): the rows of recording r for its locals `own` and
the globals by name. Derivatives are finite differences; rows are whitened; locals are
eliminated by QR."""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any

import numpy as np
from scipy.linalg import solve_triangular

from benchtwin.infer.effect import Effect
from benchtwin.infer.least_squares import FastChi2
from benchtwin.infer.linear import Reduced
from benchtwin.infer.noise import Noise, about_slopes, estimate, spreads
from benchtwin.infer.problem import Fit, Problem

# of a prior's sd, for derivatives; less where predictions are exact and bend much
# within a sd
STEP = 1e-3
FLAT = 1e3  # of a local without a prior, in its own unit
SPREADS = (1e-4, 1e3)  # of few rows, over their sds


@dataclass(frozen=True, eq=False)
class Series:
    """One recording."""

    recording: str
    data: np.ndarray  # (n,)
    sigma: np.ndarray | float  # (n,) or scalar, in the data's unit
    lag: np.ndarray  # (n,): see frame_lag
    noise: Noise
    smooth: np.ndarray  # (n, s): curves that no effect needs
    # derivatives (n,) that are the same everywhere, by number of a local or name of a
    # global; all others are finite differences
    slopes: dict[int | str, np.ndarray] = field(default_factory=dict)
    known: int = 0  # how many of the last rows have an sd that is known by itself

    @property
    def few(self) -> bool:
        """Whether each row errs by itself."""
        return bool(np.isinf(self.lag).all())


@dataclass(frozen=True, eq=False)
class Locals:
    """Parameters of the recordings' own."""

    start: np.ndarray  # (R, L)
    step: np.ndarray  # (L,): for derivatives
    sd: np.ndarray  # (L,): prior about `start`, inf where flat (these first)


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
    max_iterations: int = 12,
    step: float = STEP,
    smooth: bool = False,
) -> Problem:
    """A problem from its series.

    own: locals; predict: see above; effects: candidates whose laws `predict` knows;
    nuisances: typical sizes of further globals, for derivatives; known_sd: see Problem;
    step: of derivatives, in prior sds; smooth: predictions have no kinks, so χ² itself
    decides whether a step is too long."""
    sizes = {n: e.prior_sd for n, e in effects.items()} | nuisances
    rows = sum(len(s.data) for s in series) - int(np.isinf(own.sd).sum()) * len(series)
    level, held = max(s.noise.log_level_sd for s in series), np.isfinite(own.sd)
    linearised = partial(reduce, series, own, predict, sizes, step=step, smooth=smooth)

    def chi2(starts: np.ndarray, values: np.ndarray) -> float:
        at, total = dict(zip(sizes, values, strict=True)), 0.0
        for r, s in enumerate(series):
            white = s.noise.whiten(
                ((s.data - predict(r, starts[r], at)) / s.sigma)[:, None], s.lag
            )
            off = ((own.start[r] - starts[r]) / own.sd)[held]
            total += float((white**2).sum()) + float((off**2).sum())
        return total

    def derivatives(r, starts, values):
        at = dict(zip(sizes, values, strict=True))
        found = _derivatives(series[r], own, predict, sizes, r, starts[r], at, step)
        return found[0], np.column_stack(found[1])

    def reduce_free(starts, values, wanted):
        return linearised(starts, values, wanted=wanted)

    return Problem(
        rig,
        tuple(s.recording for s in series),
        effects,
        tuple(sizes),
        known_sd,
        own.start,
        linearised,
        rows,
        level,
        model,
        max_iterations,
        fast_chi2=FastChi2(chi2, reduce_free) if smooth else None,
        own_sd=own.sd,
        own_centre=own.start,
        series=series,
        derivatives=derivatives,
    )


def noise_about(base: Fit) -> tuple[Noise, np.ndarray]:
    """Noise of all recordings but those of few rows, about a fit and its slopes, those
    by effects and smooth curves too, so that what may be missing is not taken for
    noise; and σ (R,) of each over the sds that its rows have, 1 of few rows."""
    series, owners, stretches = base.problem.series, [], []
    for r, one in enumerate(series):
        if one.few:
            continue
        left, columns = _white(base, r)
        design = np.column_stack([columns, one.smooth / np.reshape(one.sigma, (-1, 1))])
        design, left = (rows[: len(rows) - one.known] for rows in (design, left))
        stretches.append(about_slopes(design, left, one.lag[: len(left)]))
        owners.append(r)
    noise, factor = estimate(stretches), np.ones(len(series))
    factor[owners] = spreads(stretches, range(len(owners)), len(owners), noise)
    return noise, factor


def spread_of_few(base: Fit, usual: float) -> tuple[float, float]:
    """σ of the rows of all recordings of few rows, over the sds that these have, and
    the rows that tell it, as the parameters' priors let them: at the greatest
    restricted likelihood, linearised at a fit, effects free as their priors let them;
    usual: rows that σ = 1 counts as."""
    problem, few = base.problem, [r for r, s in enumerate(base.problem.series) if s.few]
    alone = {n: e.prior_sd for n, e in problem.effects.items() if not e.group}
    shared = np.hypot(base.prior_sd, [alone.get(n, 0.0) for n in base.names])
    own_sd = np.where(np.isfinite(problem.own_sd), problem.own_sd, FLAT)
    width, blocks, data = len(own_sd), [], []
    for k, r in enumerate(few):
        left, columns = _white(base, r)
        columns = columns * np.append(own_sd, shared)
        off = (base.starts[r] - problem.own_centre[r]) / own_sd
        told = np.divide(
            base.values, shared, out=np.zeros(len(shared)), where=shared > 0
        )
        rows = slice(None, len(left) - problem.series[r].known)
        block = np.zeros((len(left), width * len(few) + len(shared)))
        block[:, width * k : width * (k + 1)] = columns[:, :width]
        block[:, width * len(few) :] = columns[:, width:]
        blocks.append(block[rows])
        data.append((left + columns @ np.append(off, told))[rows])
    axes, sizes, _ = np.linalg.svd(np.vstack(blocks))
    square = (axes.T @ np.concatenate(data)) ** 2
    shown = np.append(sizes, np.zeros(len(square) - len(sizes))) ** 2
    sigma = np.geomspace(*SPREADS, 400)
    whole = shown + sigma[:, None] ** 2
    ln = -(np.log(whole) + square / whole).sum(axis=1) / 2
    ln -= usual * (np.log(sigma) + 1 / (2 * sigma**2))
    best = int(np.argmax(ln))
    return float(sigma[best]), float((sigma[best] ** 2 / whole[best]).sum())


def _white(base: Fit, r: int) -> tuple[np.ndarray, np.ndarray]:
    """Residuals (n,) of recording r and its slopes (n, L + G), over the rows' sds."""
    one = base.problem.series[r]
    assert base.problem.derivatives is not None
    seen, columns = base.problem.derivatives(r, base.starts, base.values)
    return (one.data - seen) / one.sigma, columns / np.reshape(one.sigma, (-1, 1))


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
    looser: float = 1.0,
):
    """See Problem.reduce; extra: (n_r, K) for each recording; wanted (G,): columns to
    compute; looser: factor on the sds of all rows."""
    asked = (
        sizes
        if wanted is None
        else {n: size for (n, size), w in zip(sizes.items(), wanted, strict=True) if w}
    )
    at = dict(zip(sizes, values, strict=True))
    more = [None] * len(series) if extra is None else extra
    made = [
        _reduced(s, own, predict, asked, r, starts[r], at, more[r], step, looser)
        for r, s in enumerate(series)
    ]
    width = made[0][0].a.shape[1] - len(values)
    theta = np.concatenate([values, np.zeros(width)])
    reduced = tuple(
        replace(m, b=m.b + m.a @ theta, chi2=m.chi2 if smooth else None)
        for m, _ in made
    )

    def change(moved: np.ndarray) -> np.ndarray:
        """moved (G,), or (R, G) where a recording has its own."""
        each = np.broadcast_to(moved, (len(made), moved.shape[-1]))
        return np.array([back(own) for (_, back), own in zip(made, each, strict=True)])

    return reduced, change


def _derivatives(
    one: Series,
    own: Locals,
    predict: Callable,
    asked: dict[str, float],
    r: int,
    start: np.ndarray,
    at: dict[str, float],
    share: float,
) -> tuple[np.ndarray, list[np.ndarray]]:
    """Rows (n,) predicted of recording r, and their derivatives by its locals and by
    the globals, 0 by those that are not asked for."""
    seen = predict(r, start, at)
    columns = [
        one.slopes[k]
        if k in one.slopes
        else (predict(r, start + step, at) - seen) / own.step[k]
        for k, step in enumerate(np.diag(own.step))
    ]
    for name in at:
        small = share * asked.get(name, 0.0)
        if small and name in one.slopes:
            columns.append(one.slopes[name])
            continue
        columns.append(
            (predict(r, start, at | {name: at[name] + small}) - seen) / small
            if small
            else np.zeros(len(seen))
        )
    return seen, columns


def _reduced(
    one: Series,
    own: Locals,
    predict,
    asked,
    r: int,
    start: np.ndarray,
    at: dict[str, float],
    extra,
    share: float,
    looser: float,
):
    """One recording linearised in the globals in `asked`; function from them to its
    locals."""
    seen, columns = _derivatives(one, own, predict, asked, r, start, at, share)
    more = [] if extra is None else list(extra.T)
    rows = np.column_stack([*columns, *more, one.smooth, one.data - seen]) / np.reshape(
        one.sigma * looser, (-1, 1)
    )
    white = one.noise.whiten(rows, one.lag)
    count, sd, off, held = len(start), own.sd, own.start[r] - start, np.isfinite(own.sd)
    prior = np.zeros((int(held.sum()), white.shape[1]))
    prior[:, :count] = np.diag(1 / sd)[held]
    prior[:, -1] = (off / sd)[held]
    # one array, whatever numpy's types say
    triangle = np.asarray(np.linalg.qr(np.vstack([white, prior]), mode="r"))
    across, last = len(at) + len(more), triangle.shape[1] - 1
    below = triangle[count:]
    chi2 = float((white[:, -1] ** 2).sum() + (prior[:, -1] ** 2).sum())
    half_ln_det = float(
        np.log(np.abs(np.diag(triangle)[:count][held]) * sd[held]).sum()
    )  # flat priors add a constant
    made = Reduced(
        below[:, count : count + across],
        below[:, count + across : last],
        below[:, last],
        chi2,
        half_ln_det,
        triangle[:count, :count],
    )

    def back(moved: np.ndarray) -> np.ndarray:
        right = (
            triangle[:count, last]
            - triangle[:count, count : count + len(at)] @ moved[: len(at)]
        )
        return solve_triangular(
            triangle[:count, :count] + 1e-300 * np.eye(count), right
        )

    return made, back
