"""Heaps as pictures, through the measuring code."""

from dataclasses import replace

import numpy as np
import pytest
from heaping import PX_MM, Heap, changed, photograph, picture

from benchtwin.rigs.pile.diagnose import diagnose_pile
from benchtwin.rigs.pile.flanks import photo_of
from benchtwin.rigs.pile.read import SeenPile, read_piles

BENCH = Heap(grain_mm=3.0)


def test_pictures_of_a_leaning_plate(tmp_path):
    rng = np.random.default_rng(9)
    for k in range(3):
        photograph(changed(BENCH, tilt_deg=3.0), rng, tmp_path / f"pile-{k}")
    seen = read_piles(tmp_path)
    assert [s.trouble for s in seen] == [""] * 3 and {s.unit for s in seen} == {"mm"}
    found = diagnose_pile(seen, rng)
    assert found.names == ("base-tilt",) and found.parameters[
        "base-tilt"
    ].value == pytest.approx(3.0, abs=0.3)


def test_pictures_of_sound_heaps(tmp_path):
    rng = np.random.default_rng(10)
    for k in range(3):
        photograph(BENCH, rng, tmp_path / f"pile-{k}", gate_speed_mm_s=50)
    assert diagnose_pile(read_piles(tmp_path), rng).verdict == "none"


def walled(seen: SeenPile, seed_mm: float) -> SeenPile:
    """As a heap at a wall is seen: its last seed touches the wall, and shows its round
    side."""
    out = np.clip(seed_mm / 2 - (seen.x - seen.x[0]), 0.0, seed_mm / 2)
    return replace(
        seen,
        z=seen.z
        - (seed_mm / 2 - np.sqrt(np.maximum((seed_mm / 2) ** 2 - out**2, 0.0))),
    )


@pytest.mark.parametrize("stated", [True, False])
def test_the_last_seed_at_a_wall_does_not_lower_the_crest(stated):
    """What is left of the flank has the crest that the same heap has without it; as a
    control a flank that has two sides."""
    heap = Heap(two=False, height_mm=45.0, grain_mm=3.0, crest=0.0, scale=stated)
    plain = picture(heap, np.random.default_rng(3))
    flanks = [
        photo_of(seen).flanks[0]
        for seen in (plain, walled(plain, 3.0 if stated else 3.0 / PX_MM))
    ]
    np.testing.assert_allclose(
        flanks[1].v[:3], flanks[0].v[:3], atol=0.005
    )  # 0.03 of the height is missing at the wall
    assert (
        photo_of(picture(replace(heap, two=True), np.random.default_rng(3)))
        .flanks[0]
        .u[0]
        < 0.01
    )


def test_a_heap_cut_by_the_edge_is_used_for_what_is_seen_or_refused(tmp_path):
    rng = np.random.default_rng(12)
    photograph(BENCH, rng, tmp_path / "cut", cut=0.6)
    seen = read_piles(tmp_path)[0]
    if seen.trouble:
        assert "cut by" in seen.trouble
    else:
        found = diagnose_pile([seen], rng)
        assert found.verdict in ("none", "class") and any(
            "one flank only" in n or "cut by" in n for n in found.notes
        )


def test_what_is_no_photo_says_what_is_missing(tmp_path):
    folder = tmp_path / "pile-01"
    folder.mkdir()
    (folder / "recording.toml").write_text('rig = "pile"\n')
    (folder / "readings.csv").write_text("repose_angle_deg\n27.0\n")
    seen = read_piles(tmp_path)
    assert "a pile is diagnosed from photos" in seen[0].trouble
    with pytest.raises(ValueError, match=r"no photo shows a flank[\s\S]*pile-01"):
        diagnose_pile(seen, np.random.default_rng(1))
    with pytest.raises(FileNotFoundError):
        read_piles(tmp_path / "nowhere")
