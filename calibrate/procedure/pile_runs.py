"""Seed–seed piles simulated: noise, path, design with common packings, piles where they
tell most, verification."""

from dataclasses import dataclass, replace

import numpy as np
import pandas as pd
from benchtwin.calibrate.procedure.effort import Effort
from benchtwin.calibrate.procedure.more_piles import add_piles
from benchtwin.calibrate.procedure.pile import PileFit, fit_pile
from benchtwin.calibrate.procedure.pile_stage import PileStage
from benchtwin.calibrate.procedure.pile_surrogate import (
    NOT_OBSERVABLES,
    PileObservables,
    angles_at,
    candidates,
    informative,
    observed,
    two_level_pattern,
)
from benchtwin.calibrate.procedure.rigs import PILE_RESPONSE, SEED_LIMITS
from benchtwin.calibrate.procedure.simulator import usable
from benchtwin.calibrate.statistics.ascent import Centre, choose_centre, equal_steps
from benchtwin.calibrate.statistics.bench import BenchMean, pooled_mean, verify
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
from benchtwin.calibrate.statistics.resolution import Candidate
from scipy import stats

STEPS, MOST_STEPS = 6, 14
MOST_EFFECT = 5.0  # in packing noise
DESIGNS = {"box-behnken": box_behnken, "central-composite": central_composite}
# groups on either side of the centre that a design may span: all of the path where
# packing noise asks for it
WIDEST = 5


@dataclass(frozen=True, eq=False)
class PileResult:
    """fit: what the paper's way makes of the piles; seen: what stands for them in the
    posterior; candidates: what else they show."""

    fit: PileFit
    seen: PileObservables
    candidates: list[Candidate]


def simulate_pile(stage: PileStage, rng: np.random.Generator) -> PileResult:
    """The whole of it. ValueError, SimulationFailed."""
    box = stage.levels or Box.of(stage.ranges)
    noise, pairing, middle, notes = measure_noise(stage, box)
    bench = _bench(stage, noise)
    if stage.readings.values.size == 1:
        notes.append(
            "one bench pile: its scatter is taken to be that of the simulated piles,"
            f" {noise.sd:.2g}°"
        )
    notes += too_scattered(stage.readings.values, noise)
    path: Centre | None = None
    reach = 0.0
    if stage.levels is None:
        path, steps = climb(stage, bench, noise, middle)
        box, reach = box_around(path, steps, noise, stage, pairing)
    elif stage.path is not None:
        path = walk(stage, stage.path, bench, noise)
    design, chosen, more = run_design(stage, box, noise, pairing, reach)
    notes += more + add_piles(stage, box, shared=pairing.worth_it)
    packing = "packing" if pairing.worth_it else None
    piles = pd.concat(stage.done, ignore_index=True)
    seen = observed(
        piles,
        stage.readings,
        box,
        stage.steel,
        alike=stage.alike,
        shared=pairing.worth_it,
    )
    at = (
        {n: stage.fixed[n] for n in stage.steel.names}
        if stage.steel is not None
        else {}
    )
    design = design.assign(**{PILE_RESPONSE: angles_at(design, seen, stage.steel, at)})
    fit = fit_pile(design, box, bench, rng=rng, near=stage.near, packing=packing)
    fit = replace(
        fit,
        notes=(*dict.fromkeys((*notes, *seen.notes)), *fit.notes),
        path=path,
        noise=noise,
        pairing=pairing,
        plan=chosen,
        informative=informative(design, box, packing, seen),
    )
    further = candidates(design, box, packing, stage.readings.values.size, seen.used)
    return PileResult(_verified(stage, fit), seen, further)


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


