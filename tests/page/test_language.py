"""The page speaks the language of the browser, or the one that the command was given;
nothing is decided by how it says something."""

import json
import re
from pathlib import Path

import pytest

from benchtwin.bench import language
from benchtwin.page.form import form, needed
from benchtwin.page.guard import first_known
from benchtwin.page.measuring import version
from benchtwin.page.views.frame import SAID
from benchtwin.vision.recording import read_recording

from .visitor import Visitor

SAYS = {
    "Recordings": "录像",
    "Results": "结果",
    "Add files": "添加文件",
    "Sorting …": "整理中 …",
    "Nothing yet: calibrate or diagnose first.": "尚无内容",
}
IN_CHINESE = (  # the command, with a catalogue of these sentences alone
    "-c",
    "from benchtwin.bench import language as l; l.catalogue = lambda spoken:"
    f" {SAYS!r} if spoken == 'zh' else {{}};"
    " from benchtwin.command_line import main; main()",
)


@pytest.fixture
def chinese(monkeypatch):
    """A catalogue that says every sentence in other words."""

    class Other(dict):
        def get(self, sentence, default=None):
            return "".join(
                part if part.startswith("{") else "字" * len(part)
                for part in re.split(r"(\{[^}]*\})", sentence)
            )

    monkeypatch.setattr(language, "catalogue", lambda spoken: Other())
    monkeypatch.setenv(language.VARIABLE, "zh")


@pytest.mark.parametrize(
    ("accepted", "spoken"),
    [
        ("zh-CN,zh;q=0.9,en;q=0.8", "zh"),
        ("en-GB,en;q=0.9,zh;q=0.1", "en"),
        ("de, fr;q=0.7, zh;q=0.3", "zh"),
        ("de", "en"),
        ("*", "en"),
    ],
)
def test_the_first_known_language_of_a_browser(accepted, spoken):
    assert first_known(accepted) == spoken


def asked_in(visitor: Visitor, accepted: str, path: str) -> str:
    visitor.opener.addheaders = [("Accept-Language", accepted)]
    return visitor.get(path)[1].decode()


def said_to_scripts(page: str) -> dict[str, str]:
    found = re.search(r"window\.sentences = (\{.*?\})</script>", page)
    assert found
    return json.loads(found[1])


def test_the_page_speaks_the_language_of_the_browser(tmp_path, serve, monkeypatch):
    monkeypatch.delenv(language.VARIABLE, raising=False)
    with serve(tmp_path, program=IN_CHINESE) as address:
        visitor = Visitor(address)
        chinese = asked_in(visitor, "zh-CN,zh;q=0.9", "/")
        english = asked_in(visitor, "en-US,en;q=0.9", "/")
        sheet = asked_in(visitor, "zh", "/next?bench=.")
    assert '<html lang="zh-CN"' in chinese and '<html lang="en-US"' in english
    for words in ("Recordings", "Results", "Add files"):
        assert words in english and SAYS[words] not in english
        assert SAYS[words] in chinese
        assert f'"{words}"' not in chinese
    assert "tab=Results" in chinese  # an address says the same in all languages
    assert said_to_scripts(chinese)["Sorting …"] == SAYS["Sorting …"]
    assert said_to_scripts(english)["Sorting …"] == "Sorting …"
    assert '<html lang="zh">' in sheet and "尚无内容" in sheet


def test_the_language_that_the_command_was_given_holds(tmp_path, serve, monkeypatch):
    monkeypatch.delenv(language.VARIABLE, raising=False)
    with serve(tmp_path, "--language", "en", program=IN_CHINESE) as address:
        page = asked_in(Visitor(address), "zh", "/")
    assert "Recordings" in page and SAYS["Recordings"] not in page


def test_every_sentence_of_the_scripts_is_handed_over():
    static = Path(language.__file__).parents[1] / "page" / "static"
    texts = [file.read_text(encoding="utf8") for file in static.glob("*.js")]
    calls = sum(len(re.findall(r"\btr\(", text)) for text in texts)
    known = sum(text.count(f"tr('{one}'") for text in texts for one in SAID)
    assert calls == known > 30


@pytest.fixture
def recording(tmp_path):
    place = tmp_path / "drop-01"
    place.mkdir()
    (place / "track.csv").write_text("t_s,x_mm,y_mm\n0,0,100\n0.01,0,99\n")
    (place / "recording.toml").write_text('rig = "drop"\n[camera]\nfps = 240\n')
    return read_recording(place)


@pytest.mark.parametrize(
    "why",
    [
        "a/recording.toml: [drop] height_mm is missing; without it",
        "缺少[drop] height_mm，没有它就没有恢复系数；[camera] fps 为 240",
        "[drop] height_mm缺失",
    ],
)
def test_keys_that_are_asked_for_are_told_by_their_places(recording, why):
    assert needed([why, "in [brackets] only"], recording) == {("drop", "height_mm")}


def test_the_form_decides_nothing_by_its_words(chinese):
    content = {"blue": 1}
    found = {(f.section, f.key): f for s in form("drop", content, {}) for f in s.fields}
    assert found["drop", "drops"].rare and not found["drop", "height_mm"].rare
    assert found["", "blue"].read("") is None
    with pytest.raises(ValueError, match=r"^blue字+$"):
        found["", "blue"].read("2")


def test_what_was_measured_is_remembered_by_language(recording, monkeypatch):
    monkeypatch.setenv(language.VARIABLE, "en")
    english = version(recording)
    monkeypatch.setenv(language.VARIABLE, "zh")
    assert version(recording) != english
    monkeypatch.setenv(language.VARIABLE, "en")
    assert version(recording) == english
