"""Angles that somebody read off, and stairs of the tilt that a column or readings show
by themselves."""

import math
from dataclasses import replace

import numpy as np
import pytest
from sliding import LIGHT, G, found, readings

from benchtwin.rigs.slide.diagnose import diagnose_slide
from benchtwin.rigs.slide.tilt import seen_tilt


@pytest.mark.slow
def test_a_stepped_plate_is_separated_from_a_rounded_column():
    """The block moves evenly between climbs; as a control it moves as on an even climb,
    and the column alone is on a grid."""
    climbs = found(replace(LIGHT, step_deg=0.5), 1)
    assert climbs.names == ("stepped-tilt",) and climbs.sectors[0].name == "measurement"
    assert climbs.parameters["stepped-tilt"].value == pytest.approx(0.5, abs=0.01)
    assert "stepped-tilt" not in found(replace(LIGHT, rounded_deg=0.5), 1).names


def test_a_noisy_or_finely_resolved_column_is_no_staircase():
    t = np.arange(0, 4, 0.01)
    ramp = 15 + 2 * t
    noisy = ramp + np.random.default_rng(1).normal(0, 0.1, len(t))
    assert seen_tilt(t, noisy, 3.0, 4.0).grid_deg == 0
    assert seen_tilt(t, np.round(ramp, 1), 3.0, 4.0).grid_deg == 0
    assert seen_tilt(t, np.ceil(ramp / 0.4) * 0.4, 3.0, 4.0).grid_deg == pytest.approx(
        0.4, rel=0.01
    )


def angle_read(delay_mm=0.0, clock_s=0.0, pull=0.0, grid=0.0):
    """Reader of an angle: small steps until the block has moved by `delay_mm`."""

    def read(rate, count, rng):
        mu, omega, weight, dt = (
            0.4 + rng.normal(0, 0.003),
            math.radians(rate),
            0.234e-3 * count,
            2e-3,
        )
        t, x, v = 0.3 / omega, 0.0, 0.0
        while x <= 1e-3 * delay_mm:
            a = G * math.sin(omega * t) - mu * (G * math.cos(omega * t) + pull / weight)
            if a > 0 or v > 0:
                v += a * dt
                x += v * dt
                if not delay_mm:
                    break
            t += dt
        angle = math.degrees(omega * t) - rate * clock_s + rng.normal(0, 0.03)
        return math.ceil(angle / grid) * grid if grid else angle

    return read


def told(reader, rates, counts, **more):
    rng = np.random.default_rng(4)
    return diagnose_slide(readings(reader, rates, counts, 8, rng, **more), rng)


def test_readings_of_several_rates_and_loads():
    """Overshoot as the rate to the 2/3, as the rate, or as one over the load."""
    late = told(angle_read(delay_mm=5.0), (1, 3, 10), (4, 4, 4))
    assert late.names[0] == "reading-delay" and late.verdict in ("name", "class")
    size = late.effects["reading-delay"].size
    assert size.low95 < 5 < size.high95
    assert late.sectors[0].name == "measurement"
    soon = told(
        angle_read(delay_mm=0.2), (0.5, 2, 5), (4, 4, 4)
    )  # the overshoot's slope has no bound at a travel of nil
    assert soon.verdict in ("name", "class") and "reading-delay" in soon.names
    off = told(angle_read(clock_s=-0.2), (1, 3, 10), (4, 4, 4))
    assert "clock-offset" in off.names and off.verdict in ("name", "class")
    pulled = told(angle_read(pull=0.3e-3), (2, 2, 2), (1, 2, 4))
    assert pulled.names == ("adhesion",) and pulled.parameters[
        "adhesion"
    ].value == pytest.approx(0.3, abs=0.05)
    assert told(angle_read(), (1, 3, 10), (1, 2, 4)).verdict == "none"
    grid = told(angle_read(grid=0.5), (2, 2, 2), (4, 4, 4))
    assert grid.verdict == "none" and any("read to 0.5°" in note for note in grid.notes)


def test_one_rate_or_one_load_names_neither_delay_nor_pull():
    """Exact twins of friction itself."""
    assert told(angle_read(delay_mm=5.0), (2, 2, 2), (4, 4, 4)).verdict == "none"
    assert told(angle_read(pull=0.3e-3), (2, 2, 2), (4, 4, 4)).verdict == "none"
    assert (
        told(angle_read(pull=0.3e-3), (2, 2, 2), (1, 2, 4), masses=False).verdict
        != "name"
    )