def measure_noise(
    stage: PileStage, box: Box
) -> tuple[Noise, Pairing, pd.DataFrame, list[str]]:
    """Packing noise at two points, on the same packings: how far one pile scatters, and
    what common packings save; also the two points with their mean angles, which are the
    path's middle groups."""
    middle = equal_steps(box, STEPS).iloc[[STEPS // 2 - 1, STEPS // 2]]
    points = middle.loc[np.repeat(middle.index, stage.effort.noise)]
    packings = np.tile(np.arange(stage.effort.noise), 2)
    table = stage.piles(points, packings).assign(
        point=np.repeat(["a", "b"], stage.effort.noise), packing=packings
    )
    there, notes = usable(table, PILE_RESPONSE)
    noise = packing_noise(table[there], PILE_RESPONSE, point="point")
    try:
        pairing = common_packing(
            table[there], PILE_RESPONSE, point="point", packing="packing"
        )
    except ValueError:
        pairing = Pairing(0.0, -1.0, 1.0, 1.0, False)
    mean = table[there].groupby("point")[PILE_RESPONSE].mean()
    return (
        noise,
        pairing,
        middle.assign(**{PILE_RESPONSE: mean.reindex(["a", "b"]).to_numpy()}).dropna(),
        notes,
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
    stage: PileStage, bench: BenchMean, noise: Noise, seen: pd.DataFrame
) -> tuple[Centre, pd.DataFrame]:
    """The path of steepest ascent, lengthened until it brackets the bench's angle or a
    factor comes to its limit.

    seen: its groups whose angles are known already.
    """
    steps = equal_steps(Box.of(stage.ranges), STEPS)
    new = _walked(stage, steps[~steps["group"].isin(seen["group"])])
    done = pd.concat([seen, new]).sort_values("group", ignore_index=True)
    factors, sd = tuple(stage.ranges), noise.sd / np.sqrt(stage.effort.path)
    while len(done) < MOST_STEPS:
        centre = choose_centre(done, PILE_RESPONSE, bench.value, factors, noise_sd=sd)
        if (
            done[PILE_RESPONSE].min() <= bench.value <= done[PILE_RESPONSE].max()
            and centre.group not in done["group"].iloc[[0, -1]].tolist()
        ):
            break
        more = _next_steps(done, factors, below=centre.group == done["group"].iloc[0])
        if more.empty:
            break
        done = pd.concat([done, _walked(stage, more)]).sort_values(
            "group", ignore_index=True
        )
    return choose_centre(done, PILE_RESPONSE, bench.value, factors, noise_sd=sd), done


def walk(
    stage: PileStage, path: pd.DataFrame, bench: BenchMean, noise: Noise
) -> Centre:
    """A prescribed path as it is, not lengthened: its groups simulated, the one nearest
    to the bench."""
    done, sd = _walked(stage, path), noise.sd / np.sqrt(stage.effort.path)
    return choose_centre(
        done, PILE_RESPONSE, bench.value, tuple(stage.ranges), noise_sd=sd
    )


def _walked(stage: PileStage, steps: pd.DataFrame) -> pd.DataFrame:
    """The steps with the mean of their piles; those that gave none are left out."""
    n = stage.effort.path
    table = stage.piles(
        steps.loc[np.repeat(steps.index, n)], np.tile(np.arange(n), len(steps))
    )
    there, _ = usable(table, PILE_RESPONSE)
    mean = (
        table[PILE_RESPONSE]
        .where(there)
        .groupby(np.repeat(np.arange(len(steps)), n))
        .mean()
    )
    return steps.assign(**{PILE_RESPONSE: mean.to_numpy()}).dropna(subset=PILE_RESPONSE)


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
    path: Centre, done: pd.DataFrame, noise: Noise, stage: PileStage, pairing: Pairing
) -> tuple[Box, float]:
    """The design's box, and the angle's change over it: the path's neighbouring groups
    as −1 and +1, as the paper takes them, or groups farther off when packing noise
    would hide the main effects over so little."""
    factors, groups = list(stage.ranges), done["group"].to_numpy()
    slope = np.polyfit(groups, done[PILE_RESPONSE], 1)[0]
    at = int(np.clip(np.flatnonzero(groups == path.group)[0], 1, len(groups) - 2))
    for wide in range(1, WIDEST + 1):
        low, high = max(0, at - wide), min(len(groups) - 1, at + wide)
        while (
            low > 0 and (done.iloc[low][factors] >= done.iloc[high][factors]).any()
        ):  # a factor that stands at its limit in both
            low -= 1
        ends = done.iloc[[low, high]]
        box = Box(
            tuple(factors),
            ends.iloc[0][factors].to_numpy(float),
            ends.iloc[1][factors].to_numpy(float),
        )
        reach = float(slope * (groups[high] - groups[low]))
        if _plan(box, reach, noise, pairing, stage.effort).reached or (
            low == 0 and high == len(groups) - 1
        ):
            break
    return box, reach


def _plan(
    box: Box, reach: float, noise: Noise, pairing: Pairing, effort: Effort
) -> Plan:
    """Replicates so that a third of the path's change over the box, an even share of
    three factors, is found."""
    coded = _design(box, effort)[[f"{n}_coded" for n in box.names]].to_numpy()
    # an effect of many times the noise is found by any design, and beyond that the
    # power is not computed well
    effect = min(abs(reach) / len(box.names) or noise.sd, MOST_EFFECT * noise.sd)
    correlation = min(pairing.correlation, 0.95) if pairing.worth_it else 0.0
    return plan(
        coded,
        effect,
        noise,
        wanted=effort.power,
        most=effort.most,
        correlation=correlation,
    )


def _design(box: Box, effort: Effort) -> pd.DataFrame:
    return DESIGNS[effort.design](box, centre_points=effort.centre)


def run_design(
    stage: PileStage, box: Box, noise: Noise, pairing: Pairing, reach: float
) -> tuple[pd.DataFrame, Plan, list[str]]:
    """The design's runs with their angles.

    Where common packings help, the points of a block share one, another one for every
    block and replicate: what a packing does cancels within a block and averages out
    between them. Else, and at the centre, every run has a packing of its own."""
    chosen = _plan(box, reach or 4 * noise.sd, noise, pairing, stage.effort)
    once = _design(box, stage.effort)
    outer = once[once["point"] != "centre"]
    blocks = int(outer["block"].max()) + 1
    parts = [
        outer.assign(packing=outer["block"] + r * blocks, replicate=r + 1)
        for r in range(chosen.replicates)
    ]
    centre = once[once["point"] == "centre"]
    design = pd.concat(
        [*parts, centre.assign(packing=np.arange(len(centre)), replicate=1)],
        ignore_index=True,
    )
    if not pairing.worth_it:
        design["packing"] = np.arange(len(design))
    if stage.steel is not None:
        coded = two_level_pattern(
            design[[f"{n}_coded" for n in box.names]].to_numpy(), len(stage.steel.names)
        )
        design[list(stage.steel.names)] = np.vectorize(lambda v: float(f"{v:.9g}"))(
            stage.steel.natural(coded)
        )
    table = stage.piles(
        design, 100 + design["packing"]
    )  # packings of their own: the noise's have been seen
    there, notes = usable(table, PILE_RESPONSE, least=0.8)
    extra = [
        c
        for c in table.columns
        if c not in NOT_OBSERVABLES and table[c].dtype.kind == "f"
    ]
    read = table[list(dict.fromkeys([PILE_RESPONSE, *extra]))]
    design = pd.concat([design.drop(columns="block"), read], axis=1)[there]
    return design.reset_index(drop=True), chosen, notes


def _verified(stage: PileStage, fit: PileFit) -> PileFit:
    """Piles at the optimum, on new packings, beside the bench."""
    n = stage.effort.piles
    if n < 2:
        return fit
    point = {**stage.fixed, **fit.optimum.point}
    table = stage.piles(pd.DataFrame([point] * n), 1000 + np.arange(n), keep=False)
    there, notes = usable(table, PILE_RESPONSE)
    if there.sum() < 2:
        return replace(fit, notes=(*fit.notes, *notes))
    found = verify(
        table.loc[there, PILE_RESPONSE].to_numpy(float), fit.bench, name="pile"
    )
    if not found.agrees:
        notes.append(
            f"verification disagrees: {found.simulated:.4g}° simulated,"
            f" {found.bench:.4g}° at the bench (p = {found.p:.2g})"
        )
    return replace(fit, verification=found, notes=(*fit.notes, *notes))
