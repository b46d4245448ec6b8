"""Heaps: drawn by heaping.py, as surfaces and as pictures through the measuring
code."""

from dataclasses import replace

import numpy as np
import pytest
from heaping import Heap, changed, clean_bench, picture, repeats

from benchtwin.rigs.pile.diagnose import diagnose_pile
from benchtwin.rigs.pile.effects import EFFECTS
from benchtwin.rigs.pile.flanks import photo_of, photos_of

BENCH = Heap(grain_mm=3.0)
OF_SEEDS = {"seed-friction", "cohesion", "particle-shape", "wall-friction"}
SHAPES = {
    *("cohesion", "gate-speed", "base-vibration", "wall-friction", "particle-shape"),
    "seed-friction",
}


def told(heaps: list, seed: int = 1):
    """Finding of heaps, each given a name of its own."""
    return diagnose_pile(
        [replace(heap, recording=f"heap-{k}") for k, heap in enumerate(heaps)],
        np.random.default_rng(seed),
    )


def shaken(h: Heap, rng) -> list:
    """Two heaps each 2, 60 and 300 s after the gate: crest sinks, toe grows, flank
    flattens."""
    return [
        picture(
            changed(
                h,
                crest=h.crest + t / 1000,
                toe=h.toe + t / 1200,
                angle_deg=h.angle_deg - t / 50,
            ),
            rng,
            photo_s=t,
        )
        for t in (2, 2, 60, 60, 300, 300)
    ]


def hurried(h: Heap, rng) -> list:
    """Three gate speeds: what the gate does grows with it."""
    return [
        picture(
            changed(
                h,
                crest=h.crest + v / 200,
                toe=h.toe + v / 270,
                angle_deg=h.angle_deg - v / 20,
            ),
            rng,
            gate_speed_mm_s=v,
        )
        for v in (20, 20, 50, 50, 100, 100)
    ]


def sticky(h: Heap, rng) -> list:
    """Three sizes of seed: the finer, the steeper the crest and the whole."""
    return [
        picture(
            changed(
                h,
                crest=0.0,
                toe=0.0,
                steep=0.9 / d,
                grain_mm=d,
                angle_deg=h.angle_deg + 30 / d,
            ),
            rng,
            seed_mm=d,
        )
        for d in (3, 3, 5, 5, 8, 8)
    ]


def held(h: Heap, rng) -> list:
    """Three widths of box: tan θ and a bow grow as 1/width."""
    return [
        picture(changed(h, bow=3 / w, angle_deg=h.angle_deg + 360 / w), rng, width_mm=w)
        for w in (30, 30, 60, 60, 120, 120)
    ]


CONTRASTS = {
    "base-vibration": shaken,
    "gate-speed": hurried,
    "cohesion": sticky,
    "wall-friction": held,
}


@pytest.mark.parametrize("seed", range(5))
def test_sound_heaps_raise_no_alarm(seed):
    rng = np.random.default_rng([11, seed])
    found = told(repeats(clean_bench(rng), rng, 4))
    assert (found.verdict, found.alarm) == ("none", False)


@pytest.mark.parametrize("name", CONTRASTS)
def test_what_differs_as_a_law_says_has_its_name(name):
    found = told(CONTRASTS[name](BENCH, np.random.default_rng(2)))
    assert (found.verdict, found.names) == ("name", (name,))
    assert found.sectors[0].name in {"crest", "toe"} ^ (
        {"crest", "toe", "middle"} if name == "wall-friction" else set()
    )
    assert found.held_out.rmse_ratio < 0.99
    assert 0.7 < found.held_out.removed_fraction < 1.3


@pytest.mark.parametrize("name", CONTRASTS)
def test_without_what_was_stated_nothing_has_a_name(name):
    """The same heaps, their conditions struck out: they scatter, and no law says
    why."""
    heaps = CONTRASTS[name](BENCH, np.random.default_rng(2))
    found = told(
        [
            replace(
                h,
                description={"camera": h.description["camera"], "pile": {}, "seed": {}},
            )
            for h in heaps
        ]
    )
    assert found.verdict != "name"


