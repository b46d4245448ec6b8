"""Standard deviations that nobody can know, or mean, are said and not followed."""

import pytest

from benchtwin.bench.keys import Camera
from benchtwin.bench.priors import PRIORS
from benchtwin.rigs.drop.keys import Drop


@pytest.mark.parametrize(("stated", "used"), [(1e-9, 1e-4), (0.002, 0.002), (7.0, 0.5)])
def test_a_scale_is_known_within_what_anybody_can_know(stated, used):
    camera = Camera(mm_per_px=0.2, mm_per_px_sd=0.2 * stated)
    assert camera.scale_sd == pytest.approx(used)
    said = camera.sds_beyond_belief()
    assert bool(said) == (stated != used)
    assert all("mm_per_px_sd" in line and f"{0.2 * used:.2g}" in line for line in said)


def test_plumb_lines_and_heights_likewise_and_what_is_absent_is_not_said():
    assert Camera().sds_beyond_belief() == []
    assert Camera(plumb_sd_deg=0.0).plumb_sd == PRIORS["plumb"].possible[0]
    assert len(Camera(plumb_sd_deg=1e9).sds_beyond_belief()) == 1
    assert Drop(height_sd_mm=1e-9).height_sd == PRIORS["release-height"].possible[0]
    assert Drop(height_sd_mm=1.0).sds_beyond_belief() == []
