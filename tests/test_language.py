"""Sentences in another language: all are translated, and nothing but the sentences
changes with the language."""

import json
import string
import subprocess
import sys
from collections import Counter
from pathlib import Path

import pandas as pd
import polib
import pytest

import benchtwin
from benchtwin.bench import language
from scripts.catalogue import sentences

ROOT = Path(__file__).parent.parent
SAMPLES = ROOT / "samples"
CHINESE = ROOT / "bench" / "zh.po"


def _fields(sentence: str) -> Counter:
    """(format, conversion) of the fields, whatever their order."""
    parts = string.Formatter().parse(sentence)
    return Counter(
        (spec, how or "") for _, name, spec, how in parts if name is not None
    )


def _strange(sentence: str) -> str:
    """The sentence in full-width letters, which nothing written for English finds."""
    out = ""
    for text, name, spec, how in string.Formatter().parse(sentence):
        wide = "".join(chr(ord(c) + 0xFEE0) if c.isalpha() else c for c in text)
        out += wide.replace("{", "{{").replace("}", "}}")
        if name is not None:
            out += (
                "{" + name + (f"!{how}" if how else "") + (f":{spec}" if spec else "")
            )
            out += "}"
    return out


class Strange(dict):
    """A catalogue that has every sentence."""

    def get(self, sentence: str, default: object = None) -> str:
        return _strange(sentence)


@pytest.fixture
def strange(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(language, "catalogue", lambda spoken: Strange())


def test_every_sentence_is_in_the_catalogue_and_no_other():
    entries = {entry.msgid: entry for entry in polib.pofile(str(CHINESE))}
    assert set(entries) == set(sentences())
    assert [e.msgid for e in entries.values() if not e.msgstr] == []


def test_a_translation_has_the_fields_of_its_sentence():
    wrong = [
        entry.msgid
        for entry in polib.pofile(str(CHINESE))
        if _fields(entry.msgid) != _fields(entry.msgstr)
    ]
    assert wrong == []


def test_fields_may_change_their_order(monkeypatch: pytest.MonkeyPatch):
    turned = {"{} of {}": "{1} 中的 {0}"}
    monkeypatch.setattr(language, "catalogue", lambda spoken: turned)
    assert language.tr("{} of {}", 3, "drop-01") == "drop-01 中的 3"
    assert language.tr("no such sentence, {}", 3) == "no such sentence, 3"


@pytest.mark.parametrize(
    "sample", ["board-heap", "concealed-drop", "gates-roll", "heard-drop"]
)
def test_no_measured_number_hangs_on_the_language(sample: str, request):
    said = benchtwin.measure(SAMPLES / sample)
    request.getfixturevalue("strange")
    again = benchtwin.measure(SAMPLES / sample)
    numbers = ["recording", "quantity", "value", "sd", "unit", "quality"]
    pd.testing.assert_frame_equal(said.quantities[numbers], again.quantities[numbers])
    reasons = pd.concat([said.quantities, again.quantities])["reason"]
    notes = [*said.notes, *again.notes]
    assert len(notes) or reasons.any()  # else nothing was said at all
    assert all(set(said.notes).isdisjoint({note}) for note in again.notes)


@pytest.mark.parametrize("sample", ["concealed-roll", "heard-drop"])
def test_no_verdict_hangs_on_the_language(sample: str, request):
    plain = benchtwin.diagnose(SAMPLES / sample, twin=False).details.to_json()
    request.getfixturevalue("strange")
    strange = benchtwin.diagnose(SAMPLES / sample, twin=False).details.to_json()
    for rig, finding in plain["rigs"].items():
        again = strange["rigs"][rig]
        for told in ("verdict", "names", "p_global", "explanations", "effects"):
            assert json.dumps(finding[told]) == json.dumps(again[told]), (rig, told)


def test_the_command_speaks_chinese_and_english(tmp_path: Path):
    command = [sys.executable, "-m", "benchtwin", "calibrate", "--tables"]
    command += [str(SAMPLES / "soybean-paper"), "--out"]
    for asked, spoken, heading in (
        (["--language", "zh"], "zh", "最可能参数组"),
        ([], "en", "most probable set"),
    ):
        out = tmp_path / spoken
        done = subprocess.run(
            [*command, str(out), *asked], capture_output=True, text=True, check=True
        )
        page = (out / "report.html").read_text(encoding="utf8")
        assert f'<html lang="{spoken}">' in page and heading in page
        assert heading in done.stdout
    numbers = (tmp_path / "zh" / "result.json", tmp_path / "en" / "result.json")
    chinese, english = (json.loads(file.read_text()) for file in numbers)
    for name, told in english["parameters"].items():
        other = chinese["parameters"][name]
        for part in ("value", "low", "high", "status"):
            assert told[part] == other[part]


def test_a_language_that_is_not_there_is_refused():
    command = [sys.executable, "-m", "benchtwin", "seeds", "--language", "tlh"]
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 2
    assert "tlh: no such language; en, zh" in done.stderr
    assert "Traceback" not in done.stderr
