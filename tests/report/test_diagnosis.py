"""The page of a diagnosis: verdict first, figures with finite numbers, nothing from a
network, readable on a phone."""

import json
import re
import shutil
import subprocess
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest
from pages import Tags, own

from benchtwin.diagnose.bench import Diagnosis
from benchtwin.diagnose.rerun import Comparison, Resimulation
from benchtwin.infer.finding import Curve, Finding, Parameter, Sector
from benchtwin.infer.follow import Follow, Point
from benchtwin.infer.held_out import HeldOut
from benchtwin.infer.unlisted import Window
from benchtwin.infer.verdict import EffectEstimate, Interval, ParameterShift
from benchtwin.report.diagnosis import render
from benchtwin.report.residuals import BINS, binned

CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser")


def finding(rig="drop", **change) -> Finding:
    """One whose numbers are all made up."""
    rng, time = np.random.default_rng(1), np.linspace(0, 0.3, 600)
    left = rng.normal(0, 0.05, 600)
    curves = tuple(
        Curve(
            f"drop-{k}",
            "height",
            "mm",
            "t_s",
            time,
            310 - 4900 * time**2,
            left + 3 * time**2,
            left,
        )
        for k in range(2)
    )
    effects = {
        "drag": EffectEstimate(0.997, "1", Interval(0.018, 0.016, 0.020)),
        "perspective": EffectEstimate(0.02, "1/m", Interval(-0.03, -0.05, -0.01)),
    }
    moved = ParameterShift(Interval(0.500, 0.490, 0.510), Interval(0.516, 0.505, 0.527))
    usual = Finding(
        rig,
        ("drop-0", "drop-1"),
        True,
        1e-9,
        (Sector("flight", 0.97, 1e-12), Sector("measurement", 0.3, 1e-3)),
        Window("v_m_s", 1.5, 2.4, 1e-4),
        "v_m_s",
        "name",
        ("drag",),
        55.0,
        43.0,
        {"drag": Parameter("1", 0.018, 0.016, 0.020)},
        None,
        HeldOut(0.9, 0.96),
        None,
        0.96,
        True,
        ((("drag",), 0.96), (("drag", "perspective"), 0.02), ((), 1e-5)),
        effects,
        {"restitution": moved},
        curves,
        ("A note.",),
        {"drag": (0.018, 0.0181)},
    )
    return replace(usual, **change)


def diagnosis(**rigs) -> Diagnosis:
    findings = {name: f for name, f in rigs.items() if isinstance(f, Finding)}
    twins = {"drop": AGAIN} if "drop" in findings and findings["drop"].left_out else {}
    return Diagnosis(Path("my-bench"), findings, {}, {}, (), twins=twins)


DOT = cv2.imencode(".png", np.full((40, 90), 128, np.uint8))[1].tobytes()
ROWS = tuple(
    Comparison(f"drop-{k}", "place in flight", "mm", 0.08, 0.04, "track")
    for k in range(2)
)
POINTS = {
    "x": "impact speed (m/s)",
    "y": "restitution",
    "points": {"recorded": (np.arange(3.0), np.arange(3.0))},
}
AGAIN = Resimulation(
    "drop",
    ("drag",),
    "drag is on",
    "each flight was flown again",
    ROWS,
    True,
    DOT,
    "side by side",
    (),
    POINTS,
)


NIL = Interval(0.0, -1.0, 1.0)
APART = {
    "slope": EffectEstimate(0.6, "deg", NIL),
    "drag": EffectEstimate(0.39, "1", NIL),
}


# restitution that grows from 0.4 to 0.6 over three pressures
FOLLOW = Follow(
    "restitution",
    "pressure_kpa",
    "levelling off",
    1e-6,
    0.99,
    Interval(0.003, 0.002, 0.004),
    tuple(
        Point(x, Interval(e, e - 0.01, e + 0.01))
        for x, e in ((20.0, -0.116), (50.0, 0.05), (90.0, 0.084))
    ),
    (),
    {"drop-0": 20.0, "drop-1": 90.0},
    {"drop-0": (-0.12, 0.01), "drop-1": (0.09, 0.01)},
    {},
    {},
)


