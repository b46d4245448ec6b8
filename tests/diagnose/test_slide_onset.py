"""How a block lets go: friction lost at once or over the first speeds, a plate that
shakes it loose, and what looks like them."""

import math
from dataclasses import replace

import pytest
from sliding import AIRLESS, LIGHT, found


@pytest.mark.parametrize("static", [pytest.param(0.002, marks=pytest.mark.slow), 0.006])
def test_friction_that_is_lost_at_once_is_found(static):
    """By its name, or in the class of what fades over a few mm/s, which looks the same
    where little is lost."""
    finding = found(replace(LIGHT, static=static), 1, count=4)
    assert finding.verdict in ("name", "class") and "kinetic-friction" in finding.names
    assert set(finding.names) <= {"kinetic-friction", "stribeck"}


@pytest.mark.slow
def test_friction_that_fades_over_a_few_mm_per_s_is_not_called_lost_at_once():
    """Even where the candidate of greater speeds explains less."""
    finding = found(
        replace(LIGHT, friction=lambda v, x: 0.002 * math.exp(-((v / 0.004) ** 2))),
        1,
        count=4,
    )
    assert finding.verdict == "class" and {"kinetic-friction", "stribeck"} <= set(
        finding.names
    )


@pytest.mark.slow
def test_stribeck_friction_is_found_beside_near_equals():
    """Each of them says that the block is the faster from the first moment on, and more
    of them than are fitted at a time."""
    finding = found(
        replace(
            LIGHT, friction=lambda v, x: 0.0008 * math.exp(-v / 0.008), noise_mm=0.04
        ),
        2,
    )
    assert finding.verdict in ("name", "class") and "stribeck" in finding.names
    assert set(finding.names) <= {"kinetic-friction", "stribeck"}


@pytest.mark.slow
@pytest.mark.parametrize(
    ("friction", "verdict", "names"),
    [
        (lambda v, x: 0.005 * v, "name", {"kinetic-friction", "viscous-sliding"}),
        pytest.param(lambda v, x: 0.02 * x, "unknown", set(), marks=pytest.mark.slow),
    ],
)
def test_what_friction_grows_with_is_told_beside_friction_lost_at_once(
    friction, verdict, names
):
    """About the baseline the way slid comes first, and hides what stands for it: the
    speed, at two rates."""
    bench = replace(
        AIRLESS, static=0.0015, friction=friction, rates=(1.0, 5.0), noise_mm=0.02
    )
    finding = found(bench, 3, count=4)
    assert finding.alarm and set(finding.names) <= {
        "kinetic-friction",
        "viscous-sliding",
        "adhesion",
    }
    assert finding.verdict == verdict or "kinetic-friction" in finding.names
    assert (
        names or "with the way slid to the power 1 " in finding.law
    )  # beside the friction that is lost at once


@pytest.mark.slow
def test_two_effects_are_both_named_though_the_onset_has_two_minima():
    """Begun at the baseline's onset, a fit beside a clock's offset ends at a friction
    that is greater in motion than at rest."""
    finding = found(
        replace(
            LIGHT,
            static=0.003,
            clock_s=-0.3,
            rates=(1.0, 5.0),
            fps=240.0,
            noise_mm=0.02,
        ),
        1,
        count=4,
    )
    assert finding.verdict == "name" and set(finding.names) == {
        "kinetic-friction",
        "clock-offset",
    }
    assert finding.parameters["kinetic-friction"].value == pytest.approx(0.003, rel=0.1)
    assert finding.parameters["clock-offset"].value == pytest.approx(-0.3, abs=0.1)


def test_a_vibration_is_heard():
    finding = found(replace(LIGHT, shake=(0.3, 12.0), fps=200.0), 1)
    assert (
        finding.names == ("plate-vibration",) and finding.sectors[0].name == "sliding"
    )
    parameter = finding.parameters["plate-vibration"]
    assert parameter.low95 < 0.34 and parameter.high95 > 0.26


@pytest.mark.slow
def test_a_weak_vibration_is_named_from_the_onset():
    """A ripple of 5 µm under noise of 30: the block lets go early, and is the faster
    for it."""
    quiet = replace(LIGHT, noise_mm=0.03)
    finding = found(replace(quiet, shake=(0.06, 17.0), rates=(2.0, 4.0)), 1, count=5)
    assert finding.verdict == "name" and finding.names == ("plate-vibration",)
    parameter = finding.parameters["plate-vibration"]
    assert parameter.low95 < 0.06 < parameter.high95


@pytest.mark.slow
@pytest.mark.parametrize(
    "friction",
    [
        lambda v, x: 0.006 * (1 - math.exp(-v / 0.03)),
        pytest.param(
            lambda v, x: 0.004 * math.log1p(v / 0.001), marks=pytest.mark.slow
        ),
    ],
)
def test_friction_that_grows_in_the_first_moments_is_no_vibration(friction):
    """A block that creeps is faster at first too; but what holds it goes on growing."""
    finding = found(
        replace(LIGHT, friction=friction, noise_mm=0.03, rates=(2.0, 4.0)), 1, count=5
    )
    assert finding.alarm and "plate-vibration" not in finding.names
