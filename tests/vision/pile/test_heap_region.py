"""Heaps of drawn seeds before cloth, wood, a horizon and clutter, drawn here by code of
its own: each seed a shaded disc."""

from dataclasses import replace
from itertools import combinations

import cv2
import numpy as np
import pytest

from benchtwin.vision.measurement import DOUBTFUL, FAILED, GOOD, MeasurementError
from benchtwin.vision.pile import repose
from benchtwin.vision.pile.heap_region import CUTS, find_region
from benchtwin.vision.pile.pitch import CONE, SLAB, level_angle
from benchtwin.vision.pile.repose import PileOptions, measure_repose
from benchtwin.vision.recording import Camera

WIDTH, HEIGHT, FOOT, SEED = 900, 640, 470, 17.0  # px; SEED: a seed's diameter
BACKGROUNDS = ("plain", "cloth", "wood", "horizon", "clutter")


def behind(kind: str, rng: np.random.Generator) -> np.ndarray:
    """What stands behind the heap: (h, w, 3) float, 0–255."""
    y, x = np.mgrid[0:HEIGHT, 0:WIDTH].astype(float)
    wall = np.full((HEIGHT, WIDTH, 3), (95.0, 120.0, 150.0))
    if kind == "cloth":
        check = ((x // 70 % 2) + (y // 70 % 2))[..., None]
        wall = (
            (60 + 60 * check)
            * np.array([0.7, 0.9, 1.2])
            * (1 + 0.12 * np.sin(x / 2.1) * np.sin(y / 2.1))[..., None]
        )
    elif kind == "wood":
        streaks = cv2.GaussianBlur(
            rng.normal(size=(HEIGHT, WIDTH)), (0, 0), 60, sigmaY=2
        )
        wall = (110 * (1 + 1.8 * streaks / streaks.std() / 8))[..., None] * np.array(
            [1.1, 0.8, 0.5]
        )
    elif kind == "horizon":
        wall[FOOT - 70 :] = (
            170.0,
            160.0,
            150.0,
        )  # the table's far edge, at half the heap's height
    elif kind == "clutter":
        for _ in range(14):
            a, b = rng.uniform(0, (WIDTH, FOOT - 20), 2), rng.uniform(40, 160, 2)
            cv2.rectangle(
                wall,
                a.astype(int).tolist(),
                (a + b).astype(int).tolist(),
                rng.uniform(20, 230, 3).tolist(),
                -1,
            )
    return np.ascontiguousarray(wall)


def heap_of_seeds(
    kind: str,
    angle_deg: float,
    seed: int,
    half: bool = False,
    mirror: float = 0.0,
    centre: float = WIDTH / 2,
    roll_deg: float = 0.0,
) -> np.ndarray:
    """A heap whose free surface, through the tops of its outermost seeds, is two
    straight lines at `angle_deg`."""
    rng = np.random.default_rng([seed, BACKGROUNDS.index(kind)])
    picture = behind(kind, rng)
    picture[FOOT:] = (185.0, 180.0, 172.0)
    slope, radius = np.tan(np.radians(angle_deg)), SEED / 2
    reach = 240.0
    drop = radius * (
        1 / np.cos(np.radians(angle_deg)) - 0.15
    )  # the seeds' tops lie on the line
    places = []
    for back in range(3):  # rows of seeds, those in front drawn last
        for row in range(40):
            z = radius + row * 0.82 * SEED
            wide = reach - (z + drop) / slope
            if wide < 0:
                break
            count = max(1, int(2 * wide / (0.92 * SEED)))
            at = np.linspace(-wide, wide, count) + rng.normal(0, 0.8, count)
            places += [
                (u, z - rng.uniform(0, 0.12 * SEED) * (back > 0))
                for u in at
                if not half or u > 0
            ]
    rng.shuffle(places)
    for u, z in places:
        body = np.array([205.0, 165.0, 95.0]) * rng.normal(1, 0.08)
        for sign, strength in ((1, 1.0), (-1, mirror)):
            spot = (int((centre + u) * 16), int((FOOT - sign * z) * 16))
            if strength:
                under = picture.copy() if strength < 1 else picture
                for share, tone in ((1.0, 0.45), (0.86, 0.8), (0.6, 1.0), (0.3, 1.15)):
                    lift = int(-16 * radius * 0.25 * (1 - share) * sign)
                    cv2.circle(
                        under,
                        (spot[0], spot[1] + lift),
                        int(16 * radius * share),
                        (tone * body).tolist(),
                        -1,
                        cv2.LINE_AA,
                        4,
                    )
                if strength < 1:
                    picture[FOOT:] = (
                        (1 - strength) * picture[FOOT:] + strength * under[FOOT:]
                        if sign < 0
                        else picture[FOOT:]
                    )
    turn = cv2.getRotationMatrix2D((WIDTH / 2, HEIGHT / 2), -roll_deg, 1.0)
    picture = cv2.warpAffine(
        picture, turn, (WIDTH, HEIGHT), borderMode=cv2.BORDER_REPLICATE
    )
    picture = cv2.GaussianBlur(picture, (0, 0), 0.9) + rng.normal(0, 2, picture.shape)
    return np.clip(picture, 0, 255).astype(np.uint8)


def angle(image: np.ndarray, camera: Camera | None = None, **options):
    return measure_repose(image, camera, PileOptions(**options))


@pytest.mark.parametrize("kind", BACKGROUNDS)
def test_the_heap_is_found_before_every_background(kind):
    """33°, seeds of a fifteenth of the base: within three claimed sds and 2°, which is
    half a seed over the window's length."""
    found = angle(heap_of_seeds(kind, 33.0, seed=1))
    q = found.quantities[0]
    assert abs(q.value - 33.0) <= min(max(3 * q.sd, 1.0), 2.0)
    assert found.base.at(WIDTH / 2) == pytest.approx(FOOT, abs=0.3 * SEED)


def test_a_horizon_behind_the_heap_is_no_base_line():
    found = angle(heap_of_seeds("horizon", 28.0, seed=2))
    assert found.base.at(WIDTH / 2) == pytest.approx(FOOT, abs=0.3 * SEED)
    assert found.crest[1] == pytest.approx(
        FOOT - 240 * np.tan(np.radians(28)), abs=1.5 * SEED
    )


def test_a_mirror_image_is_not_part_of_the_heap():
    q = angle(heap_of_seeds("cloth", 32.0, seed=3, mirror=0.5)).quantities[0]
    assert abs(q.value - 32.0) <= max(3 * q.sd, 1.0)
    assert q.quality == GOOD


def test_frame_and_foot_given_by_hand_win():
    picture = np.hstack([heap_of_seeds("cloth", a, seed=4) for a in (26.0, 35.0)])
    for x0, true in ((0, 26.0), (WIDTH, 35.0)):
        foot = (x0 + 100.0, FOOT - 0.5, x0 + 800.0, FOOT - 0.5)
        found = angle(picture, roi=(x0 + 120, 200, 660, 400), baseline=foot)
        q = found.quantities[0]
        assert abs(q.value - true) <= max(3 * q.sd, 1.0)
        assert found.base.source == "given"
        assert found.base.at(0) == pytest.approx(FOOT - 0.5 - 200)


def test_of_two_heaps_one_is_measured_as_doubtful_and_the_frame_is_asked_for():
    picture = np.hstack(
        [heap_of_seeds("cloth", 30.0, seed=s)[:, 150:750] for s in (5, 6)]
    )
    q = angle(picture).quantities[0]
    assert q.quality == DOUBTFUL
    assert "--roi" in q.reason
    assert abs(q.value - 30.0) <= max(3 * q.sd, 1.0)


def test_a_line_that_contradicts_the_plumb_is_no_base_line():
    """The camera's roll is stated; a table's edge that runs 5° across it stands behind
    the heap."""
    picture = heap_of_seeds("plain", 30.0, seed=7)
    slanted = picture.copy()
    cv2.fillPoly(
        slanted,
        [np.array([(0, 400), (WIDTH, 479), (WIDTH, FOOT), (0, FOOT)])],
        (165, 160, 150),
    )
    seeds = (
        np.abs(picture.astype(int) - behind("plain", np.random.default_rng(0))).sum(
            axis=2, keepdims=True
        )
        > 60
    )
    q = angle(
        np.where(seeds, picture, slanted), Camera(plumb_deg=0.0, plumb_sd_deg=0.1)
    )
    assert abs(np.degrees(np.arctan(q.base.slope))) < 2.0
    assert abs(q.quantities[0].value - 30.0) <= max(3 * q.quantities[0].sd, 1.0)


@pytest.mark.parametrize("turn_deg", [-3.5, 3.5])
def test_the_foot_of_a_heap_on_a_plate_that_leans_is_found(turn_deg):
    """To .5°, of seeds whose foot is seen; by the stated plumb it is no level plate,
    which is said."""
    picture = heap_of_seeds("plain", 30.0, seed=7)
    height, width = picture.shape[:2]
    turn = cv2.getRotationMatrix2D((width / 2, height / 2), -turn_deg, 1.0)
    turned = cv2.warpAffine(
        picture, turn, (width, height), borderMode=cv2.BORDER_REPLICATE
    )
    found = angle(turned, Camera(plumb_deg=0.0, plumb_sd_deg=0.05))
    assert np.degrees(np.arctan(found.base.slope)) == pytest.approx(turn_deg, abs=0.5)
    assert found.base.source != "toe"
    q = found.quantities[0]
    assert q.quality == DOUBTFUL and "off level" in q.reason
    assert abs(q.value - 30.0) <= max(3 * q.sd, 1.0)


def test_a_wall_that_the_heap_leans_on_does_not_cost_the_sharper_reading():
    """A box wall taller than the heap: the reading off the smooth background, which
    knows where the wall stands, is kept."""
    picture = heap_of_seeds("plain", 30.0, seed=1, half=True)
    picture[FOOT - 220 : FOOT, WIDTH // 2 - 60 : WIDTH // 2 - 4] = (60, 70, 60)
    found = {q.name: q for q in angle(picture, side="right").quantities}
    assert abs(found["repose_angle"].value - 30.0) <= max(
        3 * found["repose_angle"].sd, 1.0
    )
    assert found["centroid_angle"].quality == GOOD


def test_other_crops_of_a_photo_agree_within_what_the_cuts_differ_by():
    """Three frames about one heap whose colours its background shares: each quantity
    differs by at most three of the sds, which the cuts' spread is in."""
    picture = heap_of_seeds("cloth", 31.0, seed=11)
    frames = ((60, 40, 780, 560), (110, 90, 690, 460), (20, 90, 830, 490))
    found = [
        {q.name: q for q in angle(picture, roi=frame).quantities} for frame in frames
    ]
    for name in ("repose_angle", "centroid_angle", "height_over_radius_angle"):
        for one, other in combinations([each[name] for each in found], 2):
            assert abs(one.value - other.value) <= 3 * np.hypot(one.sd, other.sd)
        assert all(abs(each[name].value - 31) < 8 for each in found)


def test_what_the_cuts_differ_by_is_in_every_sd(monkeypatch):
    """Two of five cuts with a wedge out of the right flank: what is read off that flank
    is known less well, the left flank as before."""
    picture = heap_of_seeds("cloth", 32.0, seed=3)
    region = find_region(picture)
    plain = [region.first] * CUTS
    down, across = np.indices(region.first.shape)
    top = region.first.argmax(axis=0)
    crest = int(np.where(top > 0, top, np.inf).argmin())
    lower = top + 0.12 * np.clip(across[0] - crest, 0, None)
    bitten = region.first & (down >= lower)
    sds = {}
    for name, cuts in (("alike", plain), ("apart", [*plain[2:], bitten, bitten])):
        region.__dict__["cuts"] = tuple(cuts)
        found = measure_repose(picture, find=lambda _: region)
        sds[name] = {q.name: q.sd for q in found.quantities}
    assert sds["apart"]["repose_angle_left"] < 1.5 * sds["alike"]["repose_angle_left"]
    for name in ("repose_angle", "repose_angle_right", "centroid_angle"):
        assert sds["apart"][name] > 1.3 * sds["alike"][name]


def test_a_picture_that_cuts_the_foot_is_doubted_in_every_quantity():
    found = angle(heap_of_seeds("cloth", 33.0, seed=1)[: FOOT - 25])
    assert {q.quality for q in found.quantities} <= {DOUBTFUL, FAILED}
    assert "bottom border" in found.quantities[0].reason


@pytest.mark.parametrize(("left", "cut"), [(540, True), (100, False)])
def test_a_heap_that_is_cut_at_its_crest_is_said_to_reach_the_border(left, cut):
    """There it may lean on a wall or go on."""
    found = angle(heap_of_seeds("horizon", 32.0, seed=3)[:, left:].copy())
    assert any("reaches the picture's left border" in n for n in found.notes) == cut


@pytest.mark.parametrize(("alpha", "pitch"), [(30, 5), (33, 10), (40, 15)])
def test_a_cone_seen_from_above_is_corrected_by_its_outline(alpha, pitch):
    """tan²α = (tan²α′ + sin²p) / cos²p where the whole window lies on the tangents; a
    form that is not known is midway between cone and slab, ± half of what they
    differ by."""
    tan, p = np.tan(np.radians(alpha)), np.radians(pitch)
    seen = np.degrees(np.arctan(np.sqrt((tan * np.cos(p)) ** 2 - np.sin(p) ** 2)))
    window = (0.3, 0.8)
    value, off = level_angle("repose_angle", seen, pitch, CONE, window)
    assert value == pytest.approx(alpha, abs=0.02)
    assert off == pytest.approx((alpha - seen) / 2, abs=0.02)
    flat = np.degrees(np.arctan(np.tan(np.radians(seen)) / np.cos(p)))
    value, off = level_angle("repose_angle", seen, pitch, "", window)
    assert value == pytest.approx((alpha + flat) / 2, abs=0.02)
    assert off == pytest.approx((alpha - flat) / 2, abs=0.02)
    slab = np.degrees(np.arctan(tan * np.cos(p)))
    assert level_angle("centroid_angle", slab, pitch, SLAB, window)[0] == (
        pytest.approx(alpha)
    )


@pytest.mark.parametrize("kind", ["cloth", "wood", "clutter"])
def test_a_background_without_seeds_is_refused_or_doubted(kind):
    wall = np.clip(
        behind(kind, np.random.default_rng(8))
        + np.random.default_rng(9).normal(0, 2, (HEIGHT, WIDTH, 3)),
        0,
        255,
    )
    try:
        q = angle(wall.astype(np.uint8)).quantities[0]
    except MeasurementError as error:
        assert "pile" in str(error) or "slope" in str(error)
    else:
        assert q.quality == DOUBTFUL


@pytest.mark.parametrize(
    "kind", ["cloth", pytest.param("horizon", marks=pytest.mark.slow)]
)
def test_a_picture_that_does_not_stand_upright_is_said_to_lie(kind):
    picture = heap_of_seeds(kind, 33.0, seed=1)
    assert find_region(picture).seen.way_up == ""
    for quarters, way in ((1, "left by 90°"), (2, "upside down"), (3, "right by 90°")):
        try:
            q = angle(np.rot90(picture, quarters).copy()).quantities[0]
        except MeasurementError as error:
            assert way in str(error)
        else:
            assert q.quality == DOUBTFUL and way in q.reason


def test_seeds_that_lie_about_a_heap_are_no_second_pile():
    """Two balls half as high as a flat heap; two heaps of that height are refused."""
    top = np.full(WIDTH, float(FOOT))
    x = np.arange(WIDTH)
    top = np.minimum(top, FOOT - np.clip(70 - 0.36 * np.abs(x - WIDTH / 2), 0, None))
    picture = np.full((HEIGHT, WIDTH), 230, np.uint8)
    picture[np.arange(HEIGHT)[:, None] >= top] = 60
    picture[FOOT:] = 150
    for u in (60, 120, 830):
        cv2.circle(picture, (u, FOOT - 17), 17, 60, -1)
    slope = np.degrees(np.arctan(0.36))
    assert angle(picture).quantities[0].value == pytest.approx(slope, abs=0.5)
    second = FOOT - np.clip(35 - 0.5 * np.abs(x - 70), 0, None)
    picture[np.arange(HEIGHT)[:, None] >= second] = 60
    with pytest.raises(MeasurementError, match="two piles"):
        angle(picture)


@pytest.mark.parametrize("number", (9, 16))
def test_a_few_seeds_on_a_tray_whose_cuts_have_nothing_in_common(number):
    """Some fifteen seeds in a layer or two: refused in words."""
    rng, foot = np.random.default_rng(number), 243
    image = np.full((286, 779, 3), (38, 34, 33), np.uint8)
    cv2.rectangle(image, (86, foot), (693, foot + 22), (130, 126, 124), -1)
    for _ in range(rng.integers(8, 22)):
        x, above = rng.uniform(120, 660), 40 if rng.random() < 0.3 else 0
        y = foot - 24 - above + rng.uniform(-3, 3)
        colour = (rng.uniform(0.6, 1) * np.array([130, 190, 225])).tolist()
        axes, turn = (int(rng.uniform(25, 33)), 23), float(rng.uniform(-20, 20))
        at = (int(x), int(y))
        cv2.ellipse(image, at, axes, turn, 0, 360, colour, -1, cv2.LINE_AA)
    stated = PileOptions(baseline=(86, foot, 693, foot))
    with pytest.raises(MeasurementError, match="two piles"):
        measure_repose(image, Camera(mm_per_px=0.14, plumb_deg=0.0), stated)


@pytest.mark.parametrize(("doubted", "value_deg"), [(True, 33.0), (False, 22.0)])
def test_a_doubted_outline_gives_way_to_the_seeds_own(monkeypatch, doubted, value_deg):
    """Where both readings are of different heaps, and the seeds are not sure to be
    seeds: then an outline that nothing speaks against is kept."""
    smooth = angle(heap_of_seeds("plain", 22.0, seed=1))
    smooth = smooth.doubted("cut") if doubted else smooth
    monkeypatch.setattr(repose, "_on_smooth_background", lambda photo: smooth)
    picture = heap_of_seeds("cloth", 33.0, seed=1)
    half_sure = replace(find_region(picture), confidence=0.7)
    found = measure_repose(picture, find=lambda crop: half_sure).quantities[0]
    assert found.value == pytest.approx(value_deg, abs=2.0)
    assert found.quality == (DOUBTFUL if doubted else GOOD)


@pytest.mark.parametrize("kind", ["cloth", "wood"])
def test_the_wall_that_a_heap_leans_on_need_not_be_stated(kind):
    """Few seeds lie beside it: the crest is three seeds off."""
    picture, wall = heap_of_seeds(kind, 30.0, seed=1, half=True), WIDTH // 2 - 4
    bare = np.s_[: FOOT - 95, wall : wall + 54]
    picture[bare] = behind(kind, np.random.default_rng(1))[bare]
    picture[FOOT - 220 : FOOT, wall - 56 : wall] = (60, 70, 60)
    stated, unstated = (
        {q.name: q for q in angle(picture, side=side).quantities}
        for side in ("right", "")
    )
    for name in ("repose_angle", "centroid_angle"):
        assert unstated[name].value == pytest.approx(stated[name].value, abs=0.3)


def box_of_beads(angle_deg: float, seed: int) -> np.ndarray:
    """A frame of a film of white beads that lean on the right wall of a glass box: the
    upper ones overexposed, the box's dark rim above, a layer of beads on the floor, a
    clock laid over the film."""
    rng = np.random.default_rng(seed)
    floor, wall, radius = 560, 1130, 7.0
    x = np.arange(1180)
    picture = np.full((600, 1180, 3), 140.0)
    picture[190:330, 60:180] = 70.0
    picture[230:300, 420:720] = 90.0
    picture = cv2.GaussianBlur(picture, (0, 0), 12)
    slope = np.tan(np.radians(angle_deg))
    crest = floor - 820 * slope
    top = np.minimum(crest + slope * np.clip(wall - 60 - x, 0, None), floor - 24.0)
    places = np.c_[rng.uniform(0, wall, 40000), rng.uniform(0, floor, 40000)]
    places = places[places[:, 1] > top[places[:, 0].astype(int)] + radius]
    for u, v in places:
        deep = min((v - top[int(u)]) / 90, 1.0)
        at = (round(u * 16), round(min(v, floor - radius) * 16))
        for share, tone in ((1.0, 250 - 40 * deep), (0.6, 252 - 25 * deep)):
            shade = (tone + rng.normal(0, 2) * deep,) * 3
            cv2.circle(picture, at, int(16 * radius * share), shade, -1, 16, 4)
    picture[floor:], picture[:45], picture[:, wall:] = 105.0, 60.0, 95.0
    clock = np.full((90, 200, 3), 28, np.uint8)
    picture[60:150, 40:240] = cv2.putText(
        clock, "00:00:01.02", (8, 60), 0, 0.95, (220, 220, 220), 2
    )
    picture = cv2.GaussianBlur(picture, (0, 0), 1.2)
    return np.clip(picture + rng.normal(0, 2, picture.shape), 0, 255).astype(np.uint8)


@pytest.mark.parametrize("angle_deg", [17.0, 25.0])
def test_overexposed_beads_in_a_box_beside_a_clock_are_the_heap(angle_deg):
    """Neither the box's rim nor the clock is; what glares is no background."""
    found = angle(box_of_beads(angle_deg, seed=1))
    q = found.quantities[0]
    assert abs(q.value - angle_deg) <= min(max(3 * q.sd, 1.0), 3.0)
    assert found.crest[0] > 900
    assert found.base.at(600) == pytest.approx(560, abs=10)
    assert q.quality == GOOD and found.base.source == "foot"
