"""The procedure with simulations of our own: rig after rig, each with what the earlier ones found, then the pile."""

from collections.abc import Callable
from dataclasses import asdict, dataclass, field
from pathlib import Path

import numpy as np
import pandas as pd

from calibrate.procedure.bench import Bench, bench_of, contradictory, missing, trimmed_before
from calibrate.procedure.calibration import FOLLOWS, Calibration
from calibrate.procedure.effort import FULL, Effort, pile_description
from calibrate.procedure.joint import Joint, fit_joint
from calibrate.procedure.pile_runs import PileFound, simulate_pile
from calibrate.procedure.pile_stage import RANGES, PileStage
from calibrate.procedure.pile_surrogate import steel_box
from calibrate.procedure.rigs import SEED_LIMITS, STEEL
from calibrate.procedure.shape_effect import pile_question, shape_effect, steel_question
from calibrate.procedure.simulator import SimulationFailed, Simulator
from calibrate.procedure.steel import SteelFit
from calibrate.procedure.steel_runs import SteelStage, Unreachable, simulate_steel
from calibrate.statistics.box import Box
from twin.parameters import said_of

NOT_FOUND = {"restitution": 0.54, "static_friction": 0.34, "rolling_friction": 0.01}  # the paper's, for a rig that says nothing


@dataclass(frozen=True)
class Wishes:
    """What may be prescribed. ranges: of the seed–seed factors; held: {parameter: (mean, sd)} known beforehand; values: where a
    seed–steel rig is simulated, by rig; path, levels: the pile's path (group and the factors) and its design's box; steel:
    where the seed–steel parameters ride along in it; near: the seed–seed point to report; trimmed: how many highest and
    lowest readings a rig's were left of; options: how it was asked for, for the record."""

    ranges: dict[str, tuple[float, float]] = field(default_factory=dict)
    held: dict[str, tuple[float, float]] = field(default_factory=dict)
    values: dict[str, tuple[float, ...]] = field(default_factory=dict)
    path: pd.DataFrame | None = None
    levels: Box | None = None
    steel: Box | None = None
    near: dict[str, float] | None = None
    trimmed: dict[str, int] = field(default_factory=dict)
    options: dict = field(default_factory=dict)


def calibrate_simulated(
    folder: Path,
    simulate: Simulator,
    *,
    effort: Effort = FULL,
    seed: int = 1,
    wishes: Wishes | None = None,
    say: Callable[[str], None] = lambda text: None,
    so_far: Callable[[Calibration], None] = lambda calibration: None,
) -> Calibration:
    """Calibrate a bench folder on simulations.

    say: told what begins; so_far: given the calibration after every rig. Raises FileNotFoundError, ValueError where nothing can
    be calibrated (a range with low ≥ high included), and what the simulator raises.
    """
    wishes = wishes or Wishes()
    ranges = checked_ranges(wishes.ranges)
    say("measuring the bench's recordings")
    bench = trimmed_before(bench_of(folder), wishes.trimmed)
    rng = np.random.default_rng(seed)
    state = State(bench, effort, seed, wishes, missing(bench))
    for name in STEEL:
        if name in bench.rigs:
            say(f"{name}: {STEEL[name].parameter}")
            state.steel_rig(name, simulate, rng)
            so_far(state.calibration(rng, finished=False))
    if "pile" in bench.rigs:
        say("pile: seed on seed")
        state.pile_rig(simulate, ranges, rng)
    if not state.steel and state.pile is None:
        raise ValueError(f"{folder}: nothing could be calibrated: " + "; ".join(f"{k}: {v}" for k, v in state.refused.items()))
    if bench.seed.get("seed", {}).get("lot"):
        say("does the seeds' shape matter?")
        state.shapes(simulate)
    say("all recordings together")
    return state.calibration(rng, finished=True)


def checked_ranges(asked: dict[str, tuple[float, float]]) -> dict[str, tuple[float, float]]:
    """Ranges of the seed–seed factors; ValueError for an unknown one, low ≥ high, or what cannot be simulated."""
    for name, (low, high) in asked.items():
        if name not in RANGES:
            raise ValueError(f"--range {name}: no such factor; there are {', '.join(RANGES)}")
        least, most = SEED_LIMITS[name]
        if not (least <= low and high <= most):
            raise ValueError(f"--range {name}={low:g}:{high:g}: must lie within {least:g} to {most:g}")
    ranges = RANGES | asked
    Box.of(ranges)  # names the factor whose low is not below its high
    return ranges


