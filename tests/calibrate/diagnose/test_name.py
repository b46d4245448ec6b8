"""Naming in a linear space drawn for it: what is found first must not hide what it stood for."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from calibrate.diagnose.decide import Candidate, decide
from calibrate.diagnose.effects.effect import Effect
from calibrate.diagnose.linear import Reduced
from calibrate.diagnose.name import _settled, candidate, name
from calibrate.diagnose.problem import Fit, Problem, fit

PRIORS = {"stand-in": 500.0, "first": 10.0, "second": 1.6e6, "like-second": 10.0}


def test_what_is_dropped_again_has_not_hidden_what_it_stood_for():
    """Two effects are there. A stand-in for both is found first; beside it the second has nothing left to say but what one like
    it says under a tighter prior. Once the stand-in goes, the second fits better than the one like it (χ² by 36)."""
    rows = np.eye(40)
    off = 0.3  # of 20: χ² 36
    shapes = {
        "stand-in": rows[0] / 2 + rows[1] + off * rows[2], "first": rows[0], "second": rows[1],
        "like-second": rows[1] + off * rows[3],
    }  # fmt: skip
    effects = {n: Effect(n, "flight", "1", n, sd, -1e9, 1e9, "drawn") for n, sd in PRIORS.items()}
    a = np.column_stack(list(shapes.values())) / np.sqrt(3)
    made = (Reduced(a, rows[:, :6], 20 * (a[:, 1] + a[:, 2])),) * 3
    problem = Problem(
        "pile", tuple("abc"), effects, tuple(effects), {}, np.zeros((3, 0)),
        lambda starts, values, extra=None: (made, lambda moved: np.zeros((3, 0))), 120, 0.1, None, common_smooth=True,
    )  # fmt: skip
    found = name(fit(problem), SimpleNamespace(p=1e-9), np.random.default_rng(0))
    assert found.verdict == "name" and found.names == ("first", "second")


def drawn(shapes: dict[str, np.ndarray], twins: dict[str, tuple[str, ...]], curves: int = 6, known: tuple = ()) -> Fit:
    """The baseline on three recordings in which 20 of "first" and of "second" are seen; `known` are no candidates there."""
    effects = {n: Effect(n, "flight", "1", n, 100.0, -1e9, 1e9, "drawn", twins=twins.get(n, ())) for n in shapes}
    effects = {n: effect for n, effect in effects.items() if n not in known}
    a = np.column_stack(list(shapes.values())) / np.sqrt(3)
    made = (Reduced(a, np.eye(40)[:, :curves], 20 * (shapes["first"] + shapes["second"]) / np.sqrt(3)),) * 3
    problem = Problem(
        "pile", tuple("abc"), effects, tuple(shapes), dict.fromkeys(known, 0.1), np.zeros((3, 0)),
        lambda starts, values, extra=None: (made, lambda moved: np.zeros((3, 0))), 120, 0.1, None, common_smooth=True,
    )  # fmt: skip
    return fit(problem)


def verdict_on(base: Fit):
    return name(base, SimpleNamespace(p=1e-9), np.random.default_rng(0))


def test_where_something_is_left_the_twin_of_what_was_found_is_a_beginning_too():
    """A stand-in for both is found first, and a third effect mends it better than either of the two; they leave χ² of 20.

    As a control nobody says that the stand-in is taken for the first: what is left makes it unknown."""
    rows = np.eye(40)
    shapes = {
        "stand-in": rows[0] + rows[1] + 0.5 * rows[2], "first": rows[0], "second": rows[1],
        "third": rows[2] + 0.5 * rows[3],
    }  # fmt: skip
    found = verdict_on(drawn(shapes, {"stand-in": ("first",)}))
    assert found.verdict == "name" and found.names == ("first", "second")
    assert verdict_on(drawn(shapes, {})).verdict == "unknown"


def test_a_twin_that_the_bench_holds_as_known_takes_nobodys_place():
    """Air that a recording states is no candidate there, though others are taken for it."""
    rows = np.eye(40)
    shapes = {"first": rows[0], "second": rows[1], "air": rows[1] + 0.3 * rows[2]}
    found = verdict_on(drawn(shapes, {"second": ("air",)}, known=("air",)))
    assert found.verdict == "name" and found.names == ("first", "second")


def test_two_stand_ins_give_way_one_after_the_other():
    """Found are two, each of which stands for another: neither swap alone leads to the two that are there."""
    rows, rng = np.eye(40), np.random.default_rng(0)
    shapes = {
        "first": rows[0], "second": rows[1], "like-first": rows[0] + 0.3 * rows[2], "like-second": rows[1] + 0.4 * rows[3],
    }  # fmt: skip
    base = drawn(shapes, {"like-first": ("first",), "like-second": ("second",)})
    found = ("like-first", "like-second")
    tried = {key: candidate(base, key, rng) for key in ((), found)}
    assert _settled(base, found, tried, {}, rng) == ("first", "second")


def test_what_stands_for_two_and_leaves_nothing_that_shows_gives_way_to_both():
    """A stand-in for both leaves χ² of 24, which is nothing among 30 curves; as a control where it leaves but 4."""
    rows = np.eye(40)

    def told(off: float):
        shapes = {"stand-in": rows[0] + rows[1] + off * rows[10], "first": rows[0], "second": rows[1]}
        return verdict_on(drawn(shapes, {"stand-in": ("first",)}, curves=30))

    assert told(0.25).names == ("first", "second")
    assert told(0.1).names == ("stand-in",)


@pytest.mark.parametrize(("value", "members"), [(0.1, ("drag", "lens")), (5.0, ("drag", "lens", "wind"))])
def test_what_a_rival_has_nothing_of_is_no_member_of_its_class(value, members):
    """A rival that comes near with another effect of 0.1 ± 1; as a control of 5 ± 1."""
    effects = {n: Effect(n, "flight", "1", n, 1.0, -9.0, 9.0, "drawn") for n in ("drag", "lens", "wind")}
    best = Candidate(("drag", "lens"), (3.0, 4.0), (1.0, 1.0), 50.0, 5.0, 1.0, 1.0, 0.5, ())
    rival = replace(best, names=("drag", "wind"), value=(3.0, value), ln_bayes=49.0)
    found = decide(effects, 1e-9, best.names, (best, rival), 1.0)
    assert found.verdict == "class" and found.names == members
