"""Prediction of recordings that were left out when an explanation's parameters were
estimated."""

from dataclasses import dataclass

import numpy as np

from benchtwin.infer.evidence import Kind
from benchtwin.infer.explanation import Explanation
from benchtwin.infer.linear import (
    Reduced,
    fall_of_chi2,
    projector,
    ridge,
    stacked,
)
from benchtwin.infer.posterior import WIDE_PRIOR

CHANCE_SDS = 2.0  # of the left-out error that noise alone makes
UNLISTED_PRIOR = 10.0  # factor on the sd of unlisted physics, whose own is just visible


@dataclass(frozen=True)
class HeldOut:
    """How well left-out recordings are predicted."""

    rmse_ratio: float  # √(SSE_fit/SSE_base) of whitened residuals
    # gain/(gain + misfit left beyond chance), gain = SSE_base − SSE_fit
    removed_fraction: float


def held_out(
    e: Explanation, base: Explanation, followed: tuple[str, ...] = ()
) -> HeldOut | None:
    """Each recording predicted from the others, without what is found and the globals
    `followed`, and with them; None for a single recording."""
    mine, sd = with_components(e)
    if len(mine) < 2:
        return None
    sse_fit = sum(squared_errors(mine, sd))
    bare = np.where(np.isin(base.fit.names, followed), 0.0, base.fit.baseline_sd)
    sse_base = sum(squared_errors(base.reduced, bare))
    noise, spread = _noise(mine, sd)
    gain, left = sse_base - sse_fit, max(sse_fit - noise - CHANCE_SDS * spread, 0.0)
    if others := [c.columns for n, c in e.table.components.items() if n not in e.names]:
        a, b = stacked(mine)  # fall of χ² when every other component is freed too
        fall, freedom = fall_of_chi2(np.hstack(others), projector(a, sd), b)
        left = max(left, fall - freedom - CHANCE_SDS * float(np.sqrt(2 * freedom)))
    share = gain / (gain + left) if gain > 0 else 0.0
    return HeldOut(float(np.sqrt(sse_fit / sse_base)), float(share))


def with_components(e: Explanation) -> tuple[tuple[Reduced, ...], np.ndarray]:
    """The linearisation with the explanation's components as columns, and all prior
    sds."""
    parts = [e.table.components[n] for n in e.names]
    cuts = np.cumsum([0, *(len(r.b) for r in e.reduced)])
    out = []
    for r, low, high in zip(e.reduced, cuts[:-1], cuts[1:], strict=True):
        out.append(
            Reduced(
                np.hstack([r.a, *(p.columns[low:high] for p in parts)]), r.smooth, r.b
            )
        )
    seen = [UNLISTED_PRIOR if p.kind is Kind.UNLISTED else 1.0 for p in parts]
    wide = [
        np.where(p.scaled_prior, WIDE_PRIOR, 1.0) * p.sd * s
        for p, s in zip(parts, seen)
    ]
    return tuple(out), np.concatenate([e.fit.baseline_sd, *wide])


def squared_errors(reduced: tuple[Reduced, ...], prior_sd: np.ndarray) -> list[float]:
    """Sum of squares of each recording about the prediction of the others."""
    out = []
    for r, own in enumerate(reduced):
        theta = ridge(*stacked(reduced[:r] + reduced[r + 1 :]), prior_sd)[0]
        out.append(float(((own.b - own.a @ theta) ** 2).sum()))
    return out


def left_out_values(e: Explanation) -> dict[str, tuple[float, ...]]:
    """Each parameter of the listed effects as the other recordings have it."""
    reduced, sd = with_components(e)
    first = len(e.fit.names)
    spots: dict[str, int] = {}
    for n in e.names:
        columns = e.fit.problem.columns_of(n) if n in e.listed else ()
        spots |= {c: first + k for k, c in enumerate(columns)}
        first += len(e.table.components[n].sd)
    out: dict[str, list[float]] = {n: [] for n in spots}
    for r in range(len(reduced)):
        theta = ridge(*stacked(reduced[:r] + reduced[r + 1 :] or reduced), sd)[0]
        for n, at in spots.items():
            out[n].append(float(theta[at]))
    return {n: tuple(values) for n, values in out.items()}


def _noise(reduced: tuple[Reduced, ...], prior_sd: np.ndarray) -> tuple[float, float]:
    """Mean and sd of the left-out SSE under the true model.

    What a saturated model leaves, plus one a column, less where recordings differ by
    less than their priors allow."""
    columns, bare = 0, 0.0
    for own in reduced:
        fall, count = fall_of_chi2(np.hstack([own.a, own.smooth]), lambda x: x, own.b)
        bare, columns = bare + float((own.b**2).sum()) - fall, columns + count
    a, b = stacked(reduced)
    theta, covariance, _ = ridge(a, b, prior_sd)
    spare = columns - float(np.einsum("ij,jk,ik->", a, covariance, a))
    power = min(
        (float(((b - a @ theta) ** 2).sum()) - bare) / spare if spare > 0 else 1.0, 1.0
    )
    return bare + columns * power, power * float(np.sqrt(2 * columns))
