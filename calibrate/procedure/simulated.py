"""The procedure with simulations of our own: rig after rig, each with what the earlier
ones found, then the pile."""

from collections.abc import Callable, Iterable
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path

import numpy as np
import pandas as pd

from benchtwin.calibrate.procedure.bench import bench_of
from benchtwin.calibrate.procedure.beside_piles import (
    LEAST_RUNS,
    simulate_beside,
    simulate_design,
)
from benchtwin.calibrate.procedure.calibration import Calibration
from benchtwin.calibrate.procedure.effort import FULL, Effort
from benchtwin.calibrate.procedure.next_tests import unrecorded_test
from benchtwin.calibrate.procedure.pile_runs import simulate_pile
from benchtwin.calibrate.procedure.pile_stage import PileStage
from benchtwin.calibrate.procedure.pile_surrogate import steel_box
from benchtwin.calibrate.procedure.rigs import (
    ASSUMED,
    BESIDE,
    PILE,
    RANGES,
    SEED_LIMITS,
    STEEL,
)
from benchtwin.calibrate.procedure.shape_effect import (
    pile_question,
    shape_effect,
    steel_question,
)
from benchtwin.calibrate.procedure.simulator import Simulator
from benchtwin.calibrate.procedure.steel_runs import SteelStage, simulate_steel
from benchtwin.calibrate.statistics.box import Box
from benchtwin.calibrate.statistics.next_test import BenchTest
from benchtwin.twin.bench_folder import Observed
from benchtwin.twin.parameters import said_of


@dataclass(frozen=True, kw_only=True)
class Prescribed:
    """What may be prescribed. ranges: of the seed–seed factors; priors: {parameter:
    (mean, sd)}; values: where a seed–steel rig is simulated, by rig; path, levels: the
    pile's path (group and the factors) and its design's box; steel: where the
    seed–steel parameters vary along in it; near: the seed–seed point to report;
    trimmed: how many highest and lowest readings of each rig were left out before;
    options: what was typed, for the record."""

    ranges: dict[str, tuple[float, float]] = field(default_factory=dict)
    priors: dict[str, tuple[float, float]] = field(default_factory=dict)
    values: dict[str, tuple[float, ...]] = field(default_factory=dict)
    path: pd.DataFrame | None = None
    levels: Box | None = None
    steel: Box | None = None
    near: dict[str, float] | None = None
    trimmed: dict[str, int] = field(default_factory=dict)
    options: dict = field(default_factory=dict)


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
    so_far: Callable[[Calibration], None] = lambda calibration: None,
) -> Calibration:
    """Calibrate a bench folder on simulations.

    say: told what begins; so_far: given the calibration after every rig. Raises
    FileNotFoundError, ValueError where nothing can be calibrated (a range with low ≥
    high included), and what the simulator raises."""
    way = Way(simulate, effort, prescribed or Prescribed())
    checked_ranges(way.prescribed.ranges)
    say("measuring the bench's recordings")
    bench = bench_of(folder, way.prescribed.trimmed)
    options = {**way.prescribed.options, "effort": asdict(effort)}
    found = Calibration.of("simulated", bench, seed, options).saying(*effort.notes())
    rng = np.random.default_rng(seed)
    for name in (n for n in STEEL if n in bench.rigs):
        say(f"{name}: {STEEL[name].parameter}")
        found = steel_rig(found, name, way, rng)
        so_far(_noted(found))
    if PILE.name in bench.rigs:
        say(f"{PILE.name}: seed on seed")
        found = pile_rig(found, way, rng)
    for name in (n for n in BESIDE if n in bench.rigs):
        say(f"{name}: seed on seed")
        found = rig_beside(found, name, way)
    others: tuple[BenchTest, ...] = ()
    if effort.unrecorded and found.pile is not None:
        say("what would other rigs tell?")
        others = unrecorded(found, way)
    if bench.seed.get("seed", {}).get("lot") and (found.steel or found.pile):
        say("does the seeds' shape matter?")
        found = compare_shapes(found, way)
    say("all recordings together")
    draws, priors = effort.draws, way.prescribed.priors
    return _noted(found.joined(rng, priors=priors, ess=draws, others=others))


def checked_ranges(
    asked: dict[str, tuple[float, float]],
) -> dict[str, tuple[float, float]]:
    """Ranges of the seed–seed factors; ValueError for an unknown one, low ≥ high, or
    what cannot be simulated."""
    for name, (low, high) in asked.items():
        if name not in RANGES:
            raise ValueError(
                f"range of {name}: no such factor; there are {', '.join(RANGES)}"
            )
        least, most = SEED_LIMITS[name]
        if not (least <= low and high <= most):
            raise ValueError(
                f"range of {name}, {low:g} to {high:g}: must lie within {least:g} to"
                f" {most:g}"
            )
    ranges = RANGES | asked
    Box.of(ranges)  # names the factor whose low is not below its high
    return ranges


