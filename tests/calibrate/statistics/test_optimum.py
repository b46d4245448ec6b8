"""The optimum of Eq. 11, one point of a sheet of solutions."""

import numpy as np
import pytest

from benchtwin.calibrate.statistics.optimum import optimum

PAPER = {"restitution": 0.65, "static_friction": 0.55, "rolling_friction": 0.04}


def test_the_papers_optimum_gives_31_degrees(surface):
    at = surface.box.coded([PAPER[name] for name in surface.names])
    predicted, se = surface.mean(at)[0], np.sqrt(surface.variance(at)[0])
    assert round(predicted) == 31 and abs(predicted - 31) < se


def test_the_solution_nearest_the_papers_is_the_papers_at_the_boundary(surface):
    found = optimum(surface, 31.0, near=PAPER)
    assert {k: round(v, 2) for k, v in found.point.items()} == PAPER and abs(
        found.predicted - 31
    ) < 1e-6
    assert (
        found.boundary == {"restitution": "high"}
        and "restitution at its high limit" in found.statement
    )


def test_the_default_solution_is_the_one_nearest_the_centre(surface):
    """Against a brute-force search over a fine grid: of points within 0.01° of the
    target none lies nearer than a grid's step."""
    found = optimum(surface, 31.0)
    axis = np.linspace(-1, 1, 101)
    grid = np.stack(np.meshgrid(axis, axis, axis), axis=-1).reshape(-1, 3)
    there = grid[abs(surface.mean(grid) - 31.0) < 0.01]
    nearest = np.linalg.norm(there, axis=1).min()
    assert found.outcome == "reached" and not found.boundary
    assert abs(found.predicted - 31) < 1e-6
    assert np.linalg.norm(found.coded) == pytest.approx(nearest, abs=0.02)


@pytest.mark.parametrize(
    ("target", "outcome", "side"),
    [(40.0, "target above all", "high"), (20.0, "target below all", "low")],
)
def test_a_target_out_of_reach_is_a_result_and_no_error(surface, target, outcome, side):
    found = optimum(surface, target)
    assert (
        found.outcome == outcome
        and set(found.boundary.values()) == {side}
        and "a finding" in found.statement
    )
    grid = np.stack(np.meshgrid(*[np.linspace(-1, 1, 41)] * 3), axis=-1).reshape(-1, 3)
    assert found.reachable == pytest.approx(
        (surface.mean(grid).min(), surface.mean(grid).max()), abs=2e-3
    )


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda s: optimum(s, np.nan), "target"),
        (
            lambda s: optimum(s, 31.0, near={"restitution": 0.6}),
            "no value for static_friction, rolling_friction",
        ),
    ],
)
def test_bad_questions_are_refused(surface, call, message):
    with pytest.raises(ValueError, match=message):
        call(surface)
