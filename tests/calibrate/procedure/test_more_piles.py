"""Piles beyond the design: where they are put, and when there are enough."""

from dataclasses import replace

import numpy as np
import pandas as pd

from benchtwin.calibrate.procedure.bench import RigReadings
from benchtwin.calibrate.procedure.effort import QUICK
from benchtwin.calibrate.procedure.pile_stage import PileStage
from benchtwin.calibrate.procedure.rigs import RANGES
from benchtwin.calibrate.procedure.seed_runs import (
    BATCH,
    PACKINGS,
    WAIT,
    add_piles,
    simulate_design,
)
from benchtwin.calibrate.statistics.box import Box

BOX = Box.of(RANGES)


class Piles:
    """Piles whose angle rises with static and rolling friction by `effect` over the
    box, and scatters by 1°."""

    def __init__(self, effect: float, seed: int):
        self.effect, self.rng, self.asked = effect, np.random.default_rng(seed), []

    def __call__(self, runs):
        self.asked += runs
        points = np.array([[r.values[n] for n in RANGES] for r in runs])
        angle = (
            25
            + BOX.coded(points) @ [0.0, self.effect, self.effect / 2]
            + self.rng.standard_normal(len(runs))
        )
        return pd.DataFrame(
            {"repose_angle_deg": angle, "status": "done", "reason": "", "rerun": ""}
        )


def after_the_design(
    effect: float, more: int, seed: int = 3
) -> tuple[PileStage, pd.DataFrame]:
    """A stage, and the piles of its design."""
    stage = PileStage(
        readings=RigReadings(
            rig="pile",
            response="repose_angle_deg",
            values=np.array([25.0, 26.0, 24.5, 25.5]),
            reading_sd=np.zeros(4),
        ),
        fixed={},
        description={},
        simulate=Piles(effect, seed),
        effort=replace(QUICK, more=more),
        seed=1,
        box=BOX,
    )
    done = simulate_design(stage)
    stage.simulate.asked.clear()
    return stage, done


def test_added_piles_lie_in_the_box_on_packings_of_their_own():
    stage, before = after_the_design(effect=4.0, more=8)
    done, (note,) = add_piles(stage, before)
    asked = stage.simulate.asked
    assert (
        0 < len(asked) <= 8
        and len(asked) % BATCH == 0
        and f"{len(asked)} heaps more" in note
    )
    assert len(done) == len(before) + len(asked)
    assert len({r.rng for r in asked}) == len(asked)
    assert before["packing"].max() < PACKINGS <= done["packing"][len(before) :].min()
    points = np.array([[r.values[n] for n in RANGES] for r in asked])
    assert (abs(BOX.coded(points)) <= 1 + 1e-9).all()


def test_without_leave_no_pile_is_added():
    stage, before = after_the_design(effect=4.0, more=0)
    done, notes = add_piles(stage, before)
    assert done is before and notes == [] and not stage.simulate.asked


def test_piles_that_say_nothing_are_given_up_at_once():
    """Where no parameter does anything the intervals cannot shrink; where they do
    something (control), some seeds ask for more."""

    def asked_for(effect: float, seed: int) -> int:
        stage, before = after_the_design(effect, more=40, seed=seed)
        add_piles(stage, before)
        return len(stage.simulate.asked)

    assert [asked_for(0.0, seed) for seed in range(4)] == [WAIT * BATCH] * 4
    assert max(asked_for(2.0, seed) for seed in range(4)) > WAIT * BATCH
