"""How unevenly a seed rolls: seen where each run has a way of its own, not where all have the same, nor of a ball."""

from dataclasses import replace

import numpy as np
import pytest
from rolling import BALL, STATED, Bench, rolls

from calibrate.diagnose.problem import Fit, fit
from calibrate.diagnose.roll.model import Model
from calibrate.diagnose.roll.problem import PARTS, build, parts, roll_problem
from calibrate.diagnose.roll.ripple import arguments
from calibrate.diagnose.roll.rough import roughness
from calibrate.diagnose.roll.session import assemble

UNEVEN = 1e-3  # of the weight, in each part of the way


def fitted(stated: dict, uneven: np.ndarray) -> Fit:
    """Baseline of as many runs as `uneven` (R, PARTS) has rows: resistance over weight in each part, added to clean runs."""
    rng = np.random.default_rng(3)
    runs, seed, _ = assemble(rolls(Bench(stated=stated, noise_mm=0.03), len(uneven), rng, directions=("+x",)))
    model: Model = build(runs, seed, *arguments(runs, seed), ripple=False)
    base = fit(roll_problem(model, {run.session: 2e-4 for run in runs}))
    ways = [parts(base.problem.model, r, base.starts[r], base.by_name) @ more for r, more in enumerate(uneven)]
    changed = tuple(replace(run, x=run.x + way) for run, way in zip(runs, ways, strict=True))
    again = build(changed, seed, *arguments(changed, seed), ripple=False)
    return fit(roll_problem(again, {run.session: 2e-4 for run in runs}))


def drawn(runs: int) -> np.ndarray:
    return UNEVEN * np.random.default_rng(4).normal(size=(runs, PARTS))


def test_what_each_run_has_of_its_own_is_seen_and_measured():
    found = roughness(fitted(STATED, drawn(5)))
    assert np.median(found) == pytest.approx(UNEVEN, rel=0.5) and (found > UNEVEN / 3).all()


def test_even_runs_have_none():
    assert not roughness(fitted(STATED, 0 * drawn(5))).any()


def test_what_all_runs_have_in_common_is_no_roughness_but_physics():
    assert not roughness(fitted(STATED, np.tile(drawn(1), (5, 1)))).any()


def test_a_ball_is_even_and_two_runs_do_not_tell():
    assert not roughness(fitted(BALL, drawn(3))).any()
    assert not roughness(fitted(STATED, drawn(2))).any()
