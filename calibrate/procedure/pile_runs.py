"""Seed–seed piles simulated: noise, path, design with common packings, piles where they
tell most, verification."""

from dataclasses import dataclass, replace

import numpy as np
import pandas as pd
from scipy import stats

from benchtwin.calibrate.procedure.effort import Effort
from benchtwin.calibrate.procedure.more_piles import add_piles
from benchtwin.calibrate.procedure.pile import PileFit, fit_pile
from benchtwin.calibrate.procedure.pile_stage import PileStage
from benchtwin.calibrate.procedure.pile_surrogate import (
    NOT_OBSERVABLES,
    angles_at,
    informative,
    observed,
    to_read,
    two_level_pattern,
)
from benchtwin.calibrate.procedure.rigs import PILE, SEED_LIMITS
from benchtwin.calibrate.procedure.simulator import usable
from benchtwin.calibrate.procedure.verification import verified
from benchtwin.calibrate.statistics.ascent import Centre, choose_centre, equal_steps
from benchtwin.calibrate.statistics.bench import BenchMean, pooled_mean
from benchtwin.calibrate.statistics.box import Box
from benchtwin.calibrate.statistics.designs import box_behnken, central_composite
from benchtwin.calibrate.statistics.replicates import (
    Noise,
    Pairing,
    Plan,
    common_packing,
    packing_noise,
    plan,
)

# groups of the path (the paper's) and the most it is lengthened to; beyond twice its
# length the factors stand at their limits
STEPS, MOST_STEPS = 6, 14
MOST_EFFECT = 5.0  # in packing noise: found by any design
MOST_CORRELATION = 0.95  # of runs on one packing that replicates are planned with
DESIGNS = {"box-behnken": box_behnken, "central-composite": central_composite}
# groups on either side of the centre that a design may span: all of the path where
# packing noise asks for it
WIDEST = 5
USABLE = 0.8  # share of a design's runs: with fewer it is another design
# first packing numbers of the design and of the verification: none that were seen
DESIGN_PACKINGS, VERIFICATION_PACKINGS = 100, 1000


@dataclass(frozen=True, kw_only=True, eq=False)
class Scatter:
    """How far piles scatter. noise: of one pile; pairing: what common packings save;
    middle: the two points it was measured at with their mean angles, the path's middle
    groups; piles: what was simulated; notes."""

    noise: Noise
    pairing: Pairing
    middle: pd.DataFrame
    piles: pd.DataFrame
    notes: list[str]

    def plan(self, box: Box, reach: float, effort: Effort) -> Plan:
        """Replicates so that a third of the path's change over the box, an even share
        of three factors, is found."""
        noise = self.noise
        coded = _design(box, effort)[[f"{n}_coded" for n in box.names]].to_numpy()
        # beyond MOST_EFFECT the power is not computed well
        effect = min(abs(reach) / len(box.names) or noise.sd, MOST_EFFECT * noise.sd)
        shared = min(self.pairing.correlation, MOST_CORRELATION)
        return plan(
            coded,
            effect,
            noise,
            wanted=effort.power,
            most=effort.most,
            correlation=shared if self.pairing.worth_it else 0.0,
        )


def simulate_pile(stage: PileStage, rng: np.random.Generator) -> PileFit:
    """Noise, path, design, further piles, fit, verification. ValueError,
    SimulationFailed."""
    box = stage.levels or Box.of(stage.ranges)
    scatter = measure_noise(stage, box)
    bench, shared = _bench(stage, scatter.noise), scatter.pairing.worth_it
    notes = [*scatter.notes, *too_scattered(stage.readings.values, scatter.noise)]
    path, reach = None, 0.0
    walked: list[pd.DataFrame] = []
    if stage.levels is None:
        path, steps, walked = climb(stage, bench, scatter)
        box, reach = box_around(path, steps, scatter, stage)
    elif stage.path is not None:
        path, walked = walk(stage, stage.path, bench, scatter.noise)
    ran = run_design(stage, box, scatter, reach)
    done = pd.concat([scatter.piles, *walked, ran.piles], ignore_index=True)
    done, more = add_piles(stage, box, done, shared=shared)
    packing, steel = "packing" if shared else None, stage.steel
    seen = observed(done, stage.readings, box, steel, alike=stage.alike, shared=shared)
    angles = angles_at(ran.design, seen, steel, stage.fixed)
    design = ran.design.assign(**{PILE.response: angles})
    fit = fit_pile(design, box, bench, rng=rng, near=stage.near, packing=packing)
    further = to_read(design, box, packing, stage.readings.values.size, seen)
    said = dict.fromkeys((*notes, *ran.notes, *more, *seen.notes))
    fit = replace(
        fit,
        notes=(*said, *fit.notes),
        path=path,
        noise=scatter.noise,
        pairing=scatter.pairing,
        plan=ran.plan,
        informative=informative(design, box, packing, seen),
        seen=seen,
        to_read=further,
    )
    points = pd.DataFrame([{**stage.fixed, **fit.optimum.point}] * stage.effort.piles)
    runs = stage.runs(points, VERIFICATION_PACKINGS + np.arange(len(points)))
    return verified(fit, PILE, runs, stage.simulate)


