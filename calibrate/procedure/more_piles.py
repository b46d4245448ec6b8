"""Piles beyond the design: each where it is expected to tell most of the parameters,
until the intervals stop shrinking."""

from typing import cast

import numpy as np
import pandas as pd

from benchtwin.calibrate.procedure.pile_stage import PileStage
from benchtwin.calibrate.procedure.pile_surrogate import (
    PileObservables,
    joined,
    observed,
)
from benchtwin.calibrate.procedure.rigs import PILE
from benchtwin.calibrate.statistics.box import Box
from benchtwin.calibrate.statistics.information import (
    Weighted,
    most_informative,
    weighted,
)
from benchtwin.calibrate.statistics.prior import Prior
from benchtwin.calibrate.statistics.shrinkage import ShrinkageSurface

BATCH = 4  # piles chosen and simulated at a time: what a small machine runs at once
# stop when the intervals are not this share narrower than so many batches before: less
# is not worth the time of eight piles
WAIT, LEAST_GAIN = 2, 0.03
# candidates, and points of the posterior over which information is averaged: some
# hundreds, so that choosing takes moments where a pile takes minutes
CORNERS, INSIDE, LIKELY, DRAWS = 150, 150, 100, 200
PACKINGS = 500  # first packing number: none that the design has


def add_piles(
    stage: PileStage,
    box: Box,
    done: pd.DataFrame,
    *,
    shared: bool,
    known: tuple[PileObservables, ...] = (),
) -> tuple[pd.DataFrame, list[str]]:
    """Simulate up to `stage.effort.more` piles, or runs of the stage's rig, beyond
    those done; all of them, and a note of how many were added and what they did. known:
    what other rigs say."""
    rng = np.random.default_rng([stage.seed, PACKINGS])
    prior, widths, added = _prior(stage, box, known), [], 0
    what = "piles" if stage.rig is PILE else stage.rig.rig.in_plural
    while True:
        seen = observed(
            done,
            stage.readings,
            box,
            stage.steel,
            alike=stage.alike,
            shared=shared,
            rig=stage.rig,
        )
        if not seen.observables:
            return done, []
        observables, correlation = joined((*known, seen))
        posterior = weighted(observables, prior, correlation.to_numpy(), rng)
        widths.append(_width(posterior, box))
        settled = (
            len(widths) > WAIT and widths[-1] > (1 - LEAST_GAIN) * widths[-1 - WAIT]
        )
        if settled or added >= stage.effort.more:
            break
        points = next_piles(posterior, seen, min(BATCH, stage.effort.more - added), rng)
        _, new = stage.piles(points, PACKINGS + added + np.arange(len(points)))
        done = pd.concat([done, new], ignore_index=True)
        added += len(points)
    if not added:
        return done, []
    if settled:
        ended = "then they shrank no more"
    else:
        ended = "they were still shrinking when no more were allowed"
    return done, [
        f"{added} {what} more than the design's, where they tell most: seed–seed"
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
    drawn = posterior.draw(DRAWS, rng)
    chosen = most_informative(candidates, drawn, surfaces, names, count)
    rounded = np.clip(np.vectorize(lambda v: float(f"{v:.6g}"))(chosen), low, high)
    return pd.DataFrame(rounded, columns=list(names))


def _prior(stage: PileStage, box: Box, known: tuple[PileObservables, ...]) -> Prior:
    """Seed–seed parameters uniform over the design's box, seed–steel ones as their own
    rigs found them, what nobody stated as it is believed."""
    own = stage.steel.names if stage.steel is not None else ()
    found = {n: v for n, v in stage.steel_found.items() if n in own and v[1] > 0}
    wide = box.with_factors(stage.steel)
    for name, key in ((n, k) for part in known for n, k in part.believed.items()):
        wide, found[name] = (
            wide.with_factors(Box.of({name: key.ends})),
            (key.mean, key.sd),
        )
    return Prior(wide, found)


def _width(posterior: Weighted, box: Box) -> float:
    """Geometric mean of the seed–seed parameters' sds, in those of the prior."""
    k = len(box.names)
    return float(np.exp(np.log(posterior.sd[:k] / posterior.prior.sd[:k]).mean()))
