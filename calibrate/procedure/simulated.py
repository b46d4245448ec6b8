"""The procedure with simulations of our own: rig after rig, each with what the earlier
ones found, then the pile."""

from collections.abc import Callable, Iterable
from dataclasses import asdict, dataclass, field
from pathlib import Path

import numpy as np
import pandas as pd
from benchtwin.calibrate.procedure.bench import (
    Bench,
    bench_of,
    contradictory,
    missing,
    trimmed_before,
)
from benchtwin.calibrate.procedure.calibration import Calibration, nothing_calibrated
from benchtwin.calibrate.procedure.effort import FULL, Effort, pile_description
from benchtwin.calibrate.procedure.joint import Joint, fit_joint
from benchtwin.calibrate.procedure.pile_runs import PileResult, simulate_pile
from benchtwin.calibrate.procedure.pile_stage import RANGES, PileStage
from benchtwin.calibrate.procedure.pile_surrogate import steel_box
from benchtwin.calibrate.procedure.rigs import SEED_LIMITS, STEEL
from benchtwin.calibrate.procedure.shape_effect import (
    pile_question,
    shape_effect,
    steel_question,
)
from benchtwin.calibrate.procedure.simulator import SimulationFailed, Simulator
from benchtwin.calibrate.procedure.steel import SteelFit
from benchtwin.calibrate.procedure.steel_runs import (
    SteelStage,
    Unreachable,
    simulate_steel,
)
from benchtwin.calibrate.statistics.box import Box
from benchtwin.twin.bench_folder import Observed
from benchtwin.twin.parameters import said_of

# the paper's, of a rig that gives none
ASSUMED = {"restitution": 0.54, "static_friction": 0.34, "rolling_friction": 0.01}


@dataclass(frozen=True)
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
    prescribed = prescribed or Prescribed()
    ranges = checked_ranges(prescribed.ranges)
    say("measuring the bench's recordings")
    bench = trimmed_before(bench_of(folder), prescribed.trimmed)
    rng = np.random.default_rng(seed)
    state = State(bench, effort, seed, prescribed, missing(bench))
    for name in STEEL:
        if name in bench.rigs:
            say(f"{name}: {STEEL[name].parameter}")
            state.steel_rig(name, simulate, rng)
            so_far(state.calibration(rng, finished=False))
    if "pile" in bench.rigs:
        say("pile: seed on seed")
        state.pile_rig(simulate, ranges, rng)
    if not state.steel and state.pile is None:
        raise nothing_calibrated(folder, state.refused)
    if bench.seed.get("seed", {}).get("lot"):
        say("does the seeds' shape matter?")
        state.compare_shapes(simulate)
    say("all recordings together")
    return state.calibration(rng, finished=True)


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


