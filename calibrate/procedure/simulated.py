"""The calibration on simulations of our own: rig after rig, each with what the earlier
ones found, then all together, and a check of the answer."""

from collections.abc import Callable, Iterable
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path

import numpy as np

from benchtwin.bench.exits import Misuse
from benchtwin.bench.language import tr
from benchtwin.bench.tells import BySurface
from benchtwin.calibrate.procedure.bench import bench_of
from benchtwin.calibrate.procedure.calibration import (
    Calibration,
)
from benchtwin.calibrate.procedure.check import check_seeds, check_steel
from benchtwin.calibrate.procedure.effort import FULL, Effort
from benchtwin.calibrate.procedure.next_tests import unrecorded_test
from benchtwin.calibrate.procedure.observed import steel_box
from benchtwin.calibrate.procedure.pile_stage import PileStage
from benchtwin.calibrate.procedure.rigs import (
    ASSUMED,
    BESIDE,
    PARAMETERS,
    PILE,
    RANGES,
    SEED_LIMITS,
    STEEL,
)
from benchtwin.calibrate.procedure.seed_runs import simulate_design, simulate_seeds
from benchtwin.calibrate.procedure.shape_effect import (
    pile_question,
    shape_effect,
    steel_question,
)
from benchtwin.calibrate.procedure.simulator import SimulationFailed, Simulator
from benchtwin.calibrate.procedure.steel import SteelStage, simulate_steel
from benchtwin.calibrate.procedure.surface import simulate_surface
from benchtwin.calibrate.statistics.bench import Verification
from benchtwin.calibrate.statistics.box import Box
from benchtwin.calibrate.statistics.next_test import BenchTest
from benchtwin.calibrate.statistics.prior import Prior
from benchtwin.twin.bench_folder import Observed
from benchtwin.twin.parameters import said_of

SEEDS = {PILE.name: PILE, **BESIDE}


@dataclass(frozen=True, kw_only=True)
class Prescribed:
    """What may be prescribed. ranges: of the seed–seed factors; priors: {parameter:
    (mean, sd)}; options: what was typed, for the record."""

    ranges: dict[str, tuple[float, float]] = field(default_factory=dict)
    priors: dict[str, tuple[float, float]] = field(default_factory=dict)
    options: dict = field(default_factory=dict)

    @classmethod
    def asked(cls, options: dict) -> "Prescribed":
        """Ranges and priors among the command's options; Misuse where they do not fit.
        Options that were not used are not recorded."""
        used = {name: value for name, value in options.items() if value}
        ranges, priors = (dict(used.get(name, {})) for name in ("ranges", "priors"))
        try:
            checked_ranges(ranges)
            Prior(Box.of(dict.fromkeys(PARAMETERS, (0.0, 1.0))), priors)
        except ValueError as error:
            raise Misuse(error) from None
        return cls(ranges=ranges, priors=priors, options=used)


@dataclass(frozen=True)
class Way:
    """How a calibration simulates: the same for all of its rigs."""

    simulate: Simulator
    effort: Effort
    prescribed: Prescribed