def steel_rig(
    found: Calibration, name: str, way: Way, rng: np.random.Generator
) -> Calibration:
    """One rig, simulated with the parameters that those before it found."""
    readings, rigs = found.bench.rigs[name], list(STEEL)
    stage = SteelStage(
        rig=STEEL[name],
        readings=readings,
        fixed=steel_parameters(found, rigs[: rigs.index(name)]),
        description=_described(found, readings.description),
        simulate=way.simulate,
        effort=way.effort,
        seed=found.seed,
        values=way.prescribed.values.get(name),
    )
    return found.trying(name, lambda: simulate_steel(stage, rng))


def pile_stage(found: Calibration, way: Way) -> PileStage:
    """What the pile's simulations need: all seed–steel parameters, and their ranges."""
    description, notes = _pile_described(found, way.effort)
    steel, prescribed = found.on_steel, way.prescribed
    limits = {rig.parameter: rig.limits for rig in STEEL.values()}
    return PileStage(
        readings=found.bench.rigs[PILE.name],
        fixed=steel_parameters(found),
        description=description,
        simulate=way.simulate,
        effort=way.effort,
        seed=found.seed,
        ranges=checked_ranges(prescribed.ranges),
        levels=prescribed.levels,
        near=prescribed.near,
        steel=prescribed.steel or steel_box(steel, limits),
        steel_found=steel,
        path=prescribed.path,
        notes=notes,
    )


def pile_rig(found: Calibration, way: Way, rng: np.random.Generator) -> Calibration:
    """The pile, simulated with what the seed–steel rigs found."""
    stage = pile_stage(found, way)
    found = found.saying(*stage.notes)
    return found.trying(PILE.name, lambda: simulate_pile(stage, rng))


def rig_beside(found: Calibration, name: str, way: Way) -> Calibration:
    """A further rig that tells of seed on seed, simulated over the piles' design."""
    if found.pile is None:
        why = "its runs are laid over the heaps' design, and no heap was calibrated"
        return found.without(name, ValueError(why))
    pile, readings = found.pile, found.bench.rigs[name]
    stage = replace(_stage_beside(found, name, way), readings=readings)
    before = (pile.seen,) if pile.seen is not None else ()
    known = (*before, *found.beside.values())
    return found.trying(name, lambda: simulate_beside(stage, pile.box, known))


def unrecorded(found: Calibration, way: Way) -> tuple[BenchTest, ...]:
    """Rigs of which the bench has no recording, simulated over the piles' design."""
    if found.pile is None:
        return ()
    tests, box = [], found.pile.box
    for name in (n for n in BESIDE if n not in found.bench.rigs):
        stage = _stage_beside(found, name, way)
        _, runs = simulate_design(stage, box)
        if len(runs) >= LEAST_RUNS:
            tests.append(unrecorded_test(stage.rig, runs, box, stage.steel))
    return tuple(test for test in tests if test is not None)


def _stage_beside(found: Calibration, name: str, way: Way) -> PileStage:
    """The piles' stage for another rig, as the bench describes it, else as the rig
    itself is."""
    rig, readings = BESIDE[name], found.bench.rigs.get(name)
    stated = readings.description if readings is not None else rig.keys
    section, notes = way.effort.simulated(rig, stated.get(rig.rig.name, {}))
    described = _described(found, {**stated, rig.rig.name: section})
    stage = replace(pile_stage(found, way), rig=rig, description=described, notes=notes)
    # a bench that records one will state all that its page of docs asks for
    return stage.varying(rig.left_open(section) if readings is not None else {})


def compare_shapes(found: Calibration, way: Way) -> Calibration:
    """What simpler seeds than the lot's would have given, where the rigs are simulated
    as they are."""
    fixed, effort = steel_parameters(found), way.effort
    questions = [
        steel_question(
            fit,
            _described(found, found.bench.rigs[name].description),
            fixed,
            effort.verify,
        )
        for name, fit in found.steel.items()
    ]
    if found.pile is not None:
        described, _ = _pile_described(found, effort)
        values = fixed | found.pile.optimum.point
        questions.append(pile_question(described, values, effort.piles))
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


def _pile_described(found: Calibration, effort: Effort) -> tuple[dict, tuple[str, ...]]:
    """Sections of the pile that is simulated, and notes where it is not the bench's
    own."""
    stated = found.bench.rigs[PILE.name].description
    section, notes = effort.simulated(PILE, stated.get(PILE.name, {}))
    return _described(found, {**stated, PILE.name: section}), notes


def _noted(found: Calibration) -> Calibration:
    """With what was assumed: for rigs that gave nothing, and of the lot."""
    assumed = [
        f"{rig.parameter} = {rig.assumed:g} was assumed, because {name} was not"
        " calibrated"
        for name, rig in STEEL.items()
        if name in found.refused and (found.steel or found.pile)
    ]
    return found.saying(*assumed, *said_of(found.bench.seed.get("seed", {})))
