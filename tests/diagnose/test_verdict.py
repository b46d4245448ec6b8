"""Alarm and posterior as one: whatever evidence and p are, verdict, probabilities and
sentence do not contradict each other."""

from dataclasses import replace
from types import SimpleNamespace

import beliefs
import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from scipy.integrate import quad

from benchtwin.diagnose import words
from benchtwin.infer import verdict as engine
from benchtwin.infer.alarm import ALARM_P
from benchtwin.infer.finding import Finding, Sector
from benchtwin.infer.verdict import (
    ALONE_PROBABILITY,
    NAME_PROBABILITY,
    UNSHAPED_ODDS,
    Interval,
    ParameterShift,
    against_noise,
    bounded,
    effect_estimate,
    size_is_told,
    verdict_of,
    weighed_with_noise,
)

NAMES = ("drag", "scale-error", "plate-tilt", "(unlisted) flight: along by t_s")
SETS = st.dictionaries(
    st.frozensets(st.sampled_from(NAMES), min_size=1, max_size=3).map(
        lambda s: tuple(sorted(s))
    ),
    st.floats(-300, 300).map(np.exp),
    min_size=1,
    max_size=6,
)
P = st.one_of(st.floats(1e-300, 1), st.floats(-690, 0).map(np.exp))
SIZES = st.dictionaries(
    st.sampled_from(NAMES), st.tuples(st.floats(-2, 2), st.floats(0.01, 2))
)
EVIDENCE = st.tuples(SETS, st.floats(-300, 300).map(np.exp))


def found(sets, nothing, p, left, sizes, recordings=8):
    """Posterior and verdict; left: p of all that each explanation leaves."""
    made = beliefs.posterior(
        sets | {(): nothing}, p, sizes=sizes, recordings=recordings
    )
    odds = UNSHAPED_ODDS * against_noise(left)
    every = tuple(
        replace(e, and_more=odds * e.probability if e.names and not e.unlisted else 0.0)
        for e in made.explanations
    )
    whole = bounded(replace(made, explanations=every))
    return whole, verdict_of(whole)


def as_finding(posterior, verdict, matters=True) -> Finding:
    presence, strange = posterior.presence(), posterior.unlisted()
    names = {n for n, q in presence.items() if q > 0.01 and n not in strange}
    return Finding(
        "drop",
        posterior.base.fit.problem.recordings,
        posterior.p_noise < ALARM_P,
        posterior.p_noise,
        (Sector("flight", 1.0, posterior.p_noise),),
        None,
        "",
        verdict.verdict,
        verdict.names,
        0.0,
        0.0,
        {},
        None,
        None,
        None,
        verdict.probability,
        matters,
        tuple(posterior.by_set()),
        {n: effect_estimate(posterior, n) for n in names},
        {
            "restitution": ParameterShift(
                Interval(0.5, 0.4, 0.6), Interval(0.6, 0.5, 0.7)
            )
        },
        unlisted=frozenset(posterior.unlisted()),
    )


def test_the_weight_of_a_p_value_is_a_density():
    """Its integral over uniform p is 1, and the less p the more it counts."""
    whole = quad(lambda u: against_noise(np.exp(-u)) * np.exp(-u), 0, 600, limit=500)
    assert whole[0] == pytest.approx(1, abs=3e-3)  # 1/600 lies beyond
    p = np.exp(-np.linspace(1e-5, 600, 4000))
    assert (np.diff([against_noise(x) for x in p]) > 0).all()
    assert UNSHAPED_ODDS * against_noise(ALARM_P) == pytest.approx(1)


@settings(deadline=None)
@given(EVIDENCE, P, P, SIZES)
@example(({("drag",): 0.15}, 0.85), 8e-62, 8e-62, {})  # as a real bench had them
@example(({("drag",): 0.999}, 0.001), 0.091, 0.5, {})  # drift, but noise makes as much
@example(({("drag",): 1.0}, 1.0), 0.0039, 1e-300, {})  # what drag leaves is strange
def test_alarm_and_posterior_never_contradict_each_other(evidence, p, left, sizes):
    posterior, verdict = found(*evidence, p, left, sizes)
    nothing = posterior.probability(())
    assert sum(q for _, q in posterior.by_set()) == pytest.approx(1)
    assert (verdict.verdict == "none") == (p >= ALARM_P)
    least = 1 / (1 + against_noise(ALARM_P)) - 1e-9
    assert nothing < 0.5 if p < ALARM_P else nothing >= least
    assert 0 <= verdict.probability <= 1 + 1e-9
    if verdict.verdict == "name":
        assert verdict.probability == posterior.probability(verdict.names)
        holding = [q for n, q in posterior.by_set() if set(verdict.names) <= set(n)]
        assert sum(holding) >= NAME_PROBABILITY
        assert verdict.probability >= ALONE_PROBABILITY
        assert all(size_is_told(posterior, n) for n in verdict.names)
    told = as_finding(posterior, verdict)
    sentence = words.verdict_in_words(told)
    assert ("nothing was shown to be missing" in sentence) == (p >= ALARM_P)
    assert words.odds(p) in sentence
    assert (words.tone(told) == "sure") == (p >= ALARM_P and nothing >= 0.8)


