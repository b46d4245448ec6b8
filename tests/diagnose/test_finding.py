"""What a finding says: as diagnosis.json, in a sentence, in the terminal."""

import json
import math
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from benchtwin.diagnose import words
from benchtwin.diagnose.bench import Diagnosis
from benchtwin.infer.explanation import UNSHAPED
from benchtwin.infer.finding import Curve, Finding, Parameter, Sector
from benchtwin.infer.follow import Follow, Point
from benchtwin.infer.held_out import HeldOut
from benchtwin.infer.verdict import EffectEstimate, Interval, ParameterShift

NAMES = tuple(f"drop-{k}" for k in range(10))
DRAG = EffectEstimate(0.997, "1", Interval(0.018, 0.016, 0.020))
E = ParameterShift(Interval(0.500, 0.490, 0.510), Interval(0.504, 0.493, 0.515))
FOLLOWS = "static_friction-follows-moisture_pct"
USUAL = Finding(
    "drop",
    NAMES,
    True,
    1e-9,
    (Sector("flight", 0.97, 1e-12), Sector("impact", math.nan, 0.3)),
    None,
    "",
    "name",
    ("drag",),
    55.0,
    math.nan,
    {"drag": Parameter("1", 0.018, 0.016, 0.020)},
    None,
    HeldOut(0.9, math.nan),
    None,
    0.96,
    True,
    ((("drag",), 0.96), (("drag", "plate-tilt"), 0.037), ((), 0.003)),
    {"drag": DRAG},
    {"restitution": E},
    left_out={"drag": (0.018,) * 10},
)


def said(**change) -> str:
    return words.verdict_in_words(replace(USUAL, **change))


def test_json_is_plain_with_null_for_what_is_absent():
    told = USUAL.to_json()
    assert json.loads(json.dumps(told, allow_nan=False)) == told
    assert told["ln_bayes_runner_up"] is None and told["held_out"] == {
        "rmse_ratio": 0.9,
        "removed_fraction": None,
    }
    assert told["explanations"] == [
        {"effects": ["drag"], "probability": 0.96},
        {"effects": ["drag", "plate-tilt"], "probability": 0.037},
        {"effects": [], "probability": 0.003},
    ]
    drag = {
        "probability": 0.997,
        "unit": "1",
        "value": 0.018,
        "low95": 0.016,
        "high95": 0.020,
    }
    assert drag.items() <= told["effects"]["drag"].items()
    restitution = told["contact_parameters"]["restitution"]
    assert restitution["explained"]["value"] == 0.504 and restitution[
        "shift_sds"
    ] == pytest.approx(0.784, abs=1e-3)
    assert told["matters"] is True and told["p_verdict"] == 0.96


NEVER = "; noise alone would do this in fewer than 1 of 10 000 benches"


def test_a_name_leads_with_what_it_does_then_its_probability_and_its_number():
    """Drag is in all but 0.3 % of what may be missing, alone in 96 %."""
    name = (
        "air drag is missing (99.7 %), and nothing else (96 %): 0.0180 of the weight at"
        " 2 m/s (95 %: 0.0160 to 0.0200)"
    )
    moved = "restitution reads 0.79 % too low (0.78 of its sds) because"
    assert said() == f"{moved} {name}{NEVER}"
    assert said(contact={}) == name + NEVER
    quiet = f"found, but it moves nothing that matters: {name}{NEVER}"
    assert said(matters=False) == quiet and words.tone(USUAL) == "name"
    assert words.tone(replace(USUAL, matters=False)) == "quiet"