@pytest.fixture(scope="module")
def page() -> str:
    return render(
        diagnosis(
            drop=finding(follows=(FOLLOW,)),
            roll=finding(
                "roll",
                verdict="class",
                names=("slope", "drag"),
                p_verdict=0.98,
                explanations=((("slope",), 0.6), (("drag",), 0.38), ((), 0.02)),
                effects=APART,
                left_out={},
            ),
        )
    )


def test_every_element_is_closed_and_nothing_is_loaded(page):
    tags = Tags()
    tags.feed(own(page))
    assert tags.open == [] and tags.loads == [] and len(tags.ids) == len(set(tags.ids))
    assert len(page.encode()) < 8e6


def test_the_verdicts_stand_first(page):
    text = re.sub(r"<[^>]+>", " ", own(page).split("</style>")[1])
    first = text.index(
        "restitution reads 3.1 % too low (3.1 of its sds) because air drag is missing"
        " (98 %), and nothing else (96 %): 0.0180 of the weight at 2 m/s (95 %:"
        " 0.0160 to 0.0200)"
    )
    second = text.index(
        "the plate is not level (60 %) or air drag is missing (38 %), which these"
        " recordings do not tell apart (98 % together)"
    )
    assert first < second < text.index("Where") and first < 400
    assert text.index(
        "the twin is off by 0.04 mm where it was off by 0.08"
    ) < text.index("Where")
    for piece in (
        "97 % of the mismatch",
        "speed 1.5 to 2.4 m/s",
        (
            "Noise alone makes as great a mismatch in fewer than 1 of 10 000 benches (p"
            " &lt; 0.0001); an alarm needs p &lt; 0.001"
        ),
        "0.5000 (0.4900 to 0.5100)",
        "3.1 of its sds",
        "explains 96 % of what is left beyond noise without it",
        "A note.",
        (
            "Restitution rises with pressure_kpa, levelling off: 0.4000 at 20 to 0.6000"
            " at 90 (p &lt; 0.0001)."
        ),
    ):
        assert piece in text, piece


def test_every_figure_has_its_place_and_before_and_after_one_scale(page):
    drawn = json.loads(
        re.search(r"const drawn = (\{.*?\});\nfor", page, re.DOTALL)[1].replace(
            "<\\/", "</"
        )
    )
    assert (
        set(drawn)
        == set(re.findall(r'id="fig-([\w-]+)"', page))
        >= {"drop-left-0", "drop-seen-0", "drop-twins", "roll-left-0", "drop-follows-0"}
    )
    curve, own = drawn["drop-follows-0"]["data"][1:]
    assert curve["y"] == pytest.approx([0.4, 0.566, 0.6])
    assert own["x"] == [20, 90] and own["error_y"]["array"] == [0.01, 0.01]
    layout = drawn["drop-left-0"]["layout"]
    assert layout["yaxis"]["range"] == layout["yaxis2"]["range"]
    above, below = (
        [t for t in drawn["drop-left-0"]["data"] if t["yaxis"] == axis]
        for axis in ("y", "y2")
    )
    assert len(above) == len(below) == 2
    assert np.abs(above[0]["y"]).max() > 3 * np.abs(below[0]["y"]).max()


def test_averaging_keeps_what_is_slow_and_leaves_gaps_out():
    x = np.r_[np.linspace(0, 1, 5000), np.linspace(2, 3, 5000)]
    mean_x, mean_y = binned(x, 7 * x + np.random.default_rng(0).normal(0, 1, len(x)))
    assert len(mean_x) <= BINS and not ((mean_x > 1.02) & (mean_x < 1.98)).any()
    assert (
        np.sqrt(np.median((mean_y - 7 * mean_x) ** 2)) < 0.15
    )  # 130 points a bin, but at the ends of a gap: 0.09