def _bench(stage: PileStage, noise: Noise) -> BenchMean:
    """The bench's mean angle; where its piles are simulated as they are, the packing
    noise helps to tell their scatter."""
    r = stage.readings
    return pooled_mean(
        r.values,
        name=f"pile: {r.response}",
        scatter_sd=noise.sd,
        df=float(noise.df),
        pooled=stage.alike,
        reading_sd=r.reading_sd,
        shared_sd=r.shared_sd,
    )


def measure_noise(stage: PileStage, box: Box) -> Scatter:
    """Packing noise at two points, on the same packings: how far one pile scatters, and
    what common packings save."""
    n = stage.effort.noise
    middle = equal_steps(box, STEPS).iloc[[STEPS // 2 - 1, STEPS // 2]]
    packings, point = np.tile(np.arange(n), 2), np.repeat(["a", "b"], n)
    table, piles = stage.piles(middle.loc[np.repeat(middle.index, n)], packings)
    there, notes = usable(table, PILE.response)
    runs = table.assign(point=point, packing=packings)[there]
    noise = packing_noise(runs, PILE.response, point="point")
    try:
        pairing = common_packing(runs, PILE.response, point="point", packing="packing")
    except ValueError:
        pairing = Pairing(0.0, -1.0, 1.0, 1.0, False)
    mean = runs.groupby("point")[PILE.response].mean().reindex(["a", "b"])
    middle = middle.assign(**{PILE.response: mean.to_numpy()}).dropna()
    if stage.readings.values.size == 1:
        notes.append(
            "one bench pile: its scatter is taken to be that of the simulated piles,"
            f" {noise.sd:.2g}°"
        )
    return Scatter(
        noise=noise, pairing=pairing, middle=middle, piles=piles, notes=notes
    )


def too_scattered(values: np.ndarray, noise: Noise, alpha: float = 0.001) -> list[str]:
    """A finding where the bench's piles scatter more than simulated ones of one packing
    after another can (F test)."""
    if values.size < 2:
        return []
    own = float(values.std(ddof=1))
    if stats.f.sf(own**2 / noise.sd**2, values.size - 1, noise.df) >= alpha:
        return []
    return [
        f"finding for diagnosis: the bench's piles scatter by {own:.2g}°, simulated"
        f" ones by {noise.sd:.2g}°: recordings contradict one another, or the bench has"
        " something that the simulation has not"
    ]


def climb(
    stage: PileStage, bench: BenchMean, scatter: Scatter
) -> tuple[Centre, pd.DataFrame, list[pd.DataFrame]]:
    """The path of steepest ascent, lengthened until it brackets the bench's angle or a
    factor comes to its limit: its centre, its groups, the piles run for it."""
    steps, middle = equal_steps(Box.of(stage.ranges), STEPS), scatter.middle
    more, done, piles = steps[~steps["group"].isin(middle["group"])], middle, []
    while True:
        walked, new = _walked(stage, more)
        piles.append(new)
        done = pd.concat([done, walked]).sort_values("group", ignore_index=True)
        centre = _centre(stage, done, bench, scatter.noise)
        angle, group = done[PILE.response], done["group"]
        inside = angle.min() <= bench.value <= angle.max()
        if len(done) >= MOST_STEPS or (
            inside and centre.group not in group.iloc[[0, -1]].tolist()
        ):
            break
        below = centre.group == group.iloc[0]
        more = _next_steps(done, tuple(stage.ranges), below=below)
        if more.empty:
            break
    return centre, done, piles


def walk(
    stage: PileStage, path: pd.DataFrame, bench: BenchMean, noise: Noise
) -> tuple[Centre, list[pd.DataFrame]]:
    """A prescribed path as it is, not lengthened: of its groups, simulated, the one
    nearest to the bench; and the piles run for it."""
    done, piles = _walked(stage, path)
    return _centre(stage, done, bench, noise), [piles]


def _centre(
    stage: PileStage, done: pd.DataFrame, bench: BenchMean, noise: Noise
) -> Centre:
    sd, factors = noise.sd / np.sqrt(stage.effort.path), tuple(stage.ranges)
    return choose_centre(done, PILE.response, bench.value, factors, noise_sd=sd)


def _walked(stage: PileStage, steps: pd.DataFrame) -> tuple[pd.DataFrame, pd.DataFrame]:
    """The steps with the mean of their piles, those that gave none left out; and the
    piles."""
    n = stage.effort.path
    points, packings = steps.loc[np.repeat(steps.index, n)], np.arange(n)
    table, piles = stage.piles(points, np.tile(packings, len(steps)))
    there, _ = usable(table, PILE.response)
    angle = table[PILE.response].where(there)
    group = np.repeat(np.arange(len(steps)), n)
    mean = angle.groupby(group).mean().to_numpy()
    return steps.assign(**{PILE.response: mean}).dropna(subset=PILE.response), piles


def _next_steps(
    done: pd.DataFrame, factors: tuple[str, ...], *, below: bool
) -> pd.DataFrame:
    """Two more groups at an end of the path, each factor kept within its limits; none
    where all stand there already."""
    ends = done.iloc[[0, 1]] if below else done.iloc[[-1, -2]]
    end, step = ends.iloc[0], ends.iloc[0][list(factors)] - ends.iloc[1][list(factors)]
    rows: list[dict[str, float]] = []
    for k in (1, 2):
        point = {
            f: float(f"{np.clip(end[f] + k * step[f], *SEED_LIMITS[f]):.9g}")
            for f in factors
        }
        if all(np.isclose(point[f], (rows[-1] if rows else end)[f]) for f in factors):
            break
        rows.append({"group": end["group"] + (-k if below else k), **point})
    return pd.DataFrame(rows, columns=["group", *factors])


def box_around(
    path: Centre, done: pd.DataFrame, scatter: Scatter, stage: PileStage
) -> tuple[Box, float]:
    """The design's box, and the angle's change over it: the path's neighbouring groups
    as −1 and +1, as the paper takes them, or groups farther off when packing noise
    would hide the main effects over so little."""
    groups, points = done["group"].to_numpy(), done[list(stage.ranges)].to_numpy(float)
    slope, last = np.polyfit(groups, done[PILE.response], 1)[0], len(groups) - 1
    at = int(np.clip(np.flatnonzero(groups == path.group)[0], 1, last - 1))
    for wide in range(1, WIDEST + 1):
        low, high = max(0, at - wide), min(last, at + wide)
        # a factor that stands at its limit in both
        while low > 0 and (points[low] >= points[high]).any():
            low -= 1
        box = Box(tuple(stage.ranges), points[low], points[high])
        reach = float(slope * (groups[high] - groups[low]))
        enough = scatter.plan(box, reach, stage.effort).reached
        if enough or (low, high) == (0, last):
            break
    return box, reach


def _design(box: Box, effort: Effort) -> pd.DataFrame:
    return DESIGNS[effort.design](box, centre_points=effort.centre)


def design_points(stage: PileStage, box: Box) -> pd.DataFrame:
    """The design once, with the seed–steel parameters that vary along."""
    return _with_steel(_design(box, stage.effort), box, stage.steel)


def _with_steel(design: pd.DataFrame, box: Box, steel: Box | None) -> pd.DataFrame:
    if steel is None:
        return design
    outside = design[[f"{n}_coded" for n in box.names]].to_numpy()
    natural = steel.natural(two_level_pattern(outside, len(steel.names)))
    rounded = np.vectorize(lambda v: float(f"{v:.9g}"))(natural)
    return design.assign(**dict(zip(steel.names, rounded.T)))


@dataclass(frozen=True, kw_only=True, eq=False)
class DesignRun:
    """A design's runs: design, a row a run, with what was read of it; plan: of its
    replicates; piles: what was simulated; notes."""

    design: pd.DataFrame
    plan: Plan
    piles: pd.DataFrame
    notes: list[str]


def run_design(
    stage: PileStage, box: Box, scatter: Scatter, reach: float = 0.0
) -> DesignRun:
    """The design's runs with their angles. reach: the angle's change over the box, 0
    where no path told it.

    Where common packings help, the points of a block share one, another one for every
    block and replicate: what a packing does cancels within a block and averages out
    between them. Else, and at the centre, every run has a packing of its own."""
    chosen = scatter.plan(box, reach or 4 * scatter.noise.sd, stage.effort)
    once = _design(box, stage.effort)
    outer, centre = (once[once["point"].eq("centre") == at] for at in (False, True))
    blocks = int(outer["block"].max()) + 1
    parts = [
        outer.assign(packing=outer["block"] + r * blocks, replicate=r + 1)
        for r in range(chosen.replicates)
    ]
    parts.append(centre.assign(packing=np.arange(len(centre)), replicate=1))
    design = pd.concat(parts, ignore_index=True)
    if not scatter.pairing.worth_it:
        design["packing"] = np.arange(len(design))
    design = _with_steel(design, box, stage.steel)
    table, piles = stage.piles(design, DESIGN_PACKINGS + design["packing"].to_numpy())
    there, notes = usable(table, PILE.response, least=USABLE)
    seen = [
        c
        for c in table.columns
        if c not in NOT_OBSERVABLES and table[c].dtype.kind == "f"
    ]
    read = table[list(dict.fromkeys([PILE.response, *seen]))]
    design = pd.concat([design.drop(columns="block"), read], axis=1)[there]
    return DesignRun(
        design=design.reset_index(drop=True), plan=chosen, piles=piles, notes=notes
    )
