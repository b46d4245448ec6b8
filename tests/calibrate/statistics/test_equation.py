"""A publication's curves: what it printed comes out of its rows."""

import numpy as np
import pandas as pd
import pytest

from benchtwin.calibrate.statistics.equation import fit_equation


def test_equation_5_comes_out_of_table_2_and_answers_at_the_benchs_mean(drop_rows):
    found = fit_equation(drop_rows, "restitution", "rebound_height_mm", 2)
    assert found.coefficients == pytest.approx([178.6, 98.57, -10.23], rel=1e-3)
    assert round(found.r2, 4) == 0.9987
    assert found.at(95.0) == pytest.approx(0.5398, abs=1e-4)
    assert found.mean(found.at(95.0)) == pytest.approx(95.0)


def test_a_straight_line_and_a_value_beyond_its_rows(slide_rows):
    found = fit_equation(slide_rows, "static_friction", "slide_angle_deg", 1)
    assert found.coefficients == pytest.approx([50.0, 2.5])
    assert found.at(26.0) == pytest.approx(0.47) and found.high == 0.45


def test_what_no_value_gives_has_no_answer():
    x = np.linspace(-1, 1, 7)
    found = fit_equation(pd.DataFrame({"x": x, "y": x**2}), "x", "y", 2)
    assert np.isnan(found.at(-1.0))


@pytest.mark.parametrize(
    ("rows", "message"),
    [
        ({"x": [1, 2, 3], "y": [1, 2, 4]}, "degree 2 needs at least 4 different"),
        ({"x": [1, 2, 3, 4], "y": [2, 2, 2, 2]}, "all 4 values equal 2"),
    ],
)
def test_rows_that_carry_no_curve_are_refused(rows, message):
    with pytest.raises(ValueError, match=message):
        fit_equation(pd.DataFrame(rows), "x", "y", 2)