def test_names_from_outside_are_text_only():
    bad = "<script>alert(1)</script>"
    curves = tuple(replace(c, recording=bad) for c in finding().curves)
    made = diagnosis(
        drop=finding(recordings=(bad,), curves=curves, notes=(bad,), law=bad)
    )
    page = own(
        render(
            replace(
                made, refused={"pile": bad}, trouble=((bad, "drop", bad),), notes=(bad,)
            )
        )
    )
    assert bad not in page and "&lt;script&gt;alert(1)" in page


def test_explanations_and_effects_have_their_probabilities(page):
    rows = re.findall(r"<tr>(.*?)</tr>", own(page))
    cells = [re.findall(r"<td[^>]*>(.*?)</td>", row) for row in rows]
    assert ["air drag is missing", "96 %"] in cells and [
        "nothing",
        "&lt; 0.1 %",
    ] in cells
    assert ["air drag is missing; the scale changes with height", "2 %"] in cells
    assert [
        "the scale changes with height",
        "2 %",
        "−0.030 (−0.050 to −0.010)",
        "1/m",
        "perspective",
    ] in cells


def test_nothing_found_is_a_page_too():
    nothing = {
        "verdict": "none",
        "names": (),
        "alarm": False,
        "matters": False,
        "p_verdict": 0.82,
        "p_global": 0.4,
    }
    none = finding(
        **nothing,
        parameters={},
        left_out={},
        held_out=None,
        explanations=(),
        effects={},
        contact={},
        window=None,
    )
    page = own(render(diagnosis(drop=none)))
    assert (
        "nothing was shown to be missing in the 2 recordings (82 % that nothing is);"
        " noise alone would do this in 4 of 10 benches"
        in page
        and "Record next" not in page
    )
    assert 'class="verdict sure"' in page
    doubtful = own(render(diagnosis(drop=replace(none, p_verdict=0.34))))
    assert 'class="verdict open"' in doubtful and "nothing shown" in doubtful
    assert render(diagnosis()).startswith("<!doctype html>")


def test_what_moves_nothing_that_matters_is_one_quiet_line():
    page = own(
        render(diagnosis(drop=finding(matters=False, next_record="another drop")))
    )
    answer = page[page.index('<section id="answer">') : page.index("</section>")]
    assert (
        'class="verdict quiet"' in answer
        and "Drop: found, but it moves nothing that matters: air drag is missing"
        in answer
    )
    assert "run again" not in answer and "Record next" not in answer


@pytest.mark.skipif(CHROMIUM is None, reason="no chromium is installed")
@pytest.mark.parametrize("width", [500, 1100])
def test_a_browser_draws_it_without_a_network(page, width, tmp_path):
    """Figures are there, nothing sticks out sideways, on a phone's width and on a
    desk's."""
    probe = """<script>addEventListener("load", () => setTimeout(() => {
      document.title = JSON.stringify({
      wide: document.documentElement.scrollWidth, seen: innerWidth,
      lines: document.querySelectorAll(".scatterlayer .trace").length,
      image: document.querySelector("img").naturalWidth }); }, 300));</script></body>"""
    (tmp_path / "report.html").write_text(
        page.replace("</body>", probe), encoding="utf8"
    )
    told = [
        "--headless",
        "--no-sandbox",
        "--disable-gpu",
        f"--window-size={width},1500",
        "--virtual-time-budget=8000",
    ]
    command = [
        CHROMIUM,
        *told,
        f"--user-data-dir={tmp_path / 'profile'}",
        "--host-resolver-rules=MAP * ~NOTFOUND",
        "--dump-dom",
    ]
    done = subprocess.run(
        [*command, f"file://{tmp_path / 'report.html'}"],
        capture_output=True,
        text=True,
        timeout=120,
        check=True,
    )
    seen = json.loads(re.search(r"<title>(\{.*?\})</title>", done.stdout)[1])
    assert seen["wide"] <= seen["seen"] and seen["lines"] >= 8 and seen["image"] == 90