def calibrate_simulated(
    folder: Path | Observed,
    simulate: Simulator,
    *,
    effort: Effort = FULL,
    seed: int = 1,
    prescribed: Prescribed | None = None,
    say: Callable[[str], None] = lambda text: None,
    so_far: Callable[[Calibration], object] = lambda calibration: None,
) -> Calibration:
    """Calibrate a bench folder on simulations.

    say: told what begins; so_far: given the calibration after every rig. Raises
    FileNotFoundError, ValueError where nothing can be calibrated (a range with low ≥
    high included), and what the simulator raises."""
    way = Way(simulate, effort, prescribed or Prescribed())
    checked_ranges(way.prescribed.ranges)
    say(tr("measuring the bench's recordings"))
    bench = bench_of(folder)
    options = {**way.prescribed.options, "effort": asdict(effort)}
    found = Calibration.of("simulated", bench, seed, options).saying(*effort.notes())
    for name in (n for n in STEEL if n in bench.rigs):
        say(f"{name}: {STEEL[name].parameter}")
        found = steel_rig(found, name, way)
        if found.steel:
            so_far(_noted(found.joined(np.random.default_rng(seed))))
    for name in (n for n in SEEDS if n in bench.rigs):
        say(tr("{}: seed on seed", name))
        found = seed_rig(found, name, way)
    others: tuple[BenchTest, ...] = ()
    if effort.unrecorded and found.seeds:
        say(tr("what would other rigs tell?"))
        others = unrecorded(found, way)
    say(tr("all recordings together"))
    rng, priors = np.random.default_rng(seed), way.prescribed.priors
    found = found.joined(rng, priors=priors, ess=effort.draws, others=others)
    say(tr("the answer, simulated"))
    found = verified(found, way)
    if bench.seed.get("seed", {}).get("lot"):
        say(tr("does the seeds' shape matter?"))
        found = compare_shapes(found, way)
    return replace(_noted(found), finished=True)


def checked_ranges(
    asked: dict[str, tuple[float, float]],
) -> dict[str, tuple[float, float]]:
    """Ranges of the seed–seed factors; ValueError for an unknown one, low ≥ high, or
    what cannot be simulated."""
    for name, (low, high) in asked.items():
        if name not in RANGES:
            raise ValueError(
                tr("range of {}: no such factor; there are {}", name, ", ".join(RANGES))
            )
        least, most = SEED_LIMITS[name]
        if not (least <= low and high <= most):
            raise ValueError(
                tr(
                    "range of {}, {:g} to {:g}: must lie within {:g} to {:g}",
                    name,
                    low,
                    high,
                    least,
                    most,
                )
            )
    ranges = RANGES | asked
    Box.of(ranges)  # names the factor whose low is not below its high
    return ranges


def steel_stage(found: Calibration, name: str, way: Way) -> SteelStage:
    """What one rig's simulations need, with the parameters that those before it
    found."""
    readings, rigs = found.bench.rigs[name], list(STEEL)
    return SteelStage(
        rig=STEEL[name],
        readings=readings,
        fixed=steel_parameters(found, rigs[: rigs.index(name)]),
        description=_described(found, readings.description),
        simulate=way.simulate,
        effort=way.effort,
        seed=found.seed,
    )


def steel_rig(found: Calibration, name: str, way: Way) -> Calibration:
    """With what a seed–steel rig gives."""
    stage = steel_stage(found, name, way)
    return found.trying(name, lambda: found.with_steel(name, simulate_steel(stage)))


def seed_stage(found: Calibration, rig: BySurface, way: Way) -> PileStage:
    """What the simulations of a rig that tells of seed on seed need: as the bench
    describes it, else as the rig itself is."""
    readings = found.bench.rigs.get(rig.name)
    stated = readings.description if readings is not None else rig.keys
    section, notes = way.effort.simulated(rig, stated.get(rig.rig.name, {}))
    steel = found.on_steel
    limits = {rig.parameter: rig.limits for rig in STEEL.values()}
    box = next(
        (seen.box for seen in found.seeds.values()),
        Box.of(checked_ranges(way.prescribed.ranges)),
    )
    stage = PileStage(
        readings=readings,
        fixed=steel_parameters(found),
        description=_described(found, {**stated, rig.rig.name: section}),
        simulate=way.simulate,
        effort=way.effort,
        seed=found.seed,
        box=box,
        steel=steel_box(steel, limits),
        steel_found=steel,
        notes=notes,
        rig=rig,
    )
    # a bench that records one will state all that its page of docs asks for
    will_state = {} if readings is not None else rig.usual
    known = readings is not None or bool(will_state)
    return stage.varying(rig.left_open({**will_state, **section}) if known else {})


