"""Numbers bear the digits of their standard deviation, and an absurd one is said."""

import math

import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as st

from benchtwin.bench.conditions import MEASURED
from benchtwin.bench.numbers import (
    EXACT_SHARE,
    exact_by_mistake,
    stored,
    with_sd,
)
from benchtwin.vision.find_recordings import find_recordings
from benchtwin.vision.measurement import DOUBTFUL, GOOD, Observation, Quantity
from benchtwin.vision.results import Results
from benchtwin.vision.summary import summarise
from benchtwin.vision.terminal import show_results

VALUES = st.floats(-1e6, 1e6).filter(lambda x: abs(x) > 1e-6)
SDS = st.floats(1e-9, 1e6)


@given(VALUES, SDS)
def test_two_digits_of_the_sd_are_shown_and_no_more(value, sd):
    """The value as shown is within half of the sd's second digit."""
    if sd < EXACT_SHARE * abs(value):
        return
    shown, error = with_sd(value, sd)
    unit = 10.0 ** (math.floor(math.log10(float(f"{sd:.1e}"))) - 1)
    read = float(shown.replace("−", "-"))
    assert abs(read - value) <= 0.501 * unit + 1e-9 * abs(value)
    assert float(error) == pytest.approx(float(f"{sd:.1e}"), rel=0.051)


@given(VALUES, SDS)
def test_a_table_keeps_a_ten_thousandth_of_the_sd_in_twelve_digits(value, sd):
    text = stored(value, sd)
    digits = text.split("e")[0].lstrip("-").replace(".", "").lstrip("0")
    assert len(digits) <= 12
    assert abs(float(text) - value) <= max(1e-4 * sd, 1e-11 * abs(value))


def test_what_is_not_known_is_not_made_up():
    assert with_sd(math.nan, 1.0) == ("–", "") and with_sd(2.0, math.nan) == ("2", "")
    assert stored(math.nan, 1.0) == "" and stored(0.25, math.nan) == "0.25"
    assert exact_by_mistake(2.0, math.nan) == "" == exact_by_mistake(2.0, 1e-3)


def test_a_reading_of_an_absurdly_small_sd_is_doubted(monkeypatch, tmp_path):
    """Whatever measured it: all measurements pass `observe`."""
    from benchtwin.measure import observe as module

    folder = tmp_path / "bench" / "drop"
    folder.mkdir(parents=True)
    (folder / "recording.toml").write_text('rig = "drop"\n')
    (folder / "impacts.csv").write_text("t_s\n0\n0.3\n0.5\n")
    (recording,) = find_recordings(tmp_path / "bench")
    quantities = (
        Quantity("restitution", 0.5, 1e-17, "1"),
        Quantity("impact_speed", 3.0, 0.01, "m/s"),
    )
    monkeypatch.setattr(
        module, "_observe", lambda *_: Observation("drop", "drop", quantities)
    )
    absurd, usual = module.observe(recording).quantities
    assert absurd.quality == DOUBTFUL and "1e-17 is smaller than any" in absurd.reason
    assert absurd.in_words == "restitution 0.5 ± 1e-17"
    assert usual == quantities[1]


def test_one_number_many_times_is_no_more_certain_than_once(capsys, tmp_path):
    """The speed of a fall from the same stated height, n times: the sd of each stays,
    rounding of the last bit is no scatter."""
    speeds = (3.5513237421819417, 3.5513237421819421, 3.5513237421819417)
    each = [Quantity("impact_speed", v, 0.05, "m/s") for v in speeds]
    observations = [
        Observation(f"d{k}", "drop", (q,), bench="b") for k, q in enumerate(each)
    ]
    (line,) = summarise(observations)
    assert line.all_equal and (line.high - line.low) / 2 == pytest.approx(1.96 * 0.05)
    show_results(pd.DataFrame(columns=[*MEASURED]), [line], (), (), tmp_path)
    printed = capsys.readouterr().out
    assert "3.551 (3.453 to 3.649)" in printed and "one number 3 times" in printed


def test_tables_hold_what_the_sd_bears(tmp_path):
    out = Results(tmp_path / "out")
    for k, value in enumerate((1234567.891234, 1234567.902)):
        q = Quantity("place", value, 0.02, "mm", GOOD)
        out.add(Observation(f"r{k}", "drop", (q,), bench="b"))
    out.finish()
    text = (tmp_path / "out" / "measurements.csv").read_text()
    assert "1234567.89123," in text and "1234567.902," in text
    line = pd.read_csv(tmp_path / "out" / "summary.csv").iloc[0]
    assert line["mean"] == pytest.approx(1234567.896617, abs=1e-5)
