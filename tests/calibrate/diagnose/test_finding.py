"""What a finding says beside its verdict."""

from dataclasses import replace

import numpy as np
import pytest

from calibrate.diagnose.decide import Verdict
from calibrate.diagnose.effects.drop import EFFECTS
from calibrate.diagnose.finding import credited
from calibrate.diagnose.linear import Reduced
from calibrate.diagnose.locate import Location, Sector
from calibrate.diagnose.problem import Problem, fit

SEEN = 20.0  # of drag, in sds


def problem() -> Problem:
    """One recording of one number, which drag changes by one sd a unit."""

    def reduce(starts, values, extra=None):
        return (Reduced(np.array([[1.0]]), np.zeros((1, 0)), np.array([SEEN])),), lambda moved: np.zeros((1, 0))

    drag = replace(EFFECTS["drag"], prior_sd=1e3)
    return Problem("drop", ("one",), {"drag": drag}, ("drag",), {}, np.zeros((1, 0)), reduce, 1, 0.0, None)


def located() -> Location:
    sectors = (Sector("measurement", 0.8, 1e-9), Sector("flight", 0.3, 1e-3))
    return Location(sectors=sectors, excess=SEEN**2 - 1, p=1e-9, window=None, collapse="")


def verdict(kind: str) -> Verdict:
    return Verdict(kind, ("drag",), 1e-9, (), 9.0, None)


def test_a_named_law_has_the_share_of_the_excess_that_its_own_fit_takes():
    base = fit(problem())
    told = credited(located(), base, verdict("name"))
    assert [s.name for s in told.sectors] == ["flight", "measurement"]
    assert told.sectors[0].explained == pytest.approx((SEEN**2 - 2) / (SEEN**2 - 1), abs=1e-3)
    assert told.sectors[1] == located().sectors[0]


def test_what_is_no_definite_name_takes_no_share():
    base = fit(problem())
    assert credited(located(), base, verdict("class")) == located()