@settings(deadline=None)
@given(EVIDENCE, P, P, SIZES)
def test_every_probability_that_is_said_is_that_of_its_statement(
    evidence, p, left, sizes
):
    """Statements add up to 1, and verdict and rest are disjoint."""
    posterior, verdict = found(*evidence, p, left, sizes)
    told = as_finding(posterior, verdict)
    every = words.statements(told)
    assert sum(every.values()) == pytest.approx(1)
    names = set(verdict.names)
    if verdict.verdict == "none":
        mine = every[(), False]
    elif verdict.verdict == "name":
        mine = every[next(k for k in every if set(k[0]) == names and not k[1])]
    elif verdict.verdict == "class":
        mine = sum(q for (n, s), q in every.items() if n and not s and set(n) <= names)
    else:
        mine = sum(q for (n, s), q in every.items() if s and set(n) >= names)
    assert verdict.probability == pytest.approx(mine)


@settings(deadline=None)
@given(EVIDENCE, st.floats(1e-300, ALARM_P / 50))
def test_an_alarm_that_no_explanation_holds_is_unlisted(evidence, p):
    """Each explanation leaves as much as nothing missing does."""
    _, verdict = found(*evidence, p, p, {})
    assert verdict.verdict == "unknown" and verdict.probability > 0.8


@settings(deadline=None)
@given(EVIDENCE, P)
def test_a_smaller_p_never_speaks_more_for_nothing(evidence, p):
    one, other = (found(*evidence, x, 0.5, {})[0].probability(()) for x in (p, p * 0.9))
    assert other <= one + 1e-12


def test_a_clear_effect_is_named_and_one_recording_names_nothing():
    sets = {("drag",): 0.97, ("drag", "plate-tilt"): 0.02}
    posterior, verdict = found(sets, 1e-9, 1e-12, 0.6, {})
    assert (verdict.verdict, verdict.names) == ("name", ("drag",))
    assert verdict.probability == posterior.probability(("drag",)) < 0.97
    assert found(sets, 1e-9, 1e-12, 0.6, {}, recordings=1)[1].verdict == "class"


def test_a_class_of_pairs_holds_the_pairs_that_are_nearly_as_likely():
    """A drag that is sure beside a tilt or a scale, .55 and .3 of the pairs: neither is
    left out; a third of them, .1, is."""
    sets = {
        ("drag", "plate-tilt"): 0.55,
        ("drag", "scale-error"): 0.3,
        ("drag", "clock-error"): 0.1,
    }
    verdict = found(sets, 1e-9, 1e-12, 0.6, {})[1]
    assert verdict.verdict == "class"
    assert set(verdict.names) == {"drag", "plate-tilt", "scale-error"}


def test_a_size_whose_interval_holds_zero_is_no_name():
    """A draught of 0.017 (−0.086 to 0.120), as probable as can be."""
    sizes = {"drag": (0.017, 0.052)}
    _, verdict = found({("drag",): 1.0}, 1e-9, 1e-9, 0.6, sizes)
    assert (verdict.verdict, verdict.names) == ("class", ("drag",))


def test_a_further_parameter_may_tell_that_an_effect_is_there(monkeypatch):
    """Cohesion's share of the height is not known, but that it differs between sizes of
    seeds is."""
    sizes, contrast = {"drag": (0.003, 0.1)}, {}
    posterior, _ = found({("drag",): 1.0}, 1e-9, 1e-9, 0.6, sizes)
    problem = posterior.base.fit.problem
    monkeypatch.setattr(problem, "columns_of", lambda name: (name, "contrast"))
    monkeypatch.setattr(
        engine,
        "_linear_combination",
        lambda e, name, of: contrast["is"] if of[1] else sizes["drag"],
    )
    for contrast["is"], told in (((0.2, 0.01), True), ((0.001, 0.01), False)):
        assert size_is_told(posterior, "drag") == told


def test_without_any_explanation_an_alarm_is_unlisted():
    posterior, verdict = found({}, 1.0, 1e-6, 0.5, {})
    assert verdict.verdict == "unknown" and verdict.names == ()
    assert verdict.probability == pytest.approx(1 - posterior.probability(()))


def test_what_each_explanation_leaves_is_asked_of_the_alarm(monkeypatch):
    asked = []

    def left_over(e, rng):
        asked.append(e.names)
        return 0.4 if "drag" in e.names else 1e-9

    monkeypatch.setattr(engine, "left_over_p", left_over)
    monkeypatch.setattr(engine, "p_global", lambda posterior, rng: 1e-9)
    sets = {("drag",): 0.5, ("plate-tilt",): 0.5, (): 1e-6, (NAMES[3],): 0.2}
    whole = weighed_with_noise(beliefs.posterior(sets, 1.0), SimpleNamespace())
    assert sorted(asked) == [("drag",), ("plate-tilt",)]
    assert whole.probability(("drag",)) > 0.8 * (
        whole.probability(("drag",)) + whole.probability(("drag", "(unlisted)"))
    )
    assert whole.probability(("plate-tilt",)) < 1e-3
