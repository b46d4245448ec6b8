"""Places that a tracker reads too far towards pixel centres: no news, and no vibration of the plate."""

from dataclasses import replace

import numpy as np
import pytest
from sliding import LIGHT, slides

from calibrate.diagnose.slide.diagnose import diagnose_slide, fitted
from calibrate.diagnose.slide.model import Model, candidates
from calibrate.diagnose.slide.pixels import LOCKS
from calibrate.diagnose.slide.problem import prepare
from calibrate.diagnose.slide.session import assemble

SHARP = replace(LIGHT, fps=240.0, rates=(1.0,), noise_mm=0.008, rho=0.0, white=1.0, mm_per_px=0.2, travel_mm=40.0)


def fit_of(seen):
    prepared = prepare(assemble(seen))
    return fitted(prepared, Model(prepared.session, 0.0, candidates(prepared.session)))


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_slides_with_a_pixel_lock_are_clean(sign):
    seen = slides(replace(SHARP, lock_px=0.05, sign=sign), 3, np.random.default_rng(1))
    finding = diagnose_slide(seen, np.random.default_rng(0))
    assert finding.verdict == "none" and not finding.alarm


@pytest.mark.parametrize("lock_px", [0.0, 0.05])
def test_the_lock_is_measured(lock_px):
    base = fit_of(slides(replace(SHARP, lock_px=lock_px), 3, np.random.default_rng(3)))
    for name, true in zip(LOCKS, (lock_px, 0.0), strict=True):
        assert abs(base.by_name[name] - true) < 3 * base.sd(name) and base.sd(name) < 0.005