def test_a_leaning_plate_under_an_upright_heap_is_named():
    for tilt in (3.0, -3.0):
        found = told(
            repeats(changed(BENCH, tilt_deg=tilt), np.random.default_rng(3), 4)
        )
        assert (found.verdict, found.names) == ("name", ("base-tilt",))
        assert (
            found.parameters["base-tilt"].low95
            < tilt
            < found.parameters["base-tilt"].high95
        )
        assert found.sectors[0].name == "measurement"


@pytest.mark.parametrize("more", [{"roll_deg": 3.0}, {"roll_deg": -4.0, "two": False}])
def test_confounded_tilts_are_a_class(more):
    found = told(repeats(changed(BENCH, **more), np.random.default_rng(4), 4))
    assert (found.verdict, set(found.names)) == ("class", {"base-tilt", "camera-roll"})
    assert "plumb" in found.next_record and not found.parameters


def test_flanks_that_differ_against_their_plate_were_poured_on_a_tilt():
    """Without a plumb line too: no roll of the picture turns a heap against its
    plate."""
    assert told(
        repeats(changed(BENCH, tilt_deg=4.0, plumb=False), np.random.default_rng(4), 4)
    ).names == ("base-tilt",)


def test_a_rolled_picture_without_plumb_raises_no_alarm():
    assert (
        told(
            repeats(
                changed(BENCH, roll_deg=5.0, plumb=False), np.random.default_rng(5), 4
            )
        ).verdict
        == "none"
    )


def test_a_flank_that_breaks_is_unknown_and_described():
    found = told(
        repeats(changed(BENCH, break_=0.25, grain_mm=2.0), np.random.default_rng(6), 4)
    )
    assert found.verdict == "unknown" and found.sectors[0].name == "middle"
    assert found.law is None or "break at" in found.law
    assert found.next_record


def test_photos_of_one_heap_are_one_heap():
    """Four photos of one packing tell no more of the bench than one; in folders of
    their own they count as four."""
    seen = picture(changed(BENCH, crest=0.25, toe=0.15), np.random.default_rng(5))
    alike = [
        replace(seen, recording=f"pile-01/photo-{k}", heap="bench/pile-01")
        for k in range(4)
    ]
    (photo,), _ = photos_of(alike)
    assert (
        photo.recording == "pile-01"
        and len(photos_of([replace(a, heap="") for a in alike])[0]) == 4
    )
    once = photo_of(seen)
    assert [f.angle_deg for f in photo.flanks] == pytest.approx(
        [f.angle_deg for f in once.flanks]
    )
    assert np.allclose(photo.flanks[0].v, once.flanks[0].v)


def in_turn(lower: float, other_side: bool = False) -> list:
    """Four heaps, each in three photos: every one `lower` times as high as the one
    before; or from other sides."""
    heaps = []
    for k in range(4):
        views = [
            picture(BENCH, np.random.default_rng([21, k, j if other_side else 0]))
            for j in range(3)
        ]
        noise = [
            0.03 * np.random.default_rng([22, k, j]).normal(size=len(v.z))
            for j, v in enumerate(views)
        ]
        heaps += [
            replace(
                v,
                recording=f"pile-{k}/photo-{j}",
                heap=f"bench/pile-{k}",
                z=v.z * lower**j + noise[j],
            )
            for j, v in enumerate(views)
        ]
    return heaps


def test_flattening_from_photo_to_photo_is_base_vibration():
    found = diagnose_pile(in_turn(0.97), np.random.default_rng(1))
    assert (found.verdict, found.names) == ("name", ("base-vibration",))
    creep = found.parameters["base-vibration"]
    flatter = 28 - np.degrees(np.arctan(np.tan(np.radians(28)) * 0.97**2))
    assert creep.low95 < flatter < creep.high95 and creep.unit == "deg"


@pytest.mark.parametrize(
    ("lower", "other_side"), [(1.0, False), (0.997, False), (1.0, True)]
)
def test_photos_in_turn_of_heaps_at_rest_raise_no_alarm(lower, other_side):
    """Measuring noise, seeds that settle by a tenth of a degree, and other sides of the
    heap are no news."""
    assert (
        diagnose_pile(in_turn(lower, other_side), np.random.default_rng(1)).verdict
        == "none"
    )


