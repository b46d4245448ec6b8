"""Graph paper: drawn cameras of known scale, what must be refused, whether the sd
covers, and the real photo."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from synthetic.paper import Paper, draw_paper, paper_mm, true_scale

from benchtwin.vision.measurement import DOUBTFUL, GOOD, MeasurementError
from benchtwin.vision.overlay.canvas import Canvas
from benchtwin.vision.overlay.seeds import LINE, paint_scale
from benchtwin.vision.paper.grid_pitch import _CLASSES, Strengths, _best_pattern
from benchtwin.vision.paper.scale import read_scale

SHAPE = (420, 560)

DIFFICULT = {
    "3 px per mm": Paper(mm_per_px=1 / 3.1, blur_px=0.5, noise=0.005),
    "7 px, turned": Paper(mm_per_px=1 / 7, tilt_deg=20),
    "45 degrees": Paper(mm_per_px=1 / 10, tilt_deg=-44),
    "leaning camera": Paper(mm_per_px=1 / 10, lean_deg=(15, -10)),
    "barrel": Paper(mm_per_px=1 / 12, barrel=0.05),
    "half covered": Paper(mm_per_px=1 / 12, cover=0.4),
    "noise": Paper(mm_per_px=1 / 12, noise=0.08),
    "uneven light": Paper(mm_per_px=1 / 12, light=0.8),
    "orange ink": Paper(mm_per_px=1 / 12, ink=(0.1, 0.5, 0.9)),
    "blue ink, 16 bits": Paper(mm_per_px=1 / 12, ink=(0.9, 0.5, 0.1), bits=16),
    "faint 1-mm lines": Paper(mm_per_px=1 / 15, depths=(0.06, 0.15, 0.5)),
    "no 5-mm lines": Paper(mm_per_px=1 / 10, depths=(0.25, 0, 0.6)),
    "a strip": Paper(mm_per_px=1 / 13, strip_mm=(-18, -10, 18, 2), tilt_deg=3),
}


@pytest.mark.parametrize("name", DIFFICULT)
def test_scale_of_a_drawn_paper(name):
    paper = DIFFICULT[name]
    scale = read_scale(draw_paper(paper, SHAPE, np.random.default_rng(5)), paper_sd=0)
    truth = true_scale(paper, SHAPE)
    assert scale.quality == GOOD, scale.reason
    # 5 sd: one in two million by chance, and a wrong pitch is off by hundreds; 0.2 %
    # beside it, that the sd be small.
    assert abs(scale.mm_per_px - truth) < min(
        max(5 * scale.mm_per_px_sd, 1e-4 * truth), 0.002 * truth
    )


def test_a_pitch_taken_five_times_too_long_is_noticed():
    """The control of the test above: the same bound refuses 5 ×, 2 × and 0.5 % wrong
    scales."""
    paper = DIFFICULT["noise"]
    scale = read_scale(draw_paper(paper, SHAPE, np.random.default_rng(5)), paper_sd=0)
    for wrong in (5, 2, 0.2, 1.005):
        assert abs(
            wrong * scale.mm_per_px - true_scale(paper, SHAPE)
        ) > 0.002 * true_scale(paper, SHAPE)


def test_large_pitch():
    paper = Paper(mm_per_px=1 / 60, tilt_deg=7, blur_px=1.5)
    shape = (1100, 1500)
    scale = read_scale(draw_paper(paper, shape, np.random.default_rng(5)))
    assert scale.mm_per_px == pytest.approx(
        true_scale(paper, shape), rel=3e-3
    )  # 25 mm of paper, a few windows


@pytest.mark.parametrize("tilt", [-30.0, -3.0, 0.0, 12.0, 40.0])
def test_tilt_is_clockwise_from_straight_down(tilt):
    scale = read_scale(
        draw_paper(
            Paper(mm_per_px=1 / 9, tilt_deg=tilt), SHAPE, np.random.default_rng(1)
        )
    )
    assert abs(scale.tilt_deg - tilt) < max(5 * scale.tilt_sd_deg, 0.01)


def test_turning_the_picture_clockwise_adds_to_the_tilt():
    """Independent of the drawing's own sign: a direction pointing down and to the left
    is clockwise from straight down."""
    paper = Paper(mm_per_px=1 / 9, tilt_deg=10)
    x, y = 280 - 200 * np.sin(np.radians(10)), 210 + 200 * np.cos(np.radians(10))
    assert paper_mm(paper, SHAPE, x, y)[0] == pytest.approx(
        paper_mm(paper, SHAPE, 280, 210)[0], abs=0.1
    )


def test_scale_by_place_follows_the_perspective():
    paper = Paper(mm_per_px=1 / 10, lean_deg=(20, 8))
    scale = read_scale(draw_paper(paper, SHAPE, np.random.default_rng(2)))
    corners = np.array([[40, 40], [520, 40], [40, 380], [520, 380]], float)
    truth = [true_scale(paper, SHAPE, *c) for c in corners]
    assert np.ptp(truth) / np.mean(truth) > 0.2  # the perspective is there to be missed
    assert scale.at(*corners.T) == pytest.approx(truth, rel=1e-3)
    assert scale.variation > 0.2
    drawn, read = (
        np.hypot(*np.subtract(*np.stack(f, -1)[:2]))
        for f in (paper_mm(paper, SHAPE, *corners.T), scale.to_mm(*corners.T))
    )
    assert read == pytest.approx(drawn, rel=1e-3)


def test_region_is_where_the_strip_is():
    paper = DIFFICULT["a strip"]
    scale = read_scale(draw_paper(paper, SHAPE, np.random.default_rng(3)))
    u, v = paper_mm(paper, SHAPE, *scale.region.T)
    x0, y0, x1, y1 = paper.strip_mm
    assert (
        (u > x0 - 1.5).all()
        and (u < x1 + 1.5).all()
        and (v > y0 - 1.5).all()
        and (v < y1 + 1.5).all()
    )
    assert np.ptp(v) > 0.6 * (y1 - y0)


def test_a_pattern_without_the_finest_lines_is_doubtful_and_said():
    paper = Paper(mm_per_px=1 / 2, depths=(0, 0.3, 0.6))
    scale = read_scale(draw_paper(paper, SHAPE, np.random.default_rng(4)))
    assert scale.quality == DOUBTFUL and "5-mm" in scale.reason
    assert scale.mm_per_px == pytest.approx(true_scale(paper, SHAPE), rel=2e-3)


def test_paper_of_one_or_two_millimetres_is_asked_about():
    """Both have every fifth line heavier: 1-mm paper without heavier 10-mm lines, and
    2-mm paper with 10-mm lines."""
    with pytest.raises(
        MeasurementError,
        match=(
            r"1 or 2 mm apart cannot be told; state \[camera\] mm_per_px \(0\.\d+ or"
            r" 0\.2"
        ),
    ):
        read_scale(
            draw_paper(
                Paper(mm_per_px=0.1, depths=(0.25, 0.5, 0)),
                SHAPE,
                np.random.default_rng(4),
            )
        )


def test_equal_lines_are_refused_with_the_choices():
    with pytest.raises(
        MeasurementError, match=r"every 10(\.\d+)? px.*cannot be told.*mm_per_px"
    ):
        read_scale(
            draw_paper(
                Paper(mm_per_px=0.1, depths=(0.3, 0, 0)),
                SHAPE,
                np.random.default_rng(4),
            )
        )


def test_patterns_of_strengths_are_told_apart():
    for pattern, classes in _CLASSES.items():
        value = np.roll(np.array([1.0, 1.6, 2.6])[list(classes)], 3)
        found = _best_pattern(1.0, [Strengths(value, np.full(10, 0.02))] * 2)
        assert found.mm == {"equal": None, "fifth": None, "second": 5.0}.get(
            pattern, 1.0
        )


def pictures_without_paper():
    rng = np.random.default_rng(0)
    y, x = np.mgrid[0:400, 0:500]
    yield "noise", rng.integers(0, 256, (400, 500), dtype=np.uint8)
    yield (
        "smooth noise",
        np.clip(
            128 + 40 * np.kron(rng.normal(size=(50, 100)), np.ones((8, 5))), 0, 255
        ).astype(np.uint8),
    )
    yield "horizontal stripes", np.where(y % 12 < 2, 60, 220).astype(np.uint8)
    yield "slanted stripes", np.where((x + 2 * y) % 25 < 4, 60, 220).astype(np.uint8)
    yield (
        "two families, not square",
        np.where((x % 9 < 2) | (y % 23 < 2), 60, 220).astype(np.uint8),
    )
    yield "black", np.zeros((400, 500), np.uint8)
    yield "white, colour, 16 bits", np.full((400, 500, 3), 65535, np.uint16)
    yield "tiny", np.zeros((20, 20), np.uint8)
    yield "empty", np.zeros((0, 0), np.uint8)
    yield "floating point", np.zeros((100, 100))
    yield "four channels", np.zeros((100, 100, 4), np.uint8)


@pytest.mark.parametrize(("name", "image"), list(pictures_without_paper()))
def test_no_paper_is_refused(name, image):
    with pytest.raises(MeasurementError):
        read_scale(image)


@settings(
    max_examples=15,
    deadline=None,
    suppress_health_check=list(HealthCheck),
    derandomize=True,
)
@given(
    st.integers(1, 90),
    st.integers(1, 140),
    st.sampled_from([np.uint8, np.uint16]),
    st.booleans(),
    st.integers(0, 9),
)
def test_any_picture_gives_a_scale_or_a_clear_refusal(
    height, width, kind, colour, seed
):
    rng = np.random.default_rng(seed)
    image = rng.integers(
        0,
        np.iinfo(kind).max,
        (height, width, 3) if colour else (height, width),
        dtype=kind,
    )
    with pytest.raises(MeasurementError):
        read_scale(image)


def random_paper(rng: np.random.Generator) -> Paper:
    return Paper(
        mm_per_px=1 / float(np.exp(rng.uniform(np.log(4), np.log(25)))),
        tilt_deg=float(rng.uniform(-44, 44)),
        lean_deg=tuple(rng.normal(0, 5, 2)),
        barrel=float(rng.normal(0, 0.01)),
        offset_mm=tuple(rng.uniform(0, 10, 2)),
        cover=float(rng.choice([0, 0.2, 0.4])),
        blur_px=float(rng.uniform(0.4, 1.2)),
        noise=float(rng.uniform(0.005, 0.04)),
        light=float(rng.uniform(-0.3, 0.3)),
        ink=(0.1, 0.5, 0.9) if rng.random() < 0.5 else None,
    )


def standard_scores(count: int, shape: tuple[int, int], first: int = 0) -> np.ndarray:
    """(read − true) / sd of drawn papers, at the paper's and the picture's centre; a
    paper not found counts as infinite."""
    scores = []
    for i in range(first, first + count):
        rng = np.random.default_rng(i)
        paper = random_paper(rng)
        image = draw_paper(paper, shape, rng)
        try:
            scale = read_scale(image, paper_sd=0)
        except MeasurementError:
            scores.append((np.inf, np.inf))
            continue
        on_paper = true_scale(paper, shape, *scale.region.mean(0))
        scores.append(
            (
                (scale.paper_mm_per_px - on_paper) / scale.paper_mm_per_px_sd,
                (scale.mm_per_px - true_scale(paper, shape)) / scale.mm_per_px_sd,
            )
        )
    return np.abs(np.array(scores))


@pytest.mark.slow
def test_sd_covers():
    """16 papers: at 95 % each, fewer than 12 covered would come up once in 10,000."""
    scores = standard_scores(16, SHAPE)
    assert (scores < 1.96).sum(0).min() >= 12
    assert np.median(scores) > 0.15  # an sd ten times too wide would give 0.07


@pytest.mark.slow
def test_sd_covers_in_90_to_98_per_cent():
    scores = standard_scores(200, (600, 800), first=1000)
    share = (scores < 1.96).mean(0)
    assert (share >= 0.90).all() and (share <= 0.985).all(), share
    assert np.isfinite(scores).mean() > 0.98


def test_overlay_shows_the_fitted_lines_on_the_paper():
    paper = replace(DIFFICULT["a strip"], ink=(0.9, 0.5, 0.1))
    image = draw_paper(paper, SHAPE, np.random.default_rng(3))
    canvas = Canvas(image)
    paint_scale(canvas, read_scale(image))
    overlay = canvas.pixels
    y, x = (np.array(np.nonzero((overlay == LINE).all(-1))) + 0.5) * SHAPE[
        1
    ] / overlay.shape[1] - 0.5
    u, v = paper_mm(paper, SHAPE, x, y)
    off = np.minimum(*(np.abs(w / 10 - np.rint(w / 10)) * 10 for w in (u, v)))
    assert (
        len(x) > 100 and np.percentile(off, 90) < 0.12
    )  # drawn on 10-mm lines to a pixel and a half
