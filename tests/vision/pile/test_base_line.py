"""The line that a heap stands on, by drawn masks of one."""

import numpy as np
import pytest

from benchtwin.vision.pile.base_line import BaseLine, foot_line
from benchtwin.vision.pile.surface import Edges, borders
from benchtwin.vision.recording import Camera

FOOT, WIDE, TALL = 300, 400, 130  # px


def mask(leaning: bool, foot: np.ndarray, roll: float = 0.0) -> np.ndarray:
    """A heap between the columns 40 and 440, on a wall at its right end or round, above
    the rows `foot` (400,); its rim is as rough as the seeds are."""
    rng = np.random.default_rng(5)
    u = (np.arange(WIDE) - (WIDE if leaning else WIDE / 2)) / WIDE
    height = TALL * (1 - (1.0 if leaning else 2.0) * np.abs(u))
    rough = np.repeat(rng.normal(0, 0.8, WIDE // 8), 8)
    lower = foot + rough + roll * np.arange(WIDE)
    upper = FOOT - height + rough[::-1] + roll * np.arange(WIDE)
    rows = np.arange(420)[:, None]
    drawn = np.zeros((420, WIDE + 80), bool)
    drawn[:, 40 : 40 + WIDE] = (rows >= upper) & (rows < lower)
    return drawn


def foot_of(drawn: np.ndarray) -> BaseLine | None:
    return foot_line(Edges(*borders(drawn), 1.0), Camera(), len(drawn))


def bow(leaning: bool, pitch_deg: float) -> np.ndarray:
    """Near half of the ellipse that the foot of a cone, or of half of one, is."""
    u = np.arange(WIDE) / WIDE - 1 if leaning else 2 * np.arange(WIDE) / WIDE - 1
    half = WIDE if leaning else WIDE / 2
    return FOOT + half * np.sin(np.radians(pitch_deg)) * np.sqrt(1 - u**2)


@pytest.mark.parametrize("roll_deg", [0.0, 1.0])
def test_the_lifted_end_of_a_run_out_is_no_bow(roll_deg):
    """An eighth of the edge curls up: to 2 px, a half of which the rim's roughness is,
    and told to be seen."""
    curl = np.clip(50 - np.arange(WIDE), 0, None)
    slope = np.tan(np.radians(roll_deg))
    base = foot_of(mask(True, FOOT - 0.4 * curl, slope))
    assert base.source == "foot" and not base.doubt
    assert base.at(240) == pytest.approx(FOOT + slope * 200, abs=2.0)
    assert base.pitch_deg < 1.0
    assert np.degrees(np.arctan(base.slope)) == pytest.approx(roll_deg, abs=0.4)


@pytest.mark.parametrize("leaning", [True, False])
@pytest.mark.parametrize("pitch_deg", [6.0, 15.0])
def test_a_bowed_foot_tells_by_how_much_the_camera_looks_down(leaning, pitch_deg):
    """Also of half a heap, whose ellipse has its middle at the wall."""
    base = foot_of(mask(leaning, bow(leaning, pitch_deg)))
    assert base.pitch_deg == pytest.approx(pitch_deg, abs=1.0)
    assert base.at(240) == pytest.approx(FOOT, abs=3 * base.sd)
    assert base.source == "foot" or leaning


def test_a_heap_and_its_mirror_image_stand_on_the_line_between():
    whole = mask(False, np.full(WIDE, FOOT))
    both = whole | np.roll(whole[::-1], 2 * FOOT - 420, axis=0)
    base = foot_of(both)
    assert base.source == "mirror" and not base.pitch_deg
    assert base.at(240) == pytest.approx(FOOT, abs=1.0)


def test_a_foot_at_the_pictures_border_is_not_seen():
    cut = mask(True, np.full(WIDE, FOOT))[: FOOT - 20]
    assert foot_of(cut).source == "toe"
