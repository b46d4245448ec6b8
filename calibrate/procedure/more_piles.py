"""Piles beyond the design: each where it is expected to tell most of the parameters,
until the intervals stop shrinking."""

from typing import cast

import numpy as np
import pandas as pd
from benchtwin.calibrate.procedure.pile_stage import PileStage
from benchtwin.calibrate.procedure.pile_surrogate import PileObservables, observed
from benchtwin.calibrate.statistics.box import Box
from benchtwin.calibrate.statistics.information import (
    Weighted,
    most_informative,
    weighted,
)
from benchtwin.calibrate.statistics.prior import Prior
from benchtwin.calibrate.statistics.shrinkage import ShrinkageSurface

BATCH = 4  # piles chosen and simulated at a time
WAIT, LEAST_GAIN = (
    2,
    0.03,
)  # stop when the intervals are not this share narrower than so many batches before
CORNERS, INSIDE, LIKELY = 150, 150, 100  # candidates
DRAWS = 200  # points of the posterior over which information is averaged
PACKINGS = 500  # first packing number: none that the design has


def add_piles(stage: PileStage, box: Box, *, shared: bool) -> list[str]:
    """Simulate up to `stage.effort.more` piles, which `stage.done` then holds too; a
    note of how many, and what they did."""
    rng = np.random.default_rng([stage.seed, PACKINGS])
    prior, widths, added = _prior(stage, box), [], 0
    while True:
        seen = observed(
            pd.concat(stage.done, ignore_index=True),
            stage.readings,
            box,
            stage.steel,
            alike=stage.alike,
            shared=shared,
        )
        if not seen.observables:
            return []
        posterior = weighted(seen.observables, prior, seen.correlation.to_numpy(), rng)
        widths.append(_width(posterior, box))
        settled = (
            len(widths) > WAIT and widths[-1] > (1 - LEAST_GAIN) * widths[-1 - WAIT]
        )
        if settled or added >= stage.effort.more:
            break
        points = next_piles(posterior, seen, min(BATCH, stage.effort.more - added), rng)
        stage.piles(points, PACKINGS + added + np.arange(len(points)))
        added += len(points)
    if not added:
        return []
    ended = (
        "then they shrank no more"
        if settled
        else "they were still shrinking when no more were allowed"
    )
    return [
        f"{added} piles more than the design's, where they tell most: seed–seed"
        f" intervals came to {widths[-1] / widths[0]:.0%} of their width; {ended}"
    ]


def next_piles(
    posterior: Weighted, seen: PileObservables, count: int, rng: np.random.Generator
) -> pd.DataFrame:
    """The most informative of drawn candidates, a row a pile: corners of the box,
    points inside it, points of the posterior."""
    low, high = posterior.prior.box.low, posterior.prior.box.high
    corners = np.where(rng.random((CORNERS, len(low))) < 0.5, low, high)
    inside = rng.uniform(low, high, (INSIDE, len(low)))
    candidates = np.vstack([corners, inside, posterior.draw(LIKELY, rng)])
    names = posterior.prior.box.names
    surfaces = [
        (cast(ShrinkageSurface, o.surrogate), o.bench.sd) for o in seen.observables
    ]
    chosen = most_informative(
        candidates, posterior.draw(DRAWS, rng), surfaces, names, count
    )
    rounded = np.clip(np.vectorize(lambda v: float(f"{v:.6g}"))(chosen), low, high)
    return pd.DataFrame(rounded, columns=list(names))


def _prior(stage: PileStage, box: Box) -> Prior:
    """Seed–seed parameters uniform over the design's box, seed–steel ones as their own
    rigs found them."""
    if stage.steel is None:
        return Prior.uniform(box)
    s = stage.steel
    wide = Box((*box.names, *s.names), np.r_[box.low, s.low], np.r_[box.high, s.high])
    return Prior(
        wide, {n: v for n, v in stage.steel_found.items() if n in s.names and v[1] > 0}
    )


def _width(posterior: Weighted, box: Box) -> float:
    """Geometric mean of the seed–seed parameters' sds, in those of the prior."""
    k = len(box.names)
    return float(np.exp(np.log(posterior.sd[:k] / posterior.prior.sd[:k]).mean()))
