"""The optimum of Eq. 11 and the sheet of solutions it is one point of."""

import numpy as np
import pandas as pd
import pytest
from scipy.optimize import minimize

from benchtwin.calibrate.statistics.box import Box
from benchtwin.calibrate.statistics.optimum import optimum, solution_set, stand
from benchtwin.calibrate.statistics.surface import fit_surface

PAPER = {"restitution": 0.65, "static_friction": 0.55, "rolling_friction": 0.04}


def test_the_papers_optimum_gives_31_degrees_and_stands_at_the_boundary(surface):
    found = stand(surface, PAPER, 31.0)
    assert round(found.predicted) == 31 and abs(found.gap) < found.se
    assert (
        found.boundary == {"restitution": "high"}
        and "restitution at its high limit" in found.statement
    )


def test_the_solution_nearest_the_papers_is_the_papers(surface):
    found = optimum(surface, 31.0, near=PAPER)
    assert {k: round(v, 2) for k, v in found.point.items()} == PAPER and abs(
        found.gap
    ) < 1e-6


def test_the_default_solution_is_the_one_nearest_the_centre(surface):
    """Against a brute-force search over the sampled sheet."""
    found = optimum(surface, 31.0)
    sheet = solution_set(surface, 31.0, rng=np.random.default_rng(1), points=4000)
    nearest = np.linalg.norm(
        surface.box.coded(sheet.table[list(surface.names)]), axis=1
    ).min()
    assert found.outcome == "reached" and not found.boundary and abs(found.gap) < 1e-6
    assert np.linalg.norm(found.coded) <= nearest < np.linalg.norm(found.coded) + 0.1


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
    empty = solution_set(surface, target, rng=np.random.default_rng(0))
    assert (
        len(empty.table) == 0 and empty.dimensions == 0 and empty.volume_fraction < 0.01
    )


def test_every_point_of_the_sheet_gives_the_target_and_lies_in_the_box(surface):
    found = solution_set(
        surface, 31.0, rng=np.random.default_rng(0), points=2000, band_sd=0.3
    )
    assert len(found.table) == 2000 and found.dimensions == 2
    np.testing.assert_allclose(found.table["predicted"], 31.0, atol=1e-9)
    coded = surface.box.coded(found.table[list(surface.names)])
    assert abs(coded).max() <= 1 + 1e-12
    assert 0.1 < found.volume_fraction < 0.5


def test_ranges_of_the_sheet_are_those_a_solver_finds(surface):
    """Smallest and largest restitution on the sheet, by constrained optimisation."""
    found = solution_set(
        surface, 31.0, rng=np.random.default_rng(0), points=3000
    ).ranges.set_index("factor")
    hold = {"type": "eq", "fun": lambda z: surface.mean(z)[0] - 31.0}
    for axis, name in enumerate(surface.names):
        least = min(
            (
                minimize(
                    lambda z, a=axis: z[a], s, bounds=[(-1, 1)] * 3, constraints=hold
                )
                for s in ([1, 1, 1], [0.9, 0.5, 0.2])
            ),
            key=lambda r: r.fun if r.success else np.inf,
        ).fun
        assert surface.box.coded(found["low"].to_numpy())[axis] == pytest.approx(
            least, abs=0.1
        ), name


def test_the_sheet_is_sampled_evenly(box):
    """On a plane the share of points in each half is the share of its area."""
    z = np.array(np.meshgrid([-1, 0, 1], [-1, 0, 1], [-1, 0, 1])).reshape(3, -1).T
    table = pd.DataFrame(box.natural(z), columns=box.names).assign(
        y_deg=z @ [3.0, 1.0, 0.2]
    )
    plane = fit_surface(
        table.assign(y_deg=table["y_deg"] + 1e-6 * np.arange(27) % 3),
        "y_deg",
        box,
        terms="linear",
    )
    points = box.coded(
        solution_set(plane, 0.0, rng=np.random.default_rng(0), points=4000).table[
            list(box.names)
        ]
    )
    density, _ = np.histogram(points[:, 1], bins=4, range=(-1, 1))
    assert len(points) == 4000 and abs(density / 1000 - 1).max() < 0.1


def test_a_curved_set_is_sampled_evenly_too():
    """On a circle all angles are alike; cut by axis-parallel lines alone, the diagonals
    would get 1.4 times their share."""
    box = Box.of({"a": (-1, 1), "b": (-1, 1)})
    z = np.array(np.meshgrid(*[np.linspace(-1, 1, 5)] * 2)).reshape(2, -1).T
    wobble = 1e-9 * np.cos(np.arange(len(z)))
    bowl = fit_surface(
        pd.DataFrame(z, columns=["a", "b"]).assign(y_mm=(z**2).sum(axis=1) + wobble),
        "y_mm",
        box,
    )
    found = solution_set(bowl, 0.49, rng=np.random.default_rng(0), points=4000)
    angle = np.arctan2(found.table["b"], found.table["a"]) % (np.pi / 2)
    near_diagonal = np.mean((angle > np.pi / 8) & (angle < 3 * np.pi / 8))
    assert found.dimensions == 1 and len(angle) == 4000
    assert near_diagonal == pytest.approx(
        0.5, abs=3 * 0.5 / np.sqrt(4000)
    )  # 0.541 if not thinned


def test_three_factors_leave_a_sheet_and_one_a_point(surface):
    x = np.linspace(-1, 1, 7)
    one = fit_surface(
        pd.DataFrame({"e": x, "y_deg": 2 * x + 0.3 * x**2 + 1e-3 * x**3}),
        "y_deg",
        Box.of({"e": (-1, 1)}),
    )
    found = solution_set(one, 1.0, rng=np.random.default_rng(0))
    assert (len(found.table), found.dimensions) == (1, 0)
    best = optimum(one, 1.0)
    assert "set of" not in best.statement and best.point["e"] == pytest.approx(
        found.table["e"][0], abs=1e-6
    )
    assert solution_set(surface, 30.0, rng=np.random.default_rng(0)).dimensions == 2


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda s: optimum(s, np.nan), "target"),
        (
            lambda s: optimum(s, 31.0, near={"restitution": 0.6}),
            "no value for static_friction, rolling_friction",
        ),
        (
            lambda s: stand(s, {**PAPER, "restitution": 0.8}, 31.0),
            "restitution: 0.8 lies outside",
        ),
    ],
)
def test_bad_questions_are_refused(surface, call, message):
    with pytest.raises(ValueError, match=message):
        call(surface)
