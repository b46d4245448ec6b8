"""Rolling shutter: a row further down is read later, so what falls seems faster than it is and what rises slower."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pandas as pd

from vision.measurement import FAILED, Quantity
from vision.motion.rebound import Rebound
from vision.motion.track import Track

STEPS = 9  # readouts that are tried where none is stated


def read_later(track: Track, share: np.ndarray, readout_s: float) -> Track:
    """The track with each place at the time its row was read; share (n,): 0 at the picture's top row, 1 at the lowest."""
    return replace(track, t_s=track.t_s + readout_s * share)


def over_readouts(
    track: Track, share: np.ndarray, readout_s: float | None, fps: float | None, measure: Callable[[Track], Rebound]
) -> tuple[Rebound, str]:
    """`measure` with the stated readout; where none is stated, the mean over all from 0 to one frame, each weighted by how well its
    parabolas, under the gravity and scale that are known, meet the way down and the way up. Also what to say of it.
    """
    if readout_s is not None:
        return (measure(read_later(track, share, readout_s)) if track.timed else measure(track)), ""
    plain = measure(track)
    if not track.timed or plain.flights is None or plain.bounces is None or not fps:
        return plain, ""
    tried = np.linspace(0, 1 / fps, STEPS)
    found = [plain, *(measure(read_later(track, share, r)) for r in tried[1:])]
    fits = [one.flights for one in found if one.flights is not None]
    cost = np.array([_cost(one, plain, min(fits, key=lambda f: f.noise).rho) for one in found])
    if not np.isfinite(cost).any():
        return plain, ""
    weight = np.exp(-(cost - cost.min()))
    weight /= weight.sum()
    best = found[int(np.argmax(weight))]
    sure = [(w, one) for w, one in zip(weight, found) if w > 1e-4]
    quantities = tuple(_mean_quantity(q, [(w, one.quantities[i]) for w, one in sure]) for i, q in enumerate(best.quantities))
    assert best.bounces is not None  # what has none costs infinitely much
    bounces = _mean_table(best.bounces, [(w, one.bounces) for w, one in sure if one.bounces is not None])
    middle = float(weight @ tried)
    sd = float(np.sqrt(weight @ (tried - middle) ** 2 + (tried[1] / 4) ** 2))
    note = f"[camera] readout_s is not stated; down and up agree best at {1e3 * middle:.2g} ± {1e3 * sd:.1g} ms, which the sds allow for"
    return replace(best, quantities=quantities, bounces=bounces), note


def _cost(one: Rebound, plain: Rebound, rho: float) -> float:
    """−log likelihood of a fit whose successive rows err together by rho, up to a constant; infinite where it found other bounces
    than the plain one, or contradicts a gravity that the plain one does not.
    """
    if one.flights is None or one.bounces is None or plain.bounces is None or len(one.bounces) != len(plain.bounces):
        return np.inf
    if one.contradicted and not plain.contradicted:
        return np.inf
    rows = sum(len(r) for r in one.flights.rows)
    free = rows * (1 - rho) / (1 + rho)
    return max(free, 4.0) * float(np.log(max(one.flights.noise, 1e-9))) + (1e6 if one.contradicted else 0.0)


def _mean(parts: list[tuple[float, float, float]]) -> tuple[float, float]:
    """Mean and sd of a mixture of (weight, value, sd)."""
    weight, value, sd = np.array(parts).T
    middle = float(weight @ value / weight.sum())
    return middle, float(np.sqrt(weight @ (sd**2 + (value - middle) ** 2) / weight.sum()))


def _mean_quantity(best: Quantity, parts: list[tuple[float, Quantity]]) -> Quantity:
    if best.quality == FAILED:
        return best
    value, sd = _mean([(w, q.value, q.sd) for w, q in parts if q.quality != FAILED])
    return replace(best, value=value, sd=sd)


def _mean_table(best: pd.DataFrame, parts: list[tuple[float, pd.DataFrame]]) -> pd.DataFrame:
    """The best table with each number that has an sd, and this sd, from the mixture."""
    out = best.copy()
    for spread in [c for c in best if "_sd" in c]:
        name = spread.replace("_sd", "", 1)
        for row in range(len(best)):
            out.loc[row, [name, spread]] = _mean([(w, t[name].iloc[row], t[spread].iloc[row]) for w, t in parts])
    return out
