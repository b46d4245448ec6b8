"""A rig that tells of seed on seed, simulated: a design over all of the range, then
runs where they are expected to tell most, until the intervals stop shrinking."""

from dataclasses import replace

import numpy as np
import pandas as pd
from scipy import stats

from benchtwin.bench.language import tr
from benchtwin.bench.numbers import with_unit
from benchtwin.bench.tells import BySurface
from benchtwin.calibrate.procedure.observed import (
    PileObservables,
    joined,
    observed,
)
from benchtwin.calibrate.procedure.pile_stage import PileStage
from benchtwin.calibrate.procedure.rigs import SEED_LIMITS
from benchtwin.calibrate.procedure.simulator import SimulationFailed
from benchtwin.calibrate.statistics.box import Box
from benchtwin.calibrate.statistics.designs import space_filling
from benchtwin.calibrate.statistics.information import (
    Weighted,
    most_informative,
    weighted,
)
from benchtwin.calibrate.statistics.posterior import REACHED_Z, residual
from benchtwin.calibrate.statistics.prior import Prior

LEAST_RUNS = 12  # that were measured: fewer lay no surface over three parameters
USABLE = 0.6  # share of a design's runs: with fewer it is another design
# times that ranges are doubled where nothing in them gives the bench's reading, and
# sds of a main effect from which its sign is known
WIDENINGS, CLEAR = 2, 2
BATCH = 4  # piles chosen and simulated at a time: what a small machine runs at once
# stop when the intervals are not this share narrower than so many batches before: less
# is not worth the time of eight piles
WAIT, LEAST_GAIN = 2, 0.03
# candidates, and points of the posterior over which information is averaged: some
# hundreds, so that choosing takes moments where a pile takes minutes
CORNERS, INSIDE, LIKELY, DRAWS = 150, 150, 100, 200
# first packing numbers of the design and of piles beyond it
DESIGN_PACKINGS, PACKINGS = 100, 500


def simulate_design(stage: PileStage, widened: int = 0) -> pd.DataFrame:
    """The design's runs that were measured. SimulationFailed where they are too few."""
    two_level = len(stage.steel.names) if stage.steel is not None else 0
    points = space_filling(stage.wide, stage.effort.design, two_level=two_level)
    table, done = stage.piles(points, DESIGN_PACKINGS * (1 + widened))
    if len(done) < max(LEAST_RUNS, USABLE * len(points)):
        why = ""
        if len(lost := table[~table["status"].eq("done")]):
            first = lost.iloc[0]
            again = (
                tr("; run it alone: {}", first["rerun"]) if first.get("rerun") else ""
            )
            why = f" ({first['reason'] or first['status']}{again})"
        raise SimulationFailed(
            tr(
                "{}: {} of {} simulated runs could be measured{}",
                stage.rig.name,
                len(done),
                len(points),
                why,
            )
        )
    return done


def simulate_seeds(
    stage: PileStage, known: tuple[PileObservables, ...]
) -> PileObservables:
    """What the bench's recordings of the stage's rig say of the parameters, beside what
    is `known` from other rigs. SimulationFailed; ValueError where nothing can be
    compared."""
    done, notes = simulate_design(stage), []
    for widened in range(1, WIDENINGS + 1) if not known else ():
        if (box := _wider(stage, _seen(stage, done))) is None:
            break
        stage = replace(stage, box=box)
        new = simulate_design(stage, widened)
        done = pd.concat([done, new], ignore_index=True)
        notes.append(
            tr("nothing in the range gave the bench's reading: it was widened")
        )
    done, more = add_piles(stage, done, known=known)
    seen = _seen(stage, done)
    said = dict.fromkeys((*notes, *_left_open(stage), *more, *seen.notes))
    values = stage.readings.values if stage.readings is not None else np.zeros(0)
    return replace(
        seen,
        notes=tuple(said),
        findings=too_scattered(seen, values, stage.rig),
        believed=stage.left_open,
    )


def _seen(stage: PileStage, done: pd.DataFrame) -> PileObservables:
    if stage.readings is None:
        raise ValueError(tr("{}: the bench has no recording of it", stage.rig.name))
    seen = observed(
        done, stage.readings, stage.box, stage.steel, alike=stage.alike, rig=stage.rig
    )
    if not seen.observables:
        raise ValueError(
            tr("{}: nothing of it can be compared with a simulation", stage.rig.name)
        )
    return seen


