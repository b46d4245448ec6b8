"""The ANOVA table against the paper's Table 10; contributions; printed
values that do not follow."""

import numpy as np
import pandas as pd
import pytest
import statsmodels.formula.api as smf

from benchtwin.calibrate.procedure.published import compare, flatten, follows
from benchtwin.calibrate.statistics.designs import box_behnken
from benchtwin.calibrate.statistics.surface import (
    anova_table,
    contributions,
    fit_surface,
)

TABLE_10 = """
Model 14.40 9 1.60 24.37 <0.01
A 2.76 1 2.76 42.06 <0.01
B 5.61 1 5.61 85.48 <0.01
C 4.81 1 4.81 73.20 <0.01
AB 0.02 1 0.02 0.34 0.58
AC 0.04 1 0.04 0.61 0.46
BC 0.49 1 0.49 7.46 0.03
A² 4.45E-003 1 4.45E-003 0.07 0.80
B² 0.34 1 0.34 5.12 0.06
C² 0.28 1 0.28 4.25 0.08
Residual 0.46 1 0.07 - -
Lack_of_fit 0.15 3 0.05 0.63 0.63
Pure_error 0.31 4 0.08 - -
Total 14.86 16 - - -
"""
COLUMNS = ["sum_of_squares", "df", "mean_square", "f", "p"]


def printed_table_10() -> dict[str, str]:
    rows = [line.split() for line in TABLE_10.strip().splitlines()]
    return {
        f"{r[0].replace('_', ' ')} {c}": v
        for r in rows
        for c, v in zip(COLUMNS, r[1:])
        if v != "-"
    }


def test_rows_stand_in_the_order_users_know(surface):
    expected = [
        "Model",
        "A",
        "B",
        "C",
        "AB",
        "AC",
        "BC",
        "A²",
        "B²",
        "C²",
        "Residual",
        "Lack of fit",
        "Pure error",
        "Total",
    ]
    assert list(anova_table(surface)["source"]) == expected


def test_table_10_is_recomputed(surface):
    t = anova_table(surface).set_index("source")
    assert t.loc["Total", "sum_of_squares"] == pytest.approx(14.8553, abs=5e-5)
    assert (t.loc["Residual", "sum_of_squares"], t.loc["Residual", "df"]) == (
        pytest.approx(0.4595, abs=5e-5),
        7,
    )
    assert (t.loc["Lack of fit", "sum_of_squares"], t.loc["Lack of fit", "df"]) == (
        pytest.approx(0.1475, abs=5e-5),
        3,
    )
    assert (t.loc["Pure error", "sum_of_squares"], t.loc["Pure error", "df"]) == (
        pytest.approx(0.312, abs=5e-5),
        4,
    )
    assert t.loc["Lack of fit", ["f", "p"]].tolist() == pytest.approx(
        [0.63, 0.63], abs=0.005
    )


def test_of_the_printed_table_10_only_the_residual_df_does_not_follow(surface):
    checked = compare(printed_table_10(), flatten(anova_table(surface), "source"))
    assert checked.loc[~checked["follows"], "item"].tolist() == ["Residual df"]
    assert len(checked) == 10 * 5 + 3 + 5 + 3 + 2


def test_a_false_print_is_flagged(surface):
    wrong = {**printed_table_10(), "A f": "42.16", "BC p": "<0.01"}
    checked = compare(wrong, flatten(anova_table(surface), "source"))
    assert set(checked.loc[~checked["follows"], "item"]) == {
        "Residual df",
        "A f",
        "BC p",
    }


def test_printed_text_is_read_with_its_digits():
    assert follows("4.45E-003", 0.0044474) and not follows("4.45E-003", 0.00444)
    assert (
        follows("-10.23", -10.232)
        and follows("−0.033", -0.0325)
        and follows("0.59", 0.5875)
    )
    assert (
        follows("<0.01", 0.002) and not follows("<0.01", 0.03) and follows(">0.05", 0.2)
    )
    assert not follows("1.85", 1.87)
    for text in ("", "about 3", "E5", "."):
        with pytest.raises(ValueError, match="not a number"):
            follows(text, 1.0)
    with pytest.raises(ValueError, match="nothing was recomputed for: Q"):
        compare({"Q": "1"}, {"R": 1.0})


def test_lack_of_fit_is_the_comparison_with_a_mean_per_point(surface):
    """Pure error is what a model with one mean a design point leaves: statsmodels' F
    test between both models."""
    table = pd.DataFrame(surface.points, columns=["A", "B", "D"]).assign(
        y=surface.fit.model.endog
    )
    table["cell"] = table[["A", "B", "D"]].astype(str).agg(",".join, axis=1)
    quadratic = smf.ols(
        "y ~ A + B + D + A:B + A:D + B:D + I(A**2) + I(B**2) + I(D**2)", table
    ).fit()
    f, p, df = smf.ols("y ~ C(cell)", table).fit().compare_f_test(quadratic)
    row = anova_table(surface).set_index("source").loc["Lack of fit"]
    assert row[["f", "p", "df"]].tolist() == pytest.approx([f, p, df], rel=1e-7)


def test_lack_of_fit_p_is_uniform_where_the_model_holds_and_small_where_not(box):
    rng = np.random.default_rng(2)
    design = box_behnken(box, centre_points=5)
    z = box.coded(box.points(design))

    def p_of(cubic):
        y = (
            30
            + z[:, 0]
            + cubic * z[:, 0] ** 2 * z[:, 1]
            + 0.3 * rng.standard_normal(len(z))
        )
        return (
            anova_table(fit_surface(design.assign(y_deg=y), "y_deg", box))
            .set_index("source")
            .loc["Lack of fit", "p"]
        )

    holds, fails = (
        np.array([p_of(0) for _ in range(300)]),
        np.array([p_of(2.0) for _ in range(30)]),
    )
    assert 0.02 < np.mean(holds < 0.05) < 0.085
    assert np.mean(fails < 0.05) > 0.8


def test_contributions_by_formula_and_as_the_paper_computed_them(surface):
    k = contributions(anova_table(surface), 3).set_index("factor")
    assert k["by_formula"].tolist() == pytest.approx([0.976, 2.226, 2.184], abs=5e-4)
    printed = {"A": "0.976", "B": "1.854", "C": "1.852"}
    assert compare(printed, k["as_paper"].to_dict())["follows"].all()
    assert compare(printed, k["by_formula"].to_dict())["follows"].tolist() == [
        True,
        False,
        False,
    ]


def test_without_repeated_points_there_is_no_lack_of_fit_row_value(runs, box, natural):
    single = runs.drop_duplicates(["A", "B", "C"])
    t = anova_table(fit_surface(natural(single), "repose_angle_deg", box)).set_index(
        "source"
    )
    assert (
        np.isnan(t.loc["Lack of fit", "f"])
        and t.loc["Pure error", "df"] == 0
        and t.loc["A", "f"] > 0
    )
