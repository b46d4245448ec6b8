"""A box in one end of a channel: how it is seen and calibrated."""

import numpy as np
import pytest

from benchtwin.rigs.pile.tells import slice_of, whole_plate
from benchtwin.sim.picture import project
from benchtwin.twin.paths import like
from benchtwin.twin.scene import camera_of, rig_of
from benchtwin.vision.pile.repose import PileOptions, rig_options

CHANNEL = {"box_mm": [60.0, 25.0, 100.0], "channel_mm": [400.0, 25.0]}


def test_all_of_a_channel_is_in_its_picture():
    recording = like("pile", {"pile": CHANNEL})
    camera = camera_of(recording)
    ends = project(camera, np.array([[0.0, 0.0, 0.0], [0.4, 0.0, 0.1]]))
    assert (ends > 0).all()
    assert (ends < [camera.width_px, camera.height_px]).all()
    assert rig_of(recording).plate_m == (0.4, 0.025)


def test_what_is_not_stated_beside_a_channel_is_as_wide_as_it():
    rig = rig_of(like("pile", {"pile": {"channel_mm": [400.0, 25.0]}}))
    assert rig.box_m[1] == rig.gate_m[0] == rig.plate_m[1] == 0.025


@pytest.mark.parametrize(
    "stated", [{"plate_mm": [300.0, 25.0]}, {"box_mm": [60.0, 40.0, 100.0]}]
)
def test_what_is_stated_against_a_channel_is_refused(stated):
    with pytest.raises(ValueError, match="channel_m"):
        rig_of(like("pile", {"pile": CHANNEL | stated}))


def test_a_channel_is_calibrated_as_it_is_and_other_boxes_by_a_slice():
    told, notes = slice_of(CHANNEL, 30.0, 60.0)
    assert told == CHANNEL and not notes
    assert whole_plate(CHANNEL)["mm_per_px"] == pytest.approx(420 / 1600)
    other, notes = slice_of({"box_mm": CHANNEL["box_mm"]}, 30.0, 60.0)
    assert other["slab"] and notes


@pytest.mark.parametrize(
    ("pile", "side"), [(CHANNEL, ""), ({"box_mm": CHANNEL["box_mm"]}, "right")]
)
def test_a_channel_may_be_filmed_from_either_side(pile, side):
    assert rig_options(like("pile", {"pile": pile}), PileOptions()).side == side


def test_heaps_of_plain_seeds_are_simulated_as_others():
    stated = {"fill_height_mm": 80.0}
    known = rig_of(like("pile", {"pile": stated | {"plain": True}}))
    assert known == rig_of(like("pile", {"pile": stated}))