def test_what_does_not_matter_says_by_how_much_a_path_moves():
    """The greatest difference between what baseline and model leave, of curves in mm
    only."""
    along, base = np.arange(4.0), np.array([0.1, -0.2, 0.3, 0.0])
    path = Curve("a", "travel", "mm", "t_s", along, along, base, np.zeros(4))
    ratios = Curve("a", "e", "1", "v_m_s", along, along, 9 * base, np.zeros(4))
    moved = replace(USUAL, curves=(path, ratios), matters=False)
    assert moved.to_json()["moves_mm"] == pytest.approx(0.3)
    assert "; it moves a path by 0.3 mm at most;" in words.verdict_in_words(moved)
    assert "path" not in words.verdict_in_words(replace(moved, matters=True))
    unknown = replace(moved, verdict="unknown", names=())  # its fit does not hold it
    assert unknown.to_json()["moves_mm"] is None
    none = replace(moved, alarm=False, verdict="none", names=())
    assert none.to_json()["moves_mm"] is None and "path" not in words.verdict_in_words(
        none
    )


def test_two_effects_are_one_set_and_what_else_is_possible_is_said():
    both = (("drag", "scale-error"), 0.78)
    sentence = said(
        names=("drag", "scale-error"),
        p_verdict=0.78,
        effects={"drag": DRAG, "scale-error": replace(DRAG, probability=0.8)},
        contact={},
        explanations=(both, (("drag",), 0.15), (("drag", UNSHAPED), 0.07)),
    )
    assert sentence == (
        "air drag is missing and the scale is wrong (78 %), and nothing else (78 %):"
        " drag 0.0180 of the weight at 2 m/s (95 %: 0.0160 to 0.0200); scale-error"
        " 0.0180 = true/stated − 1 (95 %: 0.0160 to 0.0200);"
        f" also possible: air drag is missing (15 %){NEVER}"
    )


def test_nothing_missing_says_how_sure_that_is_and_what_else_may_be():
    none = {
        "verdict": "none",
        "names": (),
        "p_verdict": 0.82,
        "p_global": 0.41,
        "matters": False,
        "explanations": (((), 0.82), (("drag",), 0.06)),
    }
    shown = "nothing was shown to be missing in the 10 recordings"
    noise = "noise alone would do this in"
    assert said(**none) == f"{shown} (82 % that nothing is); {noise} 4 of 10 benches"
    assert words.tone(replace(USUAL, **none)) == "sure"
    doubt = none | {
        "p_verdict": 0.34,
        "p_global": 0.13,
        "explanations": (((), 0.34), (("drag",), 0.3), (("drag", UNSHAPED), 0.2)),
    }
    assert said(**doubt) == (
        f"{shown} (34 % that nothing is); also possible: air drag is missing (30 %),"
        " air drag is missing and something that no known effect explains (20 %);"
        f" {noise} 1 of 8 benches"
    )
    assert words.tone(replace(USUAL, **doubt)) == "open"


def test_a_class_says_each_set_with_its_own_probability():
    of = {
        "verdict": "class",
        "contact": {},
        "p_verdict": 0.98,
        "names": ("scale-error", "clock-error"),
    }
    sets = ((("scale-error",), 0.62), (("clock-error",), 0.36), ((), 0.02))
    assert said(**of, explanations=sets) == (
        "the scale is wrong (62 %) or the frame rate is wrong (36 %), which these"
        f" recordings do not tell apart (98 % together){NEVER}"
    )
    alone = {"names": ("drag",), "explanations": ((("drag",), 0.7), ((), 0.3))}
    assert said(**of | alone) == (
        "air drag is missing (70 %), not for certain; also possible: nothing is missing"
        f" (30 %){NEVER}"
    )


def test_what_no_known_effect_explains_says_its_law_or_when():
    gp = "(unlisted) flight: along by t_s"
    strange = {
        "verdict": "unknown",
        "names": (),
        "contact": {},
        "effects": {},
        "p_verdict": 0.97,
        "explanations": (((gp,), 0.9), (("drag", UNSHAPED), 0.07), ((), 0.03)),
        "unlisted": frozenset({gp, UNSHAPED}),
    }
    line = "something is missing in flight that no known effect explains (97 %)"
    assert said(**strange, law="a force along +x") == f"{line}: a force along +x{NEVER}"
    drift = following("restitution", "order", "line", (0.02, -0.02), (0, 9))
    told = said(**strange | {"contact": {"restitution": E}}, follows=(drift,))
    assert told.endswith(
        f"{line}: restitution falls with the order of the recordings: 0.5240 at the"
        f" first to 0.4840 at the last, and nothing stated says why{NEVER}"
    )
    sets = ((("drag", gp), 0.97), (("drag",), 0.03))
    beside = said(**strange | {"names": ("drag",), "explanations": sets})
    assert beside == f"air drag is missing, and beside it {line}{NEVER}"