class State:
    """What is known so far."""

    def __init__(self, bench: Bench, effort: Effort, seed: int, wishes: Wishes, refused: dict[str, str]) -> None:
        self.bench, self.effort, self.seed, self.wishes = bench, effort, seed, wishes
        self.steel: dict[str, SteelFit] = {}
        self.pile: PileFound | None = None
        self.refused, self.findings, self.said = refused, contradictory(bench), list(effort.said())
        self.shape: pd.DataFrame | None = None

    def steel_rig(self, name: str, simulate: Simulator, rng: np.random.Generator) -> None:
        """One rig, with the parameters that those before it found."""
        readings = self.bench.rigs[name]
        before = list(STEEL)[: list(STEEL).index(name)]
        fixed = {STEEL[n].parameter: self._found(n) for n in before}
        stage = SteelStage(
            STEEL[name],
            readings,
            fixed,
            self._description(readings.description),
            simulate,
            self.effort,
            self.seed,
            self.wishes.values.get(name),
        )
        try:
            self.steel[name] = simulate_steel(stage, rng)
        except Unreachable as error:
            self.refused[name] = str(error)
            self.findings.append(str(error))
        except (ValueError, SimulationFailed) as error:
            self.refused[name] = str(error)

    def pile_stage(self, simulate: Simulator, ranges: dict) -> PileStage:
        """What the pile's simulations need: all seed–steel parameters, and where they ride along."""
        readings = self.bench.rigs["pile"]
        section, said = pile_description(readings.description.get("pile", {}), self.effort)
        self.said += said
        description = self._description({**readings.description, "pile": section})
        fixed = {STEEL[n].parameter: self._found(n) for n in STEEL}
        own = {f.rig.parameter: (f.inverse.value, f.inverse.sd) for f in self.steel.values()}
        steel = self.wishes.steel or steel_box(own, {rig.parameter: rig.limits for rig in STEEL.values()})
        return PileStage(readings, fixed, description, simulate, self.effort, self.seed, ranges, self.wishes.levels,
                         self.wishes.near, steel, own, alike=not said, path=self.wishes.path)  # fmt: skip

    def pile_rig(self, simulate: Simulator, ranges: dict, rng: np.random.Generator) -> None:
        """The pile."""
        try:
            self.pile = simulate_pile(self.pile_stage(simulate, ranges), rng)
        except (ValueError, SimulationFailed) as error:
            self.refused["pile"] = str(error)

    def shapes(self, simulate: Simulator) -> None:
        """What simpler seeds than the lot's would have given, where the rigs are simulated as they are."""
        fixed = {STEEL[n].parameter: self._found(n) for n in STEEL}
        runs = self.effort.verify
        asked = [
            steel_question(fit, self._description(self.bench.rigs[name].description), fixed, runs) for name, fit in self.steel.items()
        ]
        if self.pile is not None:
            section, _ = pile_description(self.bench.rigs["pile"].description.get("pile", {}), self.effort)
            description = self._description({**self.bench.rigs["pile"].description, "pile": section})
            asked.append(pile_question(description, fixed | self.pile.fit.optimum.point, self.effort.piles))
        self.shape = shape_effect(asked, simulate, self.seed)

    def _found(self, rig: str) -> float:
        name = STEEL[rig].parameter
        return self.steel[rig].inverse.value if rig in self.steel else NOT_FOUND[name]

    def _description(self, own: dict) -> dict:
        """The lot's seed and air, with the rig's own section."""
        seed = self.bench.seed.get("seed", {}) | own.get("seed", {})
        air = {"air": self.bench.seed["air"]} if "air" in self.bench.seed else {}
        return {**own, **({"seed": seed} if seed else {}), **air}

    def _joint(self, rng: np.random.Generator) -> Joint | None:
        held, draws = self.wishes.held, self.effort.draws
        if self.pile is None:
            return fit_joint(self.steel, None, rng=rng, given=held, ess=draws)
        found = self.pile
        return fit_joint(self.steel, found.fit, rng=rng, given=held, ess=draws, seen=found.seen, candidates=found.candidates)

    def calibration(self, rng: np.random.Generator, *, finished: bool) -> Calibration:
        """What is known, joined."""
        pile = self.pile.fit if self.pile else None
        joint = self._joint(rng) if finished else None
        findings = [*self.findings, *(n for n in (pile.notes if pile else ()) if n.startswith("finding"))]
        assumed = [
            f"{STEEL[n].parameter} = {NOT_FOUND[STEEL[n].parameter]:g} was assumed, because {n} was not calibrated"
            for n in STEEL
            if n in self.refused and (self.steel or self.pile)
        ]
        said = [*self.said, *assumed, *said_of(self.bench.seed.get("seed", {}))]
        options = {**self.wishes.options, "effort": asdict(self.effort), "said": said}
        return Calibration(
            "simulated",
            self.bench,
            dict(self.steel),
            pile,
            joint,
            dict(self.refused),
            pd.DataFrame(columns=FOLLOWS),
            (),
            tuple(findings),
            options,
            self.seed,
            finished=finished,
            more={} if self.shape is None else {"shape_effect": self.shape},
        )
