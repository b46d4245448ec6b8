"""What is believed of what a recording does not state: complete, and the same for both
that read it."""

from pathlib import Path

import pandas as pd
import pytest

from benchtwin.bench.keys import Camera
from benchtwin.bench.priors import PRIORS, stated_sd, unstated_sd
from benchtwin.rigs.slide import problem
from benchtwin.rigs.slide.tilt import stated_tilt

TABLES = Path(__file__).parents[1] / "benchmarks" / "tables"


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


LEARNT = pd.read_csv(TABLES / "learnt_priors.csv").set_index("prior")
LEAST = {"friction-scatter", "friction-within-run", "bounce-scatter"}


@pytest.mark.parametrize("name", LEARNT.index)
def test_what_public_recordings_tell_agrees(name):
    """`benchmarks/learn_priors.py` made the table. Of the scatter of a lot the prior is
    the least that there is, since each bench tells its own."""
    prior, learnt = PRIORS[name], LEARNT.loc[name]
    believed = prior.stated if prior.unstated is None else prior.unstated
    assert believed == learnt.believed
    assert believed < learnt.high95 and (name in LEAST or believed > learnt.low95)
