"""Naming in a linear space drawn for it: what is found first must not hide what it stood for."""

from types import SimpleNamespace

import numpy as np

from calibrate.diagnose.effects.effect import Effect
from calibrate.diagnose.linear import Reduced
from calibrate.diagnose.name import name
from calibrate.diagnose.problem import Problem, fit

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


def drawn(shapes: dict[str, np.ndarray], twins: dict[str, tuple[str, ...]]):
    """The verdict on three recordings in which 20 of "first" and of "second" are seen."""
    effects = {n: Effect(n, "flight", "1", n, 100.0, -1e9, 1e9, "drawn", twins=twins.get(n, ())) for n in shapes}
    a = np.column_stack(list(shapes.values())) / np.sqrt(3)
    made = (Reduced(a, np.eye(40)[:, :6], 20 * (shapes["first"] + shapes["second"]) / np.sqrt(3)),) * 3
    problem = Problem(
        "pile", tuple("abc"), effects, tuple(effects), {}, np.zeros((3, 0)),
        lambda starts, values, extra=None: (made, lambda moved: np.zeros((3, 0))), 120, 0.1, None, common_smooth=True,
    )  # fmt: skip
    return name(fit(problem), SimpleNamespace(p=1e-9), np.random.default_rng(0))


def test_where_something_is_left_the_twin_of_what_was_found_is_a_beginning_too():
    """A stand-in for both is found first, and a third effect mends it better than either of the two; they leave χ² of 20.

    As a control nobody says that the stand-in is taken for the first: what is left makes it unknown."""
    rows = np.eye(40)
    shapes = {
        "stand-in": rows[0] + rows[1] + 0.5 * rows[2], "first": rows[0], "second": rows[1],
        "third": rows[2] + 0.5 * rows[3],
    }  # fmt: skip
    found = drawn(shapes, {"stand-in": ("first",)})
    assert found.verdict == "name" and found.names == ("first", "second")
    assert drawn(shapes, {}).verdict == "unknown"
