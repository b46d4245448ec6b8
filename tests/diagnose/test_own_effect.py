"""An effect is one record: one that acts on the way travelled, of which no solver and
no list knows, has its size where it is concealed, and none elsewhere."""

from dataclasses import replace

import numpy as np
import pytest
import rolling
import sliding

from benchtwin.infer.effect import Effect
from benchtwin.infer.problem import Problem, fit
from benchtwin.rigs.roll import session as roll_session
from benchtwin.rigs.roll.diagnose import baseline, scales_of
from benchtwin.rigs.roll.effects import EFFECTS as OF_ROLLS
from benchtwin.rigs.slide import session as slide_session
from benchtwin.rigs.slide.diagnose import alternatives
from benchtwin.rigs.slide.effects import EFFECTS as OF_SLIDES
from benchtwin.rigs.slide.problem import prepare

BEGINS_M = 0.03  # of the rolls' run-out; a slide's is at its onset
WORN = Effect(
    name="worn-track",
    sector="run-out",
    unit="1/m",
    meaning="growth of friction with the way",
    prior_sd=0.2,
    low=0.0,
    high=5.0,
    source="made up",
    wording=("friction grows with the way travelled", "1/m"),
    not_simulated="the twin's plate does not wear",
    along=lambda way, value: value * np.maximum(way - BEGINS_M, 0.0),
)


def rolls(per_m: float) -> Problem:
    balls = rolling.Bench(
        stated=rolling.BALL, radius_mm=3.5, by_travel=per_m, corner=0.024
    )
    seen = rolling.rolls(balls, 2, np.random.default_rng(4))
    runs, seed, _ = roll_session.assemble(seen)
    return baseline(runs, seed, scales_of(seen), np.random.default_rng(0))[0]


def slides(per_m: float) -> Problem:
    worn = (lambda v, x: per_m * x) if per_m else None
    bench = replace(sliding.AIRLESS, friction=worn, rates=(1.0, 5.0))
    seen = sliding.slides(bench, 2, np.random.default_rng(1))
    return alternatives(prepare(slide_session.assemble(seen)), None)[0].problem


@pytest.mark.parametrize(
    ("made", "effects", "per_m"), [(rolls, OF_ROLLS, 0.1), (slides, OF_SLIDES, 0.4)]
)
def test_a_record_alone_is_an_effect(monkeypatch, made, effects, per_m):
    worn = replace(WORN, along=lambda way, value: value * way)
    monkeypatch.setitem(effects, WORN.name, WORN if effects is OF_ROLLS else worn)
    for true in (per_m, 0.0):
        problem = made(true)
        found = fit(problem, free=(WORN.name,), start=fit(problem))
        assert abs(found.by_name[WORN.name] - true) < 3 * found.sd(WORN.name)
        assert found.sd(WORN.name) < per_m / 5
