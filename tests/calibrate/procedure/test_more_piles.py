"""Piles beyond the design: where they are put, and when there are enough."""

from dataclasses import replace

import numpy as np
import pandas as pd
from benchtwin.calibrate.procedure.bench import RigReadings
from benchtwin.calibrate.procedure.effort import QUICK
from benchtwin.calibrate.procedure.more_piles import BATCH, PACKINGS, WAIT, add_piles
from benchtwin.calibrate.procedure.pile_runs import measure_noise, run_design
from benchtwin.calibrate.procedure.pile_stage import RANGES, PileStage
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


def stage_after_its_design(effect: float, more: int, seed: int = 3) -> PileStage:
    bench = RigReadings(
        "pile",
        "repose_angle_deg",
        np.array([25.0, 26.0, 24.5, 25.5]),
        np.zeros(4),
        0.0,
        {},
        pd.DataFrame(),
        (),
        {},
    )
    stage = PileStage(
        bench, {}, {}, Piles(effect, seed), replace(QUICK, more=more), 1, RANGES, BOX
    )
    noise, pairing, _, _ = measure_noise(stage, BOX)
    run_design(stage, BOX, noise, pairing, 0.0)
    stage.simulate.asked.clear()
    return stage


def test_added_piles_lie_in_the_box_on_packings_of_their_own():
    stage = stage_after_its_design(effect=4.0, more=8)
    (note,) = add_piles(stage, BOX, shared=False)
    asked, known = stage.simulate.asked, pd.concat(stage.done[:-2])["packing"]
    assert (
        0 < len(asked) <= 8
        and len(asked) % BATCH == 0
        and f"{len(asked)} piles" in note
    )
    assert len({r.rng for r in asked}) == len(asked) and known.max() < PACKINGS
    points = np.array([[r.values[n] for n in RANGES] for r in asked])
    assert (abs(BOX.coded(points)) <= 1 + 1e-9).all()


def test_without_leave_no_pile_is_added():
    stage = stage_after_its_design(effect=4.0, more=0)
    assert add_piles(stage, BOX, shared=False) == [] and not stage.simulate.asked


def test_piles_that_say_nothing_are_given_up_at_once():
    """Where no parameter does anything the intervals cannot shrink; where they do
    something (control), some seeds ask for more."""

    def asked_for(effect: float, seed: int) -> int:
        stage = stage_after_its_design(effect, more=40, seed=seed)
        add_piles(stage, BOX, shared=False)
        return len(stage.simulate.asked)

    assert [asked_for(0.0, seed) for seed in range(4)] == [WAIT * BATCH] * 4
    assert max(asked_for(2.0, seed) for seed in range(4)) > WAIT * BATCH
