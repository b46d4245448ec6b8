"""What a finding says: as diagnosis.json, in a sentence, in the terminal."""

import json
import math
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import pytest
from benchtwin.diagnose import words
from benchtwin.diagnose.bench import Diagnosis
from benchtwin.infer.finding import Finding, Parameter, Sector
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
    ((("drag",), 0.96), ((), 0.003)),
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


def test_a_name_says_its_probability_its_number_and_what_it_does():
    lead = "air drag is missing (99.7 %): 0.0180 ± 0.0020 of the weight at 2 m/s"
    assert (
        said() == f"{lead}; left out, restitution reads 0.79 % too low, 0.78 of its sds"
    )
    assert said(contact={}) == lead
    assert said(matters=False) == f"found, but it moves nothing that matters: {lead}"


def test_nothing_missing_says_how_sure_that_is():
    none = {
        "verdict": "none",
        "names": (),
        "p_verdict": 0.82,
        "p_global": 0.4,
        "matters": False,
    }
    assert (
        said(**none)
        == "nothing is missing that 10 recordings show (82 %; noise alone: p = 0.4)"
    )


def test_a_class_says_what_is_certain_and_what_is_not_told_apart():
    effects = {
        "scale-error": EffectEstimate(0.62, "1", DRAG.size),
        "clock-error": EffectEstimate(0.36, "1", DRAG.size),
    }
    apart = {"verdict": "class", "contact": {}, "p_verdict": 0.98}
    line = (
        "something is missing in flight: scale-error (62 %) or clock-error (36 %);"
        " these recordings do not tell which"
    )
    assert said(names=tuple(effects), effects=effects, **apart) == line
    line = said(
        names=("drag", "scale-error"), effects=effects | {"drag": DRAG}, **apart
    )
    assert line.endswith(
        "at 2 m/s; beside it, not settled: the scale is wrong (62 %)"
    ) and line.startswith("air drag is missing (99.7 %)")
    alone = said(names=("clock-error",), effects=effects, **apart)
    assert "the likely reason, not settled: the frame rate is wrong (36 %)" in alone


def test_what_no_known_effect_explains_says_its_law_or_when():
    strange = {
        "verdict": "unknown",
        "names": (),
        "contact": {},
        "effects": {},
        "p_verdict": 0.97,
    }
    line = "something is missing in flight that no known effect explains (97 %)"
    assert said(**strange, law="a force along +x") == f"{line}: a force along +x"
    drift = ((("restitution-follows-order",), 0.9), ((), 0.1))
    assert said(**strange, explanations=drift).endswith(
        "(97 %): restitution changes with the order of the recordings, and nothing"
        " stated says why"
    )
    beside = said(**strange | {"names": ("drag",), "effects": {"drag": DRAG}})
    assert (
        beside.startswith("air drag is missing (99.7 %)")
        and "something else is missing in flight" in beside
    )


def test_a_parameter_that_follows_a_condition_says_by_how_much():
    slope = EffectEstimate(0.9971, "per pct", Interval(-0.0080, -0.0092, -0.0068))
    of = {"rig": "slide", "names": (FOLLOWS,), "contact": {}}
    line = (
        "static friction falls by 0.0080 ± 0.0012 per % moisture (moisture_pct), in all"
        " 10 slides (99.7 %)"
    )
    assert said(**of, effects={FOLLOWS: slope}) == line
    assert "rises by 0.0080 ± 0.0012 per %" in said(
        **of, effects={FOLLOWS: replace(slope, size=Interval(0.0080, 0.0068, 0.0092))}
    )
    levels = {
        "steel": Interval(0.02, 0.018, 0.022),
        "glass": Interval(-0.02, -0.022, -0.018),
    }
    plate = EffectEstimate(0.999, "1", levels["steel"], levels)
    line = said(
        **of | {"names": ("static_friction-follows-plate",)},
        effects={"static_friction-follows-plate": plate},
    )
    each = "steel +0.0200 ± 0.0020, glass −0.0200 ± 0.0020"
    assert (
        line
        == "static friction follows plate, in all 10 slides (99.9 %); beside the mean"
        f" of all: {each}"
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
