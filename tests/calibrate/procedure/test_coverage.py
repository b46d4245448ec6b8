"""The pile posterior over many designs and benches (benchmarks/loop_coverage.py): it
holds the truth as often as it says."""

import pytest
from loop_coverage import rates, study


def _rates(designs, benches, **case):
    table = rates(study(designs, benches, seed=1, **case)).set_index(["set", "level"])[
        "rate"
    ]
    parameters = [n for n in table.index.levels[0] if n != "joint"]
    return table, {
        level: table[[(n, level) for n in parameters]].mean() for level in (0.5, 0.95)
    }


@pytest.mark.slow
def test_a_few_posteriors_hold_the_truth_as_often_as_they_say():
    """96 benches on 12 designs; benches of one design are alike, so that chance alone
    moves a rate by 4 % (95) and 6 % (50)."""
    table, mean = _rates(12, 8, bend=0.0, quiet=1.0)
    assert (
        mean[0.95] >= 0.89
        and table["joint", 0.95] >= 0.89
        and 0.36 <= mean[0.5] <= 0.64
    )


@pytest.mark.slow
@pytest.mark.parametrize(
    ("bend", "quiet"), [(0.0, 1.0), (0.3, 1.0), (0.0, 4.0), (0.1, 4.0)]
)
def test_posteriors_hold_the_truth_as_often_as_they_say(bend, quiet):
    table, mean = _rates(60, 8, bend=bend, quiet=quiet)
    assert (
        0.92 <= mean[0.95] <= 0.985
        and table["joint", 0.95] >= 0.92
        and 0.44 <= mean[0.5] <= 0.62
    )
