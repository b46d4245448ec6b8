"""What is believed of what a recording does not state: complete, and the same for both
that read it."""

import pytest
from benchtwin.bench.keys import Camera
from benchtwin.bench.priors import PRIORS, stated_sd, unstated_sd
from benchtwin.rigs.slide import problem
from benchtwin.rigs.slide.tilt import stated_tilt


def test_every_prior_has_a_unit_a_source_and_an_sd():
    for name, prior in PRIORS.items():
        assert prior.unit and prior.source, name
        sds = [sd for sd in (prior.unstated, prior.stated) if sd is not None]
        assert sds and all(sd > 0 for sd in sds), name


def test_what_has_to_be_stated_has_no_sd_without():
    with pytest.raises(KeyError, match="tilt-rate has to be stated"):
        unstated_sd("tilt-rate")
    with pytest.raises(KeyError, match="cannot be stated"):
        stated_sd("lens")


def test_measuring_and_diagnosing_read_the_same_scale():
    assert Camera(mm_per_px=0.2).scale_sd == problem.PRIORS["scale"]


def test_an_error_of_the_rate_moves_the_angle_since_t_0():
    """1 % of 2 °/s for 10 s: 0.2°, beside the 0.5° of the angle at t = 0."""
    tilt = stated_tilt(2.0, 5.0, 0.5, 10.0)
    assert 57.29578 * tilt.level_sd == pytest.approx((0.5**2 + 0.2**2) ** 0.5, rel=1e-4)
