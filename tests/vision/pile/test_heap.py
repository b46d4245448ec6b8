"""Walls that a heap leans on, by its outline alone; angles that are hardly known."""

import numpy as np
import pytest

from benchtwin.vision.measurement import DOUBTFUL, GOOD, Quantity, failed
from benchtwin.vision.pile.heap import WALL, BaseLine, find_heap
from benchtwin.vision.pile.repose import if_known

BASE = BaseLine(300.0, 0.0, 0.0, "plate", 0.5)
WINDOW = (0.2, 0.8)


def outline(height: np.ndarray) -> np.ndarray:
    return 300.0 - height


def leaning(crest_from_wall: int) -> np.ndarray:
    """A heap of 30° on a wall at column 100 that falls a little towards the wall; rows
    of the surface of its seeds."""
    x = np.arange(600.0)
    crest, top = 100 + crest_from_wall, 160.0
    right = top - np.tan(np.radians(30)) * (x - crest)
    left = top - 0.2 * (crest - x)
    return outline(np.where(x < 100, 0.0, np.clip(np.minimum(left, right), 0.0, None)))


@pytest.mark.parametrize("crest_from_wall", [5, 45, 80])
def test_seeds_that_stand_upright_lean_on_a_wall(crest_from_wall):
    left, right = find_heap(leaning(crest_from_wall), BASE, WINDOW, walled=False).flanks
    assert left.problem == WALL and not right.problem


def test_what_may_be_the_wall_itself_is_doubted():
    """An outline that is not of seeds alone."""
    left, right = find_heap(leaning(80), BASE, WINDOW).flanks
    assert left.problem == "the surface falls at once: a wall?" and not right.problem


@pytest.mark.parametrize("layers", [3, 4, 8])
def test_the_steps_of_a_heap_of_few_layers_of_seeds_are_no_wall(layers):
    """Each layer's last seed stands upright on the next: a third of the height."""
    x, top, wide = np.arange(600.0), 150.0, 60.0
    step = top / layers
    out = np.abs(x - 300.0) - wide
    height = step * np.ceil(np.clip((top - out * 0.7) / step, 0, layers))
    heap = find_heap(outline(height), BASE, WINDOW, walled=False)
    assert [flank.problem for flank in heap.flanks] == ["", ""]


def test_a_heap_that_ends_on_bare_plate_does_not_end_above_it():
    """Its last seeds stand two fifths of the crest high; where nothing is known beyond
    them it may go on."""
    x = np.arange(600.0)
    height = 140.0 - 0.45 * np.abs(x - 300.0)
    height[height < 58.0] = 0.0
    for beyond, ends in ((0.0, False), (np.nan, True)):
        seen = outline(np.where(height > 0, height, beyond))
        heap = find_heap(seen, BASE, WINDOW, walled=False)
        assert [bool(flank.problem) for flank in heap.flanks] == [ends, ends]


def test_an_angle_known_no_better_than_five_degrees_is_doubtful():
    known = Quantity("repose_angle", 30.0, 4.9, "deg")
    assert if_known(known).quality == GOOD
    vague = if_known(Quantity("repose_angle", 43.0, 17.0, "deg"))
    assert vague.quality == DOUBTFUL and vague.reason == "known no better than ± 17°"
    refused = failed("repose_angle", "deg", "no slope")
    assert if_known(refused).reason == "no slope"