def test_rising_heaps_and_other_views_are_no_vibration():
    assert diagnose_pile(in_turn(1.03), np.random.default_rng(1)).verdict != "name"
    photos, _ = photos_of(in_turn(0.97, other_side=True))
    assert all(np.isnan(p.creep_deg) for p in photos)


def test_cohesion_has_its_name_by_heaps_of_several_sizes_too():
    rng = np.random.default_rng(2)
    heaps = [
        replace(
            picture(
                changed(
                    BENCH, steep=9 / size, height_mm=size, angle_deg=27 + 300 / size
                ),
                rng,
            ),
            description=sized(size),
        )
        for size in (30, 30, 60, 60, 120, 120)
    ]
    found = told(heaps)
    assert found.verdict in ("name", "class") and "cohesion" in found.names


def test_a_bow_in_seed_heights_is_a_class():
    """In shares it is larger on small heaps: grain shape and walls may do that too."""
    rng, bow_mm = np.random.default_rng([31, 5]), 6.0
    heaps = [
        replace(
            picture(changed(BENCH, bow=bow_mm / s, height_mm=s), rng),
            description=sized(s),
        )
        for s in (30, 60) * 3
    ]
    found = told(heaps)
    assert found.verdict == "class" and {"particle-shape", "wall-friction"} < set(
        found.names
    )


def sized(size: float) -> dict:
    return {
        "camera": {"plumb_deg": 0.0, "plumb_sd_deg": 0.1},
        "pile": {"cylinder_mm": [2 * size, 200.0]},
        "seed": {"length_mm": 3.0},
    }


def plain(heap):
    """The same heap, its seeds known to be as usual."""
    told = heap.description["pile"] | {"plain": True}
    return replace(heap, description=heap.description | {"pile": told})


def test_steeper_heaps_beside_plain_ones_are_of_other_seeds():
    """By themselves heaps of any angle are sound, and so are more plain ones; a flank's
    angle alone does not tell friction from cohesion or grain shape, and no tilt of a
    plate that all stood on makes some of them steeper."""
    rng = np.random.default_rng(2)
    usual, damp = repeats(BENCH, rng, 10), repeats(changed(BENCH, angle_deg=35), rng, 5)
    known = [plain(heap) for heap in usual[:5]]
    assert not told(damp).alarm and not told([*known, *usual[5:]]).alarm
    found = told([*known, *damp])
    assert found.alarm and found.verdict == "class"
    assert {"cohesion", "seed-friction"} <= {*found.names} <= OF_SEEDS
    assert not {*told([*usual[:5], *damp]).names} & OF_SEEDS


def test_heaps_of_two_kinds_that_state_the_same_are_said_to_differ():
    """Six of 28° and six of 35°, in turn; one kind, or a stated difference, is none."""
    rng = np.random.default_rng(3)
    usual, damp = repeats(BENCH, rng, 6), repeats(changed(BENCH, angle_deg=35), rng, 6)
    both = [
        replace(heap, recording=f"heap-{k:02d}")
        for k, heap in enumerate(
            h for pair in zip(usual, damp, strict=True) for h in pair
        )
    ]

    def differ(heaps) -> list[str]:
        return [note for note in told(heaps).notes if "nobody states" in note]

    (note,) = differ(both)
    assert "12 heaps" in note and not differ(usual)
    assert not differ([plain(h) if k % 2 else h for k, h in enumerate(both)])


def test_one_photo_holds_nothing_out_and_says_so():
    found = told(repeats(changed(BENCH, tilt_deg=4.0), np.random.default_rng(7), 1))
    assert "base-tilt" in found.names
    assert found.held_out is None and any("one photo" in note for note in found.notes)


@pytest.mark.parametrize("slope", [1.0, -1.0])
def test_an_angle_that_follows_a_stated_condition_is_said(slope):
    """1° a percent of moisture, which no law of a heap's shape knows."""
    heaps = []
    for k, moisture in enumerate((9, 14, 11, 12, 14, 9, 12, 11)):
        heap = picture(
            changed(BENCH, angle_deg=28 + slope * (moisture - 11)),
            np.random.default_rng([8, k]),
        )
        heaps.append(
            replace(
                heap,
                description=heap.description
                | {"conditions": {"moisture_pct": float(moisture)}},
            )
        )
    found = told(heaps)
    assert (found.verdict, found.names) == (
        "name",
        ("repose_angle_deg-follows-moisture_pct",),
    )
    size = found.effects[found.names[0]].size
    assert size.low95 < slope < size.high95 and size.low95 * size.high95 > 0


