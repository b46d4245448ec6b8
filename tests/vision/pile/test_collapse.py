"""Films of a collapse: gate and flow against drawn truth, and what cannot be told."""

from dataclasses import replace

import numpy as np
import pytest

from benchtwin.vision.measurement import DOUBTFUL, GOOD, MeasurementError
from benchtwin.vision.pile.collapse import HEIGHTS, collapse, filmed_collapse
from benchtwin.vision.pile.heap import BaseLine
from benchtwin.vision.pile.repose import Repose

WIDE, HIGH, FLOOR, GATE_X, COLUMN = 400, 150, 140.0, 100, 100.0
SEEDS, BACK, WOOD = 230, 60, 120


def test_times_are_those_of_a_closed_form():
    """Half a height passed at 0.05 + 0.4 z, filled linearly over 0.3 s from 0.1 s."""
    t = np.arange(0, 1, 0.01)
    passed = np.clip((t[:, None] - 0.05 - 0.4 * HEIGHTS) / 0.02 + 0.5, 0, 1)
    found = collapse(t, np.clip((t - 0.1) / 0.3, 0, 1), passed)
    assert found.gate_s == pytest.approx(0.4, rel=1e-6)
    assert found.flow_s == pytest.approx(0.15, rel=1e-6)
    assert found.steady_s < 1e-9 and not found.late
    assert [q.quality for q in found.quantities()] == [GOOD, GOOD]


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ({"steady_s": 0.1}, "did not rise steadily"),
        ({"gate_s": 0.003}, "up before the next frame"),
        ({"late": True}, "begins after"),
    ],
)
def test_what_a_film_does_not_tell_is_doubted(change, says):
    t = np.arange(0, 1, 0.02)
    passed = (t[:, None] > 0.4 * HEIGHTS + 0.1).astype(float)
    usual = collapse(t, np.clip(t / 0.3, 0, 1), passed)
    assert usual.quantities()[0].quality == GOOD
    gate = replace(usual, **change).quantities()[0]
    assert gate.quality == DOUBTFUL and says in gate.reason


def heap(mirror: bool) -> Repose:
    """A flank of 45 px at the gate that leans on the left wall, or on the right."""
    x = np.arange(WIDE)
    surface = FLOOR - np.clip(60 - 0.15 * x, 0, None)
    toe, crest = (None, 399.0), (0.0, FLOOR - 60)
    if mirror:
        surface, toe, crest = surface[::-1], (0.0, None), (WIDE - 1.0, FLOOR - 60)
    base = BaseLine(FLOOR, 0.0, 0.0, "plate", 0.0)
    hidden = np.zeros(WIDE, bool)
    roi = (0, 0, WIDE, HIGH)
    return Repose(surface, hidden, base, 0.0, crest, toe, (), (0.2, 0.8), roi, (), ())


def film(rise_s: float, flow_s: float, fps: float, mirror: bool, noise: float = 3.0):
    """Behind a rising gate a column sinks to the heap's surface, whose part beyond the
    gate fills outwards, and no higher than the gate's edge."""
    x, rows = np.arange(WIDE), np.arange(HIGH)[:, None]
    height, t = FLOOR - rows, np.arange(0, 1.2, 1 / fps)
    end = np.clip(60 - 0.15 * x, 0, None)
    inside, rng, frames = x < GATE_X, np.random.default_rng(0), []
    for now in t:
        edge = COLUMN * (now - 0.1) / rise_s
        reach = np.clip((now - 0.1) / flow_s, 0, 1)
        top = COLUMN + (end - COLUMN) * reach
        filled = (height < np.minimum(end, edge)) & (x < GATE_X + 300 * reach)
        seeds = np.where(inside, height < top, filled) & (height > 0)
        wood = (x >= GATE_X) & (x < GATE_X + 6) & (height > max(edge, 0)) & ~seeds
        picture = np.where(seeds, SEEDS, np.where(wood, WOOD, BACK))
        frames.append(picture + rng.normal(0, noise, picture.shape))
    grey = np.clip(frames, 0, 255).astype(np.uint8)
    return t, grey[:, :, ::-1] if mirror else grey


@pytest.mark.parametrize("mirror", [False, True])
@pytest.mark.parametrize("rise_s", [0.15, 0.6])
def test_the_gate_and_the_flow_of_a_drawn_film_are_found(rise_s, mirror):
    """Within 2 sd of the drawn rise; the flow within 2 sd of what the drawing fills."""
    t, grey = film(rise_s, 0.8, 60.0, mirror)
    found = filmed_collapse(t, grey, heap(mirror), 1, 0).collapse
    assert abs(found.gate_s - rise_s) < 2 * found.gate_sd_s
    x = np.arange(GATE_X, WIDE)
    end = np.clip(60 - 0.15 * x, 0, None) * (60 - 0.15 * x > 15)
    reach = np.clip((t[:, None] - 0.1) / 0.8, 0, 1)
    edge = np.clip(COLUMN * (t[:, None] - 0.1) / rise_s, 0, None)
    area = (np.minimum(end, edge) * (x < GATE_X + 300 * reach)).sum(axis=1) / end.sum()
    quarter, most = (t[np.argmax(area > share)] for share in (0.25, 0.75))
    assert found.flow_s == pytest.approx(most - quarter, abs=1 / 60)


def test_a_film_that_begins_late_is_known():
    t, grey = film(0.6, 0.8, 60.0, False)
    assert not filmed_collapse(t, grey, heap(False), 1, 0).collapse.late
    later = filmed_collapse(t[18:], grey[18:], heap(False), 1, 0).collapse
    assert later.late


def test_films_without_gate_seeds_or_clock_say_so():
    t, grey = film(0.3, 0.8, 60.0, False)
    still = np.repeat(grey[-1:], len(t), axis=0)
    free = replace(heap(False), toes=(3.0, 399.0))
    for times, pictures, found, says in (
        (t, still, heap(False), "no seeds run out"),
        (t, grey, free, "no gate"),
        (t * np.nan, grey, heap(False), "camera.fps"),
    ):
        with pytest.raises(MeasurementError, match=says):
            filmed_collapse(times, pictures, found, 1, 0)