def following(parameter, condition, shape, sizes, at, levels=()) -> Follow:
    """Sizes ± 0.002; a straight line's slope is −0.0080 ± 0.0012."""
    curve = tuple(
        Point(x, Interval(s, s - 0.002, s + 0.002))
        for x, s in zip(at, sizes, strict=True)
    )
    slope = Interval(-0.0080, -0.0092, -0.0068)
    return Follow(
        parameter,
        condition,
        shape,
        1e-6,
        0.997,
        slope,
        curve,
        levels,
        {},
        {},
        {},
        {},
        condition == "order",
    )


def test_a_parameter_that_follows_a_condition_says_by_how_much():
    slope = following("static_friction", "moisture_pct", "line", (0.02, -0.02), (8, 13))
    sets = (((FOLLOWS,), 0.96), ((), 0.04))
    of = {"rig": "slide", "names": (FOLLOWS,), "contact": {}, "explanations": sets}
    line = (
        "static friction falls by 0.00800 (95 %: 0.00680 to 0.00920) per % moisture"
        " (moisture_pct)"
        " (96 %), and nothing else (96 %)"
    )
    assert said(**of, follows=(slope,)) == line + NEVER
    plate = following(
        "static_friction", "plate", "levels", (0.02, -0.02), (0, 1), ("steel", "glass")
    )
    sets = (((plate.name,), 0.96), ((), 0.04))
    line = said(**of | {"names": (plate.name,), "explanations": sets}, follows=(plate,))
    each = (
        "steel +0.0200 (95 %: 0.0180 to 0.0220), glass −0.0200 (95 %: −0.0220 to"
        " −0.0180)"
    )
    assert line == (
        f"static friction follows plate (beside the mean of all: {each}) (96 %), and"
        f" nothing else (96 %){NEVER}"
    )


def test_a_curve_is_told_by_its_ends_on_a_line_of_its_own():
    """Beside a flight misfit that is no name."""
    shares = {"names": (), "verdict": "unknown", "contact": {"restitution": E}}
    bent = following(
        "restitution", "pressure_kpa", "levelling off", (-0.19, 0.1, 0.14), (20, 50, 90)
    )
    bench = {"drop": replace(USUAL, **shares, follows=(bent,))}
    told = words.lines(Diagnosis(Path(), bench, {}, {}, ()))
    assert told[1] == (
        "  restitution rises with pressure_kpa, levelling off: 0.3140 at 20 to 0.6440"
        " at 90 (p < 0.0001)"
    )
    ends = following(
        "restitution", "pressure_kpa", "lowest", (0.1, -0.1, 0.1), (20, 50, 90)
    )
    assert words.follow_in_words(ends, bench["drop"]) == (
        "restitution is lowest in the middle of pressure_kpa: 0.6040 at 20, 0.4040 near"
        " 50, 0.6040 at 90"
    )


def test_findings_that_do_not_matter_are_one_line():
    loud, quiet = (
        replace(USUAL, matters=m, next_record="another drop") for m in (True, False)
    )
    again = SimpleNamespace(in_words=lambda: "run again")
    lines = [
        words.lines(Diagnosis(Path(), {"drop": f}, {}, {}, (), twins={"drop": again}))
        for f in (loud, quiet)
    ]
    assert (
        lines[0][1:] == ["  to settle it, record: another drop", "  run again"]
        and len(lines[1]) == 1
    )
