"""A ball before a grey wall, while an arm beside it takes its shadow away: the light of
a part of the picture changes slowly over places, and is neither noise nor a thing."""

import numpy as np
import pytest

from benchtwin.vision.motion.detect import find_silhouettes
from benchtwin.vision.motion.scene import learn_scene, light_of

HIGH, WIDE, RADIUS = 300, 400, 14.0
FRAMES = 60


def filmed(shaded: float) -> list[np.ndarray]:
    """Frames (h, w, 3): a light ball that falls and rises over the right half, a shadow
    that darkens the left by `shaded` at first and fades."""
    rng = np.random.default_rng(4)
    y, x = np.mgrid[:HIGH, :WIDE].astype(float)
    shadow = 1 / (1 + np.exp((x - 150) / 30))
    out = []
    for k in range(FRAMES):
        light = 1 - shaded * shadow * max(1 - k / 30, 0)
        cover = np.clip(RADIUS + 0.5 - np.hypot(x - 260, y - place(k)), 0, 1)
        grey = 190 * light * (1 - cover) + 212 * light * cover
        noise = 1.5 * rng.standard_normal((HIGH, WIDE, 3))
        out.append(np.clip(grey[..., None] + noise, 0, 255).astype(np.uint8))
    return out


def place(k: int) -> float:
    """Of its centre, px down."""
    return 40 + 220 * abs(1 - k / 30)


class Film:
    """As a FrameSource gives frames."""

    path = "film"

    def __init__(self, frames):
        self.frames = frames

    def sample(self, count):
        return self.frames[:: max(1, len(self.frames) // count)]


@pytest.mark.parametrize("shaded", [0.0, 0.35])
def test_a_ball_is_found_whatever_shades_a_part_of_the_picture(shaded):
    frames = filmed(shaded)
    scene = learn_scene(Film(frames))
    for k in range(2, FRAMES - 2, 5):
        found = find_silhouettes(frames[k], scene)
        near = [s for s in found if np.hypot(s.x - 260, s.y - place(k)) < 1.0]
        assert len(near) == 1, (k, [(s.x, s.y) for s in found])
        assert near[0].area == pytest.approx(np.pi * RADIUS**2, rel=0.1)


def test_the_light_of_a_part_is_told_and_a_seed_is_none():
    y, x = np.mgrid[:240, :320].astype(float)
    shade = 1 - 0.3 / (1 + np.exp((x - 80) / 20))
    coarse = np.full((240, 320, 3), 150.0, np.float32)
    seen = (coarse * shade[..., None]).astype(np.float32)
    seen[(x - 240) ** 2 + (y - 120) ** 2 < 30**2] = 40.0
    light = light_of(seen, coarse)
    assert light[:, 5:40] == pytest.approx(shade[:, 5:40], abs=0.05)
    assert light[100:140, 220:260] == pytest.approx(1.0, abs=0.02)
    assert light_of(0.9 * coarse, coarse) == pytest.approx(0.9, abs=0.01)
