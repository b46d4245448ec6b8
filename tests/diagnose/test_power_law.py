"""Laws by regression: of drawn curves the power and the size, and of noise none."""

from dataclasses import replace

import numpy as np
import pytest

from benchtwin.infer import power_law
from benchtwin.infer.effect import Counterpart, Effect
from benchtwin.infer.noise import Noise, frame_lag
from benchtwin.infer.power_law import (
    Family,
    fitted,
    in_words,
    law_of,
    raised,
    risen,
)
from benchtwin.infer.problem import Problem, fit
from benchtwin.infer.series import Locals, Series, problem_of
from benchtwin.sim.laws import LAWS

ROWS, SIGMA = 80, 0.01
POWERS = tuple(np.arange(1.25, 4.01, 0.25))


def places(r: int) -> np.ndarray:
    """Each recording reaches farther than the one before."""
    return np.linspace(0.0, 0.7 + 0.1 * r, ROWS)


def problem(curves: list[np.ndarray], effects=None) -> Problem:
    """y = own level + common slope · x + what is found."""
    effects = effects or {}

    def predict(r: int, own: np.ndarray, at: dict[str, float]) -> np.ndarray:
        x = places(r)
        found = [e.resist(x, at[n], None, at) for n, e in effects.items() if at.get(n)]
        return own[0] + at["slope"] * x + sum(found)

    lag = frame_lag(np.arange(ROWS))
    series = tuple(
        Series(f"r{k}", y, SIGMA, lag, Noise(0.0, 0.0, 0.1), np.zeros((ROWS, 0)))
        for k, y in enumerate(curves)
    )
    own = Locals(np.zeros((len(curves), 1)), np.array([1e-4]), np.array([np.inf]))
    about = ({"slope": 1.0}, {"slope": 1.0}, None)
    made = problem_of("toy", series, own, predict, effects, *about)
    return replace(
        made,
        with_effect=lambda effect: problem(curves, effects | {effect.name: effect}),
    )


def drawn(seed: int, size: float = 0.0, power: float = 3.0, count: int = 4):
    rng = np.random.default_rng(seed)
    return [
        rng.normal() + 0.3 * x + size * x**power + SIGMA * rng.normal(size=ROWS)
        for x in map(places, range(count))
    ]


def acts(name: str, power: float) -> dict:
    return {
        "resist": lambda x, value, seed, at: value * raised(x, power),
        "counterpart": Counterpart("{value} more"),
    }


def found(curves: list[np.ndarray], listed: Effect | None = None, **about):
    base = fit(problem(curves, {listed.name: listed} if listed else {}))
    if listed:
        base = fit(base.problem, free=(listed.name,), start=base)
    family = Family(
        lambda rises, power: f"it {'rises' if rises else 'falls'} {power}",
        ("1", "at the end"),
        "run-out",
        POWERS,
        "place",
        **about,
    )
    columns = [
        np.column_stack([raised(places(r), p) for p in POWERS])
        for r in range(len(curves))
    ]
    return base, law_of(base, [family], columns)


@pytest.mark.parametrize(("size", "power"), [(0.2, 3.0), (-0.2, 2.0)])
def test_a_drawn_power_is_found_with_its_size(size, power):
    _, terms = found(drawn(1, size, power))
    assert len(terms) == 1
    assert f"to the power {power:g} (" in terms[0].words
    assert ("rises" in terms[0].words) == (size > 0)
    assert terms[0].size == pytest.approx(size, rel=0.2)  # it goes with the power
    assert "at the end" in terms[0].in_words() and terms[0].sd < 0.1 * abs(size)


def test_noise_has_no_law():
    assert not any(found(drawn(seed))[1] for seed in range(20))


BEND = Effect(
    "bend",
    "run-out",
    "1",
    "of x^2.5",
    3.0,
    -np.inf,
    np.inf,
    "the test's own",
    resist=lambda x, value, seed, at: value * raised(x, 2.5),
)


@pytest.mark.parametrize(
    ("size", "listed", "size_of_log"),
    [(1.5, None, 0.0), (0.0, BEND, 0.2)],
    ids=["more than the weight", "undone by a listed effect"],
)
def test_a_law_that_cannot_be_is_none(size, listed, size_of_log, monkeypatch):
    """1.5 of the weight; or x^2.5 ln x, which x^2.75 less x^2.5 is nearly, each of them
    four times as large. As a control without judging."""
    curves = [
        c + size_of_log * raised(places(r), 2.5) * np.log(np.maximum(places(r), 1e-9))
        for r, c in enumerate(drawn(1, size))
    ]
    assert found(curves, listed)[1] is None
    monkeypatch.setattr(power_law, "is_possible", lambda *about: True)
    assert found(curves, listed)[1]


def test_beside_a_listed_effect_a_law_that_adds_to_it_is_found():
    curves = [c + 0.3 * raised(places(r), 2.5) for r, c in enumerate(drawn(1, 0.2, 4))]
    (term,) = found(curves, BEND)[1]
    assert term.size == pytest.approx(0.2, rel=0.5)


def test_a_law_found_is_fitted_as_an_effect():
    """As found, where the problem is linear."""
    curves = drawn(1, 0.2)
    base, terms = found(curves, acts=acts)
    own = fitted(base, (), terms)
    assert own.by_name["law"] == pytest.approx(terms[0].size, rel=0.05)
    assert own.chi2 < base.chi2 - 100


def test_powers_are_those_of_the_twins_laws():
    for speed in (0.0, 0.01, 0.3, 2.0):
        for power in (-2.0, 0.5, 3.0):
            more = 0.1 * float(raised(np.array(speed / 0.5), power))
            told = (speed, 0.4, 0.1, 0.5, power)
            assert LAWS["friction_power"].function(*told) == pytest.approx(0.4 + more)
            told = (2.0, speed / 3e-3, 3e-3, 0.4, 0.1, 0.5, power)
            torque = LAWS["rolling_power"].function(*told)
            assert torque == pytest.approx(more * 2.0 * 3e-3)
    for power in (-1.0, 0.0, 2.0):
        e = LAWS["restitution_power"].function(0.8, 0.5, 0.05, 1.2, power)
        more = 0.05 * float(risen(np.array(0.8 / 1.2), power))
        assert e == pytest.approx(0.5 + more)


def test_an_exponent_is_said_with_the_simplest_number_in_its_interval():
    assert in_words(2.6, 2.2, 3.1) == "to the power 3 (2.2 to 3.1)"
    assert in_words(2.6, 2.55, 2.7) == "to the power 2.6 (2.5 to 2.7)"
    assert in_words(4.0, 3.2, np.inf) == "to the power 4 (at least 3.2)"