def test_scale_changes_no_verdict_and_places_are_shares_without():
    with_scale, without = (
        told(shaken(changed(BENCH, scale=scale), np.random.default_rng(2)))
        for scale in (True, False)
    )
    assert with_scale.names == without.names == ("base-vibration",)
    assert without.curves[0].unit == "px" and with_scale.curves[0].unit == "mm"
    assert any("no scale" in note for note in without.notes)


def test_curves_show_the_surface_and_a_model_that_leaves_less():
    found = told(shaken(BENCH, np.random.default_rng(2)))
    assert len(found.curves) == 12  # six photos, two flanks
    before, after = (
        np.sqrt(np.mean(np.concatenate([getattr(c, k) for c in found.curves]) ** 2))
        for k in ("left_by_baseline", "left_by_model")
    )
    assert after < before
    assert found.curves[0].seen.max() == pytest.approx(BENCH.height_mm, rel=0.15)


def test_a_heap_is_seen_in_shares_of_its_own_size():
    """The straight flank is 1 − u at any size, angle and turn of the picture."""
    for h in (
        BENCH,
        changed(BENCH, height_mm=110.0, angle_deg=20.0),
        changed(BENCH, roll_deg=2.0, tilt_deg=-2.0),
    ):
        photo = photo_of(
            picture(
                changed(h, crest=0.0, toe=0.0, grain_mm=0.5, angle_sd_deg=0.0),
                np.random.default_rng(8),
            )
        )
        assert [f.side for f in photo.flanks] == [-1, 1]
        for f in photo.flanks:
            inner = (f.u > 0.1) & (f.u < 0.9)
            assert (
                np.percentile(np.abs(f.v - 1 + f.u)[inner], 95) < 0.01
            )  # gaps between grains apart
            assert f.angle_deg == pytest.approx(
                h.angle_deg + f.side * h.roll_deg, abs=0.3
            )


def test_every_candidate_has_a_law_a_source_and_what_separates_it():
    assert {n for n in EFFECTS if "." not in n} == SHAPES | {"base-tilt", "camera-roll"}
    assert all(e.source and (e.group or e.separating) for e in EFFECTS.values())


@pytest.mark.slow
def test_sound_heaps_are_left_alone_three_hundred_times():
    alarms = names = 0
    for seed in range(300):
        rng = np.random.default_rng([21, seed])
        found = diagnose_pile(
            repeats(clean_bench(rng), rng, int(rng.integers(1, 7))), rng
        )
        alarms, names = alarms + found.alarm, names + (found.verdict == "name")
    assert names == 0 and alarms <= 3


@pytest.mark.slow
@pytest.mark.parametrize("name", CONTRASTS)
def test_a_contrast_never_has_a_wrong_name(name):
    right = wrong = 0
    for seed in range(40):
        rng = np.random.default_rng([22, seed])
        found = told(
            CONTRASTS[name](
                changed(clean_bench(rng), angle_deg=rng.uniform(24, 32)), rng
            )
        )
        right += found.verdict in ("name", "class") and name in found.names
        wrong += found.verdict == "name" and found.names != (name,)
    assert wrong == 0 and right >= 34


@pytest.mark.slow
def test_tilts_are_found_and_their_interval_holds():
    inside = found_name = wrong = 0
    for seed in range(60):
        rng = np.random.default_rng([23, seed])
        tilt = float(rng.choice([-1, 1]) * rng.uniform(2, 4))
        h = changed(
            clean_bench(rng),
            two=True,
            plumb=True,
            plate=True,
            plumb_sd_deg=0.1,
            roll_deg=0.1 * rng.normal(),
            tilt_deg=tilt,
        )
        found = told(repeats(h, rng, 4))
        found_name += found.names == ("base-tilt",) and found.verdict == "name"
        wrong += found.verdict == "name" and found.names != ("base-tilt",)
        p = found.parameters.get("base-tilt")
        inside += p is not None and p.low95 < tilt < p.high95
    assert wrong == 0 and found_name >= 50 and inside >= 0.9 * found_name