def _wider(stage: PileStage, seen: PileObservables) -> Box | None:
    """The box with the range of every factor doubled towards the bench's reading, as
    far as its effect is known; None where some point of the box gives the reading, or
    nothing can be doubled."""
    rng = np.random.default_rng([stage.seed, PACKINGS])
    prior, first = _prior(stage, ()), seen.observables[0]
    z, *_ = residual(prior.draw(4000, rng), first, prior)
    nearest = z[np.argmin(abs(z))]
    if abs(nearest) < REACHED_Z:
        return None
    surrogate, ranges = seen.surrogates[0], {}
    sds = np.sqrt(np.diag(surrogate.covariance))
    for k, name in enumerate(stage.box.names, 1):
        (low, high), (least, most) = stage.box.range(name), SEED_LIMITS[name]
        effect = surrogate.coefficients[k] * np.sign(nearest)
        if effect > CLEAR * sds[k]:
            high = min(most, 2 * high - low)
        elif effect < -CLEAR * sds[k]:
            low = max(least, 2 * low - high)
        ranges[name] = (low, high)
    wider = Box.of(ranges)
    same = np.allclose(wider.half_width, stage.box.half_width)
    return None if same else wider


def _left_open(stage: PileStage) -> list[str]:
    name = stage.rig.rig.name
    stated = stage.description.get(name, {})
    return [
        tr(
            "[{}] {} is not stated: {:g} ± {:g} is believed, which widens the"
            " intervals; measure and state it",
            name,
            key,
            of.mean,
            of.sd,
        )
        for factor, of in stage.left_open.items()
        if (key := factor.rpartition(".")[2]) not in stated
    ]


def too_scattered(
    seen: PileObservables, values: np.ndarray, rig: BySurface, alpha: float = 0.001
) -> tuple[str, ...]:
    """A finding where the bench's piles scatter more than simulated ones of one packing
    after another can (F test)."""
    noise, own = seen.surrogates[0], 0.0
    single = noise.noise_sd * float(np.sqrt(rig.per_run))
    if values.size > 1:
        own = float(values.std(ddof=1))
    ratio = own**2 / single**2
    if not own or stats.f.sf(ratio, values.size - 1, noise.noise_df) >= alpha:
        return ()
    unit = with_unit(rig.unit)
    return (
        tr(
            "finding for diagnosis: the bench's {} scatter by {:.2g}{}, simulated ones"
            " by {:.2g}{}: recordings contradict one another, or the bench has"
            " something that the simulation has not",
            rig.in_plural,
            own,
            unit,
            single,
            unit,
        ),
    )


def add_piles(
    stage: PileStage,
    done: pd.DataFrame,
    *,
    known: tuple[PileObservables, ...] = (),
) -> tuple[pd.DataFrame, list[str]]:
    """Simulate up to `stage.effort.more` runs of the stage's rig beyond those done; all
    of them, and a note of how many were added and what they did. known: what other rigs
    say."""
    rng = np.random.default_rng([stage.seed, PACKINGS])
    prior, widths, added = _prior(stage, known), [], 0
    while True:
        seen = _seen(stage, done)
        observables, correlation = joined((*known, seen))
        posterior = weighted(observables, prior, correlation.to_numpy(), rng)
        widths.append(_width(posterior, stage.box))
        settled = (
            len(widths) > WAIT and widths[-1] > (1 - LEAST_GAIN) * widths[-1 - WAIT]
        )
        if settled or added >= stage.effort.more:
            break
        points = next_piles(posterior, seen, min(BATCH, stage.effort.more - added), rng)
        _, new = stage.piles(points, PACKINGS + added)
        done = pd.concat([done, new], ignore_index=True)
        added += len(points)
    if not added:
        return done, []
    ended = tr("they were still shrinking when no more were allowed")
    if settled:
        ended = tr("then they shrank no more")
    readings = added * stage.rig.per_run
    return done, [
        tr(
            "{} {} more than the design's, where they tell most: the intervals of the"
            " seed–seed parameters came to {:.0%} of their width; {}",
            readings,
            stage.rig.in_plural,
            widths[-1] / widths[0],
            ended,
        )
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
    sds = (o.bench.sd for o in seen.observables)
    surfaces = list(zip(seen.surrogates, sds))
    drawn = posterior.draw(DRAWS, rng)
    chosen = most_informative(candidates, drawn, surfaces, names, count)
    rounded = np.clip(np.vectorize(lambda v: float(f"{v:.6g}"))(chosen), low, high)
    return pd.DataFrame(rounded, columns=list(names))


def _prior(stage: PileStage, known: tuple[PileObservables, ...]) -> Prior:
    """Seed–seed parameters uniform over the box, seed–steel ones as their own rigs
    found them, what nobody stated as it is believed."""
    own = stage.steel.names if stage.steel is not None else ()
    found = {n: v for n, v in stage.steel_found.items() if n in own and v[1] > 0}
    wide = stage.wide
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
