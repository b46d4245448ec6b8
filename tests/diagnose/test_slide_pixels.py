"""Places that a tracker reads too far towards pixel centres: no news, and no vibration
of the plate."""

from dataclasses import replace

import numpy as np
import pytest
from sliding import LIGHT, slides

from benchtwin.infer.problem import fit
from benchtwin.rigs.slide.diagnose import alternatives, diagnose_slide
from benchtwin.rigs.slide.model import OWN
from benchtwin.rigs.slide.problem import prepare
from benchtwin.rigs.slide.session import assemble

SHARP = replace(
    LIGHT,
    fps=240.0,
    rates=(1.0,),
    noise_mm=0.008,
    rho=0.0,
    white=1.0,
    mm_per_px=0.2,
    travel_mm=40.0,
)


def fit_of(seen):
    return fit(alternatives(prepare(assemble(seen)), None)[0].problem)


@pytest.mark.parametrize("sign", [1.0, pytest.param(-1.0, marks=pytest.mark.slow)])
def test_slides_with_a_pixel_lock_are_clean(sign):
    seen = slides(replace(SHARP, lock_px=0.05, sign=sign), 3, np.random.default_rng(1))
    finding = diagnose_slide(seen, np.random.default_rng(0))
    assert finding.verdict == "none" and not finding.alarm


@pytest.mark.parametrize("lock_px", [0.0, 0.05])
def test_the_lock_is_measured_wherever_a_recording_counts_its_places_from(lock_px):
    """Three runs, counted from where the first pixel is cut in the middle, at its edge,
    and at a quarter."""
    seen = slides(replace(SHARP, lock_px=lock_px), 3, np.random.default_rng(3))
    from_px = np.array([0.0, 0.5, 0.25])
    base = fit_of(
        [
            replace(s, x_mm=s.x_mm + SHARP.mm_per_px * part)
            for s, part in zip(seen, from_px, strict=True)
        ]
    )
    waves = base.starts[:, OWN.index("sine") : OWN.index("hinge")] @ [
        1.0,
        1j,
    ]  # A + iB, of A sin φ + B cos φ
    np.testing.assert_allclose(
        waves * np.exp(2j * np.pi * from_px), lock_px, atol=0.01
    )  # sds of .003 each way