def seed_rig(found: Calibration, name: str, way: Way) -> Calibration:
    """With what a rig says of seed on seed; the piles by a publication's steps where
    these are asked for."""
    stage, known = seed_stage(found, SEEDS[name], way), tuple(found.seeds.values())
    found = found.saying(*stage.notes)

    def by_steps() -> Calibration:
        fit, seen = simulate_surface(stage)
        return replace(found, surface=fit).with_seeds(name, seen)

    if way.effort.surface and name == PILE.name:
        return found.trying(name, by_steps)
    return found.trying(
        name, lambda: found.with_seeds(name, simulate_seeds(stage, known))
    )


def unrecorded(found: Calibration, way: Way) -> tuple[BenchTest, ...]:
    """Rigs of which the bench has no recording, simulated over the same ranges."""
    tests = []
    for rig in (r for n, r in SEEDS.items() if n not in found.bench.rigs):
        stage = seed_stage(found, rig, way)
        try:
            runs = simulate_design(stage)
        except SimulationFailed:
            continue
        test = unrecorded_test(stage.rig, runs, stage.box, stage.steel)
        tests.append(test and replace(test, believed=stage.left_open))
    return tuple(test for test in tests if test is not None)


def verified(found: Calibration, way: Way) -> Calibration:
    """With the most probable set simulated beside the bench."""
    if way.effort.check < 2 or found.joint is None:
        return found
    at = found.joint.posterior.mode | found.most_probable
    checks: dict[str, Verification] = {}
    for name, fit in found.steel.items():
        alone = replace(steel_stage(found, name, way), fixed=_fixed(at, found))
        checks |= check_steel(alone, fit, at)
    for name, seen in found.seeds.items():
        stage = seed_stage(found, SEEDS[name], way)
        checks |= check_seeds(stage, seen, stage.middle | at)
    return replace(found, verified=checks)


def _fixed(at: dict[str, float], found: Calibration) -> dict[str, float]:
    """Seed–steel parameters at the answer."""
    assumed = steel_parameters(found)
    return {name: at.get(name, assumed[name]) for name in assumed}


def compare_shapes(found: Calibration, way: Way) -> Calibration:
    """What simpler seeds than the lot's would have given, where the rigs are simulated
    as they are."""
    at, effort = _fixed(found.most_probable, found), way.effort
    questions = [
        steel_question(
            fit,
            _described(found, found.bench.rigs[name].description),
            at,
            effort.check,
        )
        for name, fit in found.steel.items()
    ]
    if PILE.name in found.seeds:
        stage = seed_stage(found, PILE, way)
        values = {n: v for n, v in found.most_probable.items() if n in PARAMETERS}
        questions.append(pile_question(stage.description, at | values, effort.check))
    table = shape_effect(questions, way.simulate, found.seed)
    return found.adding(shape_effect=table)


def steel_parameters(
    found: Calibration, rigs: Iterable[str] = tuple(STEEL)
) -> dict[str, float]:
    """{parameter: value} of seed–steel rigs: as calibrated, else as assumed."""
    names = (STEEL[rig].parameter for rig in rigs)
    return {n: found.on_steel.get(n, (ASSUMED[n],))[0] for n in names}


def _described(found: Calibration, rig: dict) -> dict:
    """The lot's seed and air, with the rig's section."""
    lot = found.bench.seed
    seed = lot.get("seed", {}) | rig.get("seed", {})
    air = {"air": lot["air"]} if "air" in lot else {}
    return {**rig, **({"seed": seed} if seed else {}), **air}


def _noted(found: Calibration) -> Calibration:
    """With what was assumed: for rigs that gave nothing, and of the lot."""
    assumed = [
        tr(
            "{} = {:g} was assumed, because {} was not calibrated",
            rig.parameter,
            rig.assumed,
            name,
        )
        for name, rig in STEEL.items()
        if name in found.refused and (found.steel or found.seeds)
    ]
    return found.saying(*assumed, *said_of(found.bench.seed.get("seed", {})))
