"""A weight that turns about a plate that stands still: no news, and at one rate no proof of friction that grows with speed."""

from dataclasses import replace

import numpy as np
import pytest
from sliding import AIRLESS, LIGHT, found, slides

from calibrate.diagnose.slide import diagnose
from calibrate.diagnose.slide.model import Model, candidates
from calibrate.diagnose.slide.problem import prepare
from calibrate.diagnose.slide.session import assemble


def test_a_weight_that_turns_about_a_still_plate_is_no_news():
    """Beside a plate that turns it has no Coriolis acceleration, which looks like friction that grows with speed."""
    still = replace(LIGHT, turns=False, hinge_stated=False, rates=(2.0, 6.0), noise_mm=0.02)
    finding = found(still, 1, count=2)  # one at each rate
    assert finding.verdict == "none" and any("stands still" in note for note in finding.notes)
    assert found(replace(still, hinge_stated=True), 1, count=2).alarm


@pytest.mark.parametrize(
    ("turns", "grows", "verdict", "names"),
    [
        (False, 0.0, "class", {"kinetic-friction", "viscous-sliding"}),
        (True, 0.0, "name", {"kinetic-friction"}),
        (True, 0.1, "name", {"kinetic-friction", "viscous-sliding"}),
    ],
)
def test_what_a_plate_that_turns_and_one_that_stands_still_call_by_two_names_is_a_class(turns, grows, verdict, names):
    """At one rate a plate's turning is friction that grows with speed: that it takes no parameter is no proof of it."""
    bench = replace(AIRLESS, turns=turns, hinge_stated=False, rates=(4.0,), static=0.01, noise_mm=0.02)
    prepared = prepare(assemble(slides(replace(bench, friction=lambda v, x: grows * v), 2, np.random.default_rng(1))))
    few = {
        n: e for n, e in candidates(prepared.session).items() if n in ("kinetic-friction", "viscous-sliding", "plate-vibration")
    }
    told = diagnose._told(diagnose.fitted(prepared, Model(prepared.session, 0.0, few)), np.random.default_rng(0))
    finding = diagnose._or_still(prepared, told, False, np.random.default_rng(0)).verdict
    assert finding.verdict == verdict and set(finding.names) == names
    assert ("start_mm" in (finding.next_record or "")) == (verdict == "class")


def test_what_is_unknown_on_a_plate_that_turns_has_its_name_on_one_that_stands_still():
    """A clock off by 0.4 s at one rate: its class, for all that the missing turn is friction nobody knows."""
    bench = replace(AIRLESS, turns=False, hinge_stated=False, rates=(4.0,), clock_s=0.4, noise_mm=0.02)
    finding = found(bench, 1, count=3)
    assert finding.verdict == "class" and {"clock-offset", "angle-offset"} <= set(finding.names)
