"""Who keeps what he says lies within the bounds of his bins; who is too sure lies outside. What is not said is not nought."""

import numpy as np
import pytest

from prove.figures import reliability_figure
from prove.judge import Judged, judge
from prove.make import Concealed, Key
from prove.reliability import EDGES, FLOOR, log_score, reliability
from prove.score import table
from prove.solve import Attempt

TIME = Attempt("case", 2.0, 0, "")


def key(*effects: Concealed, kind="single") -> Key:
    return Key("case", "drop", kind, effects, ("flight",) if len(effects) == 1 else (), None, False)


def drag() -> Concealed:
    return Concealed("drag", 0.02, "1", 20.0)


def said(verdict, *names, **more) -> dict:
    return {"rigs": {"drop": {"alarm": verdict != "none", "verdict": verdict, "names": names, **more}}}


def solver(kept: float, rng: np.random.Generator) -> list[Judged]:
    """A thousand names of drag, said with p and right with p to the power of `kept`."""
    out = []
    for p in rng.uniform(0.3, 1.0, 1000):
        truth = drag() if rng.random() < p**kept else Concealed("magnus", 1.0, "1", 20.0)
        explanations = [{"effects": ["drag"], "probability": p}, {"effects": ["magnus"], "probability": 1 - p}]
        out.append(judge(key(truth), said("name", "drag", p_verdict=p, explanations=explanations), TIME))
    return out


def test_who_keeps_what_he_says_lies_within_and_who_is_too_sure_does_not():
    rng = np.random.default_rng(3)
    honest, boaster = reliability(solver(1.0, rng)), reliability(solver(3.0, rng))
    assert len(honest) == len(boaster) == len(EDGES) - 1 and sum(b.n for b in honest) == 1000
    assert all(b.holds for b in honest)
    assert not any(b.holds for b in boaster[:4]) and all(b.said > b.bounds[1] for b in boaster[:4])


def test_the_log_score_is_best_for_who_says_what_he_knows():
    rng = np.random.default_rng(4)
    honest, boaster = (log_score(solver(kept, rng)) for kept in (1.0, 3.0))
    expected = np.mean([p * np.log(p) + (1 - p) * np.log(1 - p) for p in np.linspace(0.3, 0.999, 500)])
    assert honest[0] == pytest.approx(expected, abs=3 * honest[1])
    assert boaster[0] < honest[0] - 0.1
    ruled_out = judge(key(drag()), said("none", explanations=[{"effects": [], "probability": 1.0}]), TIME)
    assert log_score([ruled_out])[0] == pytest.approx(np.log(FLOOR))


def test_what_is_not_said_is_missing_and_not_nought():
    silent = judge(key(drag()), said("name", "drag"), TIME)
    assert silent.p is None and silent.p_truth is None
    assert reliability([silent]) == [] and log_score([silent])[2] == 0
    rows = {r.score: r for r in table([silent], np.random.default_rng(0)) if r.rig == "all"}
    assert rows["no p_verdict"].k == rows["no explanations"].k == 1
    assert not any(name.startswith(("log score", "right, of")) for name in rows)


STRANGE = key(Concealed("field", 1.0, None, 20.0, scored=False), kind="outside")
PAIR = key(drag(), Concealed("plate-tilt", 1.0, "deg", 15.0), kind="compound")
LAW = key(Concealed("plastic-restitution", 0.1, "1", 20.0))


@pytest.mark.parametrize(("truth", "verdict", "names", "kept"), [
    (key(kind="clean"), "none", (), True),
    (key(kind="clean"), "class", ("drag", "magnus"), False),
    (key(drag()), "none", (), False),
    (key(drag()), "class", ("drag", "magnus"), True),
    (key(drag()), "unknown", (), False),
    (STRANGE, "unknown", (), True),
    (STRANGE, "class", ("drag", "magnus"), False),
    (PAIR, "name", ("drag",), False),
    (PAIR, "name", ("plate-tilt", "drag"), True),
    (LAW, "class", ("restitution-falls-with-speed", "drag"), True),
])  # fmt: skip
def test_a_verdict_is_right_as_its_probability_means_it(truth, verdict, names, kept):
    assert judge(truth, said(verdict, *names), TIME).as_said is kept


@pytest.mark.parametrize(("truth", "p"), [(STRANGE, 0.3), (PAIR, 0.2), (LAW, 0.1), (key(kind="clean"), 0.25), (key(drag()), 0.0)])
def test_the_true_set_is_found_among_the_explanations(truth, p):
    sets = {(): 0.25, ("(unlisted) flight",): 0.3, ("(unlisted) impact",): 0.15, ("plate-tilt", "drag"): 0.2,
            ("restitution-falls-with-speed",): 0.1}  # fmt: skip
    explanations = [{"effects": list(names), "probability": value} for names, value in sets.items()]
    assert judge(truth, said("none", explanations=explanations), TIME).p_truth == pytest.approx(p)


def test_the_figure_marks_what_does_not_hold():
    colours = [reliability_figure(solver(kept, np.random.default_rng(3)))["data"][1]["marker"]["color"] for kept in (1.0, 3.0)]
    assert len(set(colours[0])) == 1 and colours[1][0] != colours[0][0]
