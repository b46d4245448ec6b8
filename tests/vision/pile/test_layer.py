"""A layer of seeds beside a heap, drawn as a profile whose flank is known."""

import numpy as np
import pytest

from benchtwin.vision.pile.heap import BaseLine
from benchtwin.vision.pile.layer import without_layer

TALL, FOOT, MIDDLE, WIDTH = 200.0, 300.0, 500, 1001
SLOPE = np.tan(np.radians(30))


def profile(height: np.ndarray, seed: int = 0) -> np.ndarray:
    """Rows [px, y down] of heights with the roughness of grains of 10 px."""
    rng = np.random.default_rng(seed)
    rough = np.convolve(rng.normal(0, 8, WIDTH + 9), np.ones(10) / 10, "valid")
    return FOOT - np.where(height > 0, np.clip(height + rough, 0, None), 0.0)


def bare() -> tuple[np.ndarray, np.ndarray]:
    """Columns' distance from the axis, and a straight heap."""
    out = np.abs(np.arange(WIDTH) - MIDDLE).astype(float)
    return out, TALL - SLOPE * out


@pytest.mark.parametrize("pitch_deg", [0.0, 5.0])
@pytest.mark.parametrize("thick", [10.0, 25.0])
def test_the_flank_is_led_on_under_a_layer(thick, pitch_deg):
    """Seen level, and with the layer's far rim above the plate's middle."""
    out, heap = bare()
    reach = 460.0
    rim = np.sqrt(np.clip(1 - (out / reach) ** 2, 0, None))
    layer = np.where(
        out < reach, thick + reach * np.sin(np.radians(pitch_deg)) * rim, 0.0
    )
    seen = profile(np.maximum(np.clip(heap, 0, None), layer))
    found, sides = without_layer(seen, BaseLine(FOOT, 0.0, 0.0, "foot", 0.5, pitch_deg))
    assert sides == ("left", "right")
    assert FOOT - found == pytest.approx(np.clip(heap, 0, None), abs=12)
    lowest = (heap > 1) & (heap < thick)
    slope = np.polyfit(out[lowest], FOOT - found[lowest], 1)[0]
    assert -slope == pytest.approx(SLOPE, abs=0.03)


def test_what_is_no_layer_stays_as_it_is():
    """A straight heap; one whose foot is less steep; two seeds at its foot; none."""
    out, heap = bare()
    bent = np.where(heap > 80, heap, 80 - 0.6 * SLOPE * (out - (TALL - 80) / SLOPE))
    foot = TALL / SLOPE
    seeds = np.where((out > foot - 20) & (out < foot + 40), 25.0, 0.0)
    below = np.full(WIDTH, -10.0)
    for height in (heap, bent, np.maximum(heap, seeds), below):
        seen = profile(np.clip(height, 0, None))
        found, sides = without_layer(seen, BaseLine(FOOT, 0.0, 0.0, "foot", 0.5))
        assert sides == () and found == pytest.approx(seen)