class State:
    """What is known so far."""

    def __init__(
        self,
        bench: Bench,
        effort: Effort,
        seed: int,
        prescribed: Prescribed,
        refused: dict[str, str],
    ) -> None:
        self.bench, self.effort, self.seed, self.prescribed = (
            bench,
            effort,
            seed,
            prescribed,
        )
        self.steel: dict[str, SteelFit] = {}
        self.pile: PileResult | None = None
        self.refused, self.findings = refused, contradictory(bench)
        self.notes = list(effort.notes())
        self.shape: pd.DataFrame | None = None

    def steel_rig(
        self, name: str, simulate: Simulator, rng: np.random.Generator
    ) -> None:
        """One rig, with the parameters that those before it found."""
        readings = self.bench.rigs[name]
        before = list(STEEL)[: list(STEEL).index(name)]
        stage = SteelStage(
            STEEL[name],
            readings,
            self._steel_parameters(before),
            self._description(readings.description),
            simulate,
            self.effort,
            self.seed,
            self.prescribed.values.get(name),
        )
        try:
            self.steel[name] = simulate_steel(stage, rng)
        except (ValueError, SimulationFailed) as error:
            self.refused[name] = str(error)
            if isinstance(error, Unreachable):
                self.findings.append(str(error))

    def pile_stage(self, simulate: Simulator, ranges: dict) -> PileStage:
        """What the pile's simulations need: all seed–steel parameters, and their
        ranges."""
        description, notes = self._pile_description()
        self.notes += notes
        found = {
            f.rig.parameter: (f.inverse.value, f.inverse.sd)
            for f in self.steel.values()
        }
        limits = {rig.parameter: rig.limits for rig in STEEL.values()}
        p = self.prescribed
        return PileStage(
            self.bench.rigs["pile"],
            self._steel_parameters(STEEL),
            description,
            simulate,
            self.effort,
            self.seed,
            ranges,
            p.levels,
            p.near,
            p.steel or steel_box(found, limits),
            found,
            alike=not notes,
            path=p.path,
        )

    def pile_rig(
        self, simulate: Simulator, ranges: dict, rng: np.random.Generator
    ) -> None:
        """The pile."""
        try:
            self.pile = simulate_pile(self.pile_stage(simulate, ranges), rng)
        except (ValueError, SimulationFailed) as error:
            self.refused["pile"] = str(error)

    def compare_shapes(self, simulate: Simulator) -> None:
        """What simpler seeds than the lot's would have given, where the rigs are
        simulated as they are."""
        fixed = self._steel_parameters(STEEL)
        stated = {
            name: self._description(rig.description)
            for name, rig in self.bench.rigs.items()
        }
        questions = [
            steel_question(fit, stated[name], fixed, self.effort.verify)
            for name, fit in self.steel.items()
        ]
        if self.pile is not None:
            values = fixed | self.pile.fit.optimum.point
            questions.append(
                pile_question(self._pile_description()[0], values, self.effort.piles)
            )
        self.shape = shape_effect(questions, simulate, self.seed)

    def _steel_parameters(self, rigs: Iterable[str]) -> dict[str, float]:
        """{parameter: value} of seed–steel rigs: as calibrated, else as assumed."""
        found = {f.rig.parameter: f.inverse.value for f in self.steel.values()}
        return {
            n: found.get(n, ASSUMED[n]) for n in (STEEL[rig].parameter for rig in rigs)
        }

    def _description(self, rig: dict) -> dict:
        """The lot's seed and air, with the rig's section."""
        seed = self.bench.seed.get("seed", {}) | rig.get("seed", {})
        air = {"air": self.bench.seed["air"]} if "air" in self.bench.seed else {}
        return {**rig, **({"seed": seed} if seed else {}), **air}

    def _pile_description(self) -> tuple[dict, tuple[str, ...]]:
        """Sections of the pile that is simulated, and notes where it is not the bench's
        own."""
        stated = self.bench.rigs["pile"].description
        section, notes = pile_description(stated.get("pile", {}), self.effort)
        return self._description({**stated, "pile": section}), notes

    def _joint(self, rng: np.random.Generator) -> Joint | None:
        priors, draws = self.prescribed.priors, self.effort.draws
        if self.pile is None:
            return fit_joint(self.steel, None, rng=rng, priors=priors, ess=draws)
        fit, seen, candidates = self.pile.fit, self.pile.seen, self.pile.candidates
        return fit_joint(
            self.steel,
            fit,
            rng=rng,
            priors=priors,
            ess=draws,
            seen=seen,
            candidates=candidates,
        )

    def calibration(self, rng: np.random.Generator, *, finished: bool) -> Calibration:
        """What is known, joined."""
        pile = self.pile.fit if self.pile else None
        used = {rig.parameter: n for n, rig in STEEL.items() if n in self.refused}
        assumed = [
            f"{parameter} = {ASSUMED[parameter]:g} was assumed, because {rig} was not"
            " calibrated"
            for parameter, rig in used.items()
            if self.steel or self.pile
        ]
        notes = [*self.notes, *assumed, *said_of(self.bench.seed.get("seed", {}))]
        return Calibration(
            mode="simulated",
            bench=self.bench,
            steel=dict(self.steel),
            pile=pile,
            joint=self._joint(rng) if finished else None,
            refused=dict(self.refused),
            findings=(*self.findings, *(pile.findings if pile else ())),
            options={
                **self.prescribed.options,
                "effort": asdict(self.effort),
                "said": notes,
            },
            seed=self.seed,
            finished=finished,
            more={} if self.shape is None else {"shape_effect": self.shape},
        )
