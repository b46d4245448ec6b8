"""What is followed is held against the seed's stated size."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from benchtwin.vision.motion.film_doubts import size_doubt, stated_area_px
from benchtwin.vision.motion.track import make_track
from benchtwin.vision.motion.track_seed import TrackedSeed
from benchtwin.vision.recording import Camera, Recording, Seed

BALL = Seed(length_mm=8.0, width_mm=8.0, thickness_mm=8.0)
AREA = np.pi * 10.0**2  # a ball of 8 mm at 0.4 mm a pixel


def roll(seed=BALL):
    return Recording(
        id="a",
        path=Path("a"),
        rig="roll",
        evidence="video",
        files=(),
        camera=Camera(mm_per_px=0.4),
        seed=seed,
    )


def followed(area, outlier=()):
    x = np.concatenate([np.linspace(0, 300, 60), np.full(20, 300.0)])
    track = make_track(
        None, x, np.zeros(80), unit="px", outlier=np.isin(np.arange(80), outlier)
    )
    scene: Any = None  # nothing looks at it
    return TrackedSeed(
        track, scene, 20.0, np.broadcast_to(np.asarray(area, float), (80,))
    )


def test_the_seed_itself_is_not_doubted():
    assert stated_area_px(roll()) == pytest.approx((AREA, AREA))
    assert size_doubt(followed(AREA), roll()) == ""


@pytest.mark.parametrize("share, said", [(0.5, "at least"), (1.6, "at most")])
def test_half_a_seed_and_a_seed_with_its_shadow_are_doubted(share, said):
    assert said in size_doubt(followed(share * AREA), roll())
    assert (
        size_doubt(followed(share * AREA), roll(Seed())) == ""
    )  # nobody said how large it is


def test_what_grows_when_it_rests_is_doubted():
    area = np.where(np.arange(80) < 60, AREA, 1.6 * AREA)
    assert "at rest" in size_doubt(followed(area), roll())


def test_a_seed_often_hidden_is_doubted():
    assert "hidden or merged in" not in size_doubt(followed(AREA, range(3)), roll())
    assert "20 %" in size_doubt(followed(AREA, range(12)), roll())


def test_an_oblong_seed_may_show_any_side():
    oblong = Seed(length_mm=12.0, width_mm=8.0, thickness_mm=6.0)
    assert (
        size_doubt(followed(0.8 * AREA), roll(oblong))
        == size_doubt(followed(1.4 * AREA), roll(oblong))
        == ""
    )
