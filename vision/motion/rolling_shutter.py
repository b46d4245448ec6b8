"""Corrects a rolling shutter: lower rows are read later, so falling seeds seem faster
and rising ones slower."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pandas as pd
from benchtwin.vision.measurement import FAILED
from benchtwin.vision.motion.rebound import Rebound
from benchtwin.vision.motion.track import Track

STEPS = 9  # readout times that are tried where none is stated


def average_over_readouts(
    track: Track,
    share: np.ndarray,
    readout_s: float | None,
    fps: float | None,
    measure: Callable[[Track], Rebound],
) -> tuple[Rebound, str]:
    """`measure` at the stated readout time, and a note. Where none is stated: the mean
    over readout times from 0 to one frame, weighted by the likelihood of the parabolas
    under the known gravity and scale, which differ between falling and rising."""

    def at(readout_s: float) -> Rebound:
        """As measured with each place at the time at which its row was read."""
        return measure(replace(track, t_s=track.t_s + readout_s * share))

    if readout_s is not None:
        return at(readout_s), ""
    plain = measure(track)
    if not track.timed or plain.flights is None or plain.bounces is None or not fps:
        return plain, ""
    tried = np.linspace(0, 1 / fps, STEPS)
    found = [plain, *(at(r) for r in tried[1:])]
    fits = [one.flights for one in found if one.flights is not None]
    cost = np.array(
        [
            _negative_log_likelihood(one, plain, min(fits, key=lambda f: f.noise).rho)
            for one in found
        ]
    )
    if not np.isfinite(cost).any():
        return plain, ""
    weight = np.exp(-(cost - cost.min()))
    weight /= weight.sum()
    best = found[int(np.argmax(weight))]
    likely = [(w, one) for w, one in zip(weight, found) if w > 1e-4]
    quantities = []
    for i, q in enumerate(best.quantities):
        if q.quality != FAILED:
            others = [(w, one.quantities[i]) for w, one in likely]
            value, sd = _mean(
                [(w, o.value, o.sd) for w, o in others if o.quality != FAILED]
            )
            q = replace(q, value=value, sd=sd)
        quantities.append(q)
    assert best.bounces is not None  # those without have weight 0
    bounces = _mean_table(
        best.bounces, [(w, one.bounces) for w, one in likely if one.bounces is not None]
    )
    middle = float(weight @ tried)
    readout_sd = float(np.sqrt(weight @ (tried - middle) ** 2 + (tried[1] / 4) ** 2))
    best_ms = f"{1e3 * middle:.2g} ± {1e3 * readout_sd:.1g} ms"
    note = (
        "[camera] readout_s is not stated; falling and rising parts agree best at"
        f" {best_ms}, which the sds allow for"
    )
    return replace(best, quantities=tuple(quantities), bounces=bounces), note


def _negative_log_likelihood(one: Rebound, plain: Rebound, rho: float) -> float:
    """−ln likelihood of a fit with noise correlated by rho, up to a constant. Infinite
    where it found other bounces than the plain fit, or contradicts gravity where the
    plain fit does not."""
    if (
        one.flights is None
        or one.bounces is None
        or plain.bounces is None
        or len(one.bounces) != len(plain.bounces)
    ):
        return np.inf
    if one.contradicted and not plain.contradicted:
        return np.inf
    rows = sum(len(r) for r in one.flights.rows)
    free = rows * (1 - rho) / (1 + rho)
    return max(free, 4.0) * float(np.log(max(one.flights.noise, 1e-9))) + (
        1e6 if one.contradicted else 0.0
    )


def _mean(parts: list[tuple[float, float, float]]) -> tuple[float, float]:
    """Mean and sd of a mixture of normals (weight, value, sd)."""
    weight, value, sd = np.array(parts).T
    middle = float(weight @ value / weight.sum())
    return middle, float(
        np.sqrt(weight @ (sd**2 + (value - middle) ** 2) / weight.sum())
    )


def _mean_table(
    best: pd.DataFrame, parts: list[tuple[float, pd.DataFrame]]
) -> pd.DataFrame:
    """The best table with the numbers that have an sd, and these, replaced by those of
    the mixture."""
    out = best.copy()
    for spread in [c for c in best if "_sd" in c]:
        name = spread.replace("_sd", "", 1)
        for row in range(len(best)):
            out.loc[row, [name, spread]] = _mean(
                [(w, t[name].iloc[row], t[spread].iloc[row]) for w, t in parts]
            )
    return out
