"""± is one standard deviation wherever it is printed; an interval has both its ends."""

import ast
import re
from types import SimpleNamespace

import pandas as pd
import pytest
from packages import FOLDERS, ROOT

from benchtwin.bench.numbers import plus_minus
from benchtwin.diagnose.words import verdict_in_words
from benchtwin.infer.effect import Effect
from benchtwin.infer.finding import Finding
from benchtwin.infer.power_law import Term
from benchtwin.infer.verdict import EffectEstimate, Interval
from benchtwin.page.views.results import _mean
from benchtwin.vision.measurement import GOOD, Observation, Quantity
from benchtwin.vision.pile.repose import if_known
from benchtwin.vision.summary import summarise
from benchtwin.vision.terminal import show_results

SD, VALUE = 2.5, 30.0  # the interval: 25.1 to 34.9
ENDS = re.compile(r"25\.[01]\d* to (35\.0|34\.9)")


def terminal(capsys, tmp_path) -> str:
    rows = [(f"s{k}", "slide_angle", VALUE, SD, "deg", GOOD, "") for k in range(2)]
    columns = ["recording", "quantity", "value", "sd", "unit", "quality", "reason"]
    q = Quantity("slide_angle", VALUE, SD, "deg")
    each = [Observation(f"s{k}", "slide", (q,), bench="b") for k in range(2)]
    means = summarise(each)
    show_results(pd.DataFrame(rows, columns=columns), means, (), (), tmp_path)
    return capsys.readouterr().out


def page(*_) -> str:
    row = SimpleNamespace(
        rig="slide",
        quantity="slide_angle",
        conditions="",
        mean=VALUE,
        low=VALUE - 1.96 * SD,
        high=VALUE + 1.96 * SD,
        unit="deg",
        n=2,
        scatter=1.0,
        outliers="",
    )
    return " ".join(map(str, _mean(row).values()))


def diagnosis(*_) -> str:
    size = Interval(VALUE, VALUE - 1.96 * SD, VALUE + 1.96 * SD)
    found = Finding(
        "drop",
        ("a", "b"),
        True,
        1e-9,
        (),
        None,
        "",
        "name",
        ("drag",),
        9.0,
        9.0,
        {},
        None,
        None,
        None,
        explanations=((("drag",), 1.0),),
        effects={"drag": EffectEstimate(1.0, "1", size)},
    )
    return verdict_in_words(found)


def law(*_) -> str:
    effect = Effect(
        "law", "flight", "1", "", 1.0, 0.0, 1.0, "", wording=("a law", "of the weight")
    )
    return Term("a push", effect, VALUE, SD).in_words()


@pytest.mark.parametrize("outlet", [terminal, page, diagnosis, law])
def test_an_interval_has_both_ends_and_no_plus_minus(outlet, capsys, tmp_path):
    said = outlet(capsys, tmp_path)
    assert ENDS.search(said), said
    after = re.findall(r"± *([\d.]+)", said)
    assert all(float(number) == SD for number in after), said


def test_plus_minus_is_the_sd():
    assert plus_minus(VALUE, SD, "deg") == "30.0 ± 2.5°"
    vague = if_known(Quantity("repose_angle", VALUE, 6.0, "deg"))
    assert "± 6°" in vague.reason


def scaled_after_plus_minus(source: str) -> list[str]:
    """Numbers that are formatted after "±" and are no standard deviations: multiples of
    1.96, halves of intervals."""
    found = []
    for node in ast.walk(ast.parse(source)):
        if not isinstance(node, ast.JoinedStr):
            continue
        for before, after in zip(node.values, node.values[1:]):
            text = before.value if isinstance(before, ast.Constant) else ""
            if str(text).rstrip().endswith("±") and isinstance(
                after, ast.FormattedValue
            ):
                said = ast.unparse(after.value)
                if re.search(r"1\.96|SDS_95|half|low|high", said):
                    found.append(said)
    return found


def test_no_text_of_ours_prints_anything_else_after_it():
    wrong = {
        str(file.relative_to(ROOT)): found
        for folder in FOLDERS
        for file in (ROOT / folder).rglob("*.py")
        if (found := scaled_after_plus_minus(file.read_text(encoding="utf8")))
    }
    # by how much a stated height is too low, with the sd of that
    assert {k: v for k, v in wrong.items() if v != ["self.low_sd_mm"]} == {}


def test_the_scan_sees_a_half_interval():
    assert scaled_after_plus_minus('f"{x} ± {1.96 * sd:.2g}"') == ["1.96 * sd"]
