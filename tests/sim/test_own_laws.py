"""A law of one's own that breaks the contract is refused in one sentence when it is
made, before anything is compiled."""

import math
from math import exp

import pytest

from benchtwin.sim.laws import Law, Parameter

STIFFNESS = 3.0
K = Parameter("k", "N/m", 0.0, 1e7, "stiffness")


def short(overlap, closing_speed, radius, k):
    return k * overlap


def swapped(overlap, closing_speed, radius, modulus, c, k):
    return k * overlap + c


def with_default(overlap, closing_speed, radius, modulus, k=3.0):
    return k * overlap


def of_the_module(overlap, closing_speed, radius, modulus, k):
    return STIFFNESS * k * overlap


def says_nothing(overlap, closing_speed, radius, modulus, k):
    if overlap > 0:
        return k * overlap


def a_text(overlap, closing_speed, radius, modulus, k):
    return "k"


def divides(overlap, closing_speed, radius, modulus, k):
    return k / (overlap - 1e-3)


def endless(overlap, closing_speed, radius, modulus, k):
    return math.inf


def good(overlap, closing_speed, radius, modulus, k):
    return k * max(overlap, 0.0) * math.sqrt(radius) * exp(-abs(overlap))


@pytest.mark.parametrize(
    ("function", "words"),
    [
        (short, r"takes \(overlap, closing_speed, radius, k\), not \(overlap, closing"),
        (swapped, r"closing_speed, radius, modulus, c, k\), not"),
        (with_default, r"k=3\.0\), not .* without a default"),
        (of_the_module, "uses STIFFNESS; it may use its arguments and math only"),
        (says_nothing, r"returns None for \(-0\.0001, .*\), not one finite number"),
        (a_text, "returns 'k' for"),
        (divides, r"fails for \(0\.001, .*\): ZeroDivisionError"),
        (endless, "returns inf for"),
    ],
)
def test_a_law_that_breaks_the_contract_is_refused(function, words):
    with pytest.raises(ValueError, match=words) as told:
        Law("own", "normal", function, (K,))
    said = str(told.value)
    assert said.startswith("law 'own' of kind 'normal': ") and "\n" not in said


def test_a_law_that_keeps_it_is_taken():
    assert Law("own", "normal", good, (K,)).use(k=2.0).numbers == (2.0,)


def test_what_has_no_source_or_a_closure_is_refused():
    size = 3.0

    def enclosed(overlap, closing_speed, radius, modulus, k):
        return size * k * overlap

    with pytest.raises(ValueError, match="uses size; it may use"):
        Law("own", "normal", enclosed, (K,))
    made: dict = {}
    exec("def f(t, k):\n    return k * t, k", made)
    with pytest.raises(ValueError, match="has no source file"):
        Law("own", "motion", made["f"], (K,))


def test_one_number_in_the_place_of_six_is_refused():
    def wind(vx, vy, vz, wx, wy, wz, diameter, k):
        return k

    with pytest.raises(ValueError, match=r"returns 0\.0 for .*, not 6 finite numbers"):
        Law("own", "body", wind, (K,))


@pytest.mark.parametrize(
    ("kind", "words"),
    [("restitution", "not 0 to 1"), ("friction", "not 0 or more")],
)
def test_what_would_make_energy_is_refused(kind, words):
    """A restitution above 1; friction that drives."""

    def driving(speed, value, k):
        return value - k

    with pytest.raises(ValueError, match=words):
        Law("own", kind, driving, (Parameter("k", "1", -2.0, 2.0, ""),))


def test_a_reach_keeps_the_same_contract():
    with pytest.raises(ValueError, match=r"takes \(radius\), not \(radius, modulus, k"):
        Law("own", "normal", good, (K,), reach=lambda radius: radius)


@pytest.mark.parametrize(
    ("low", "high", "default"),
    [(1.0, 0.0, None), (0.0, math.inf, 1.0), (0.0, 1.0, 2.0)],
)
def test_a_parameter_s_range_is_one(low, high, default):
    with pytest.raises(ValueError, match="parameter 'k': low"):
        Parameter("k", "1", low, high, "", default)
