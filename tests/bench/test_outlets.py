"""What came from outside on its way out: every nasty string through every field of a
bench, and out of every outlet."""

import csv
import json
import os
import re
import subprocess
import sys
import tomllib
import zipfile
from html.parser import HTMLParser
from pathlib import Path

import pandas as pd
import pytest
from openpyxl import load_workbook

from benchtwin.bench.conditions import MEASURED
from benchtwin.bench.outlets import FORMULA, NOT_SHOWN, NUMBER, cell, csv_text, plain
from benchtwin.bench.workbook import write_workbook
from benchtwin.calibrate.export import ENGINES, cards, read_result
from benchtwin.command_line import main
from benchtwin.page.downloads import sheet
from benchtwin.page.results import ToRecord
from benchtwin.report.pack import FORMAT, MANIFEST
from benchtwin.shown import html
from benchtwin.vision.evidence.read_keys import read_toml
from benchtwin.vision.measurement import MeasurementError

NASTY = (
    "\x1b[31mred\x1b[0m",
    "\x1b]0;title\x07",
    "\x1b]8;;http://evil.example\x1b\\link\x1b]8;;\x1b\\",
    "\x9b2Jclear",
    "bell\x07back\b\b\rover",
    "a\u202egnp.exe",
    "a\\[/x]b",
    "[link=http://evil.example]a[/link]",
    "[red]a[/]",
    "[/]",
    ":boom:",
    '=HYPERLINK("http://evil.example","a")',
    "=cmd|' /C calc'!A0",
    "+1+cmd",
    "-1+cmd",
    "@SUM(1)",
    "  =1+1",
    "a;=cmd|' /C calc'!A0;\t@b",
    "＝1+1",
    "\t=1+1",
    '"><script>alert(1)</script>',
    "<img src=x onerror=alert(1)>",
    "{{7*7}}",
    "a\nb",
    'x"\nrig = "pile',
    "'''",
    "a # b",
    "%s%n{0}",
)


def in_a_name(text: str) -> str:
    """The text as the name of a file or folder can have it."""
    return re.sub("[/\0\n]", "_", text)


def toml(text: str) -> str:
    return json.dumps(text).replace("\x7f", "\\u007f")


@pytest.fixture(scope="module")
def bench(tmp_path_factory) -> Path:
    """A recording a nasty string, which stands in all fields that take text."""
    bench = tmp_path_factory.mktemp("nasty") / "bench"
    for n, text in enumerate(NASTY):
        folder = bench / f"{n} {in_a_name(text)}"
        folder.mkdir(parents=True)
        said = toml(text)
        (folder / "recording.toml").write_text(
            f'rig = "drop"\nid = {said}\nsession = {said}\n[drop]\nheight_mm = 100.0\n'
            f"[conditions]\nself = {said}\ncount = {said}\nclass = 1.5\n",
            "utf8",
        )
        (folder / "readings.csv").write_text("rebound_height_mm\n30.0\n31.0\n29.5\n")
        broken = bench / f"broken {n} {in_a_name(text)}"
        broken.mkdir()
        (broken / "recording.toml").write_text(f"rig = {said}\n[seed]\n{said} = 1\n")
        (bench / f"stray {n} {in_a_name(text)}").write_text(text, "utf8")
    return bench


def command(*words: object, cwd: Path | None = None) -> subprocess.CompletedProcess:
    line = [sys.executable, "-m", "benchtwin", *map(str, words)]
    env = os.environ | {"FORCE_COLOR": "1", "COLUMNS": "300"}  # as in a terminal
    return subprocess.run(line, capture_output=True, env=env, cwd=cwd, check=False)


@pytest.fixture(scope="module")
def measured(bench):
    out = bench.parent / "measured"
    return command("measure", bench, "--out", out), out


def shown_as_text(raw: bytes) -> str:
    """Of what was printed, all but our own colours; nothing else moves or links."""
    ours = r"\x1b\[[0-9;]*m|\r?\x1b\[(2K|1A|\?25[hl])"  # and our bar's lines
    text = re.sub(ours, "", raw.decode("utf8"))
    assert not NOT_SHOWN.search(text), NOT_SHOWN.search(text)
    return text


def test_the_terminal_shows_text_as_text(measured):
    done, _ = measured
    assert done.returncode == 0, done.stderr.decode()
    text = shown_as_text(done.stdout + done.stderr)
    for whole in ("[link=http://evil.example]a[/link]", r"a\[/x]b", "\\x1b[31mred"):
        assert whole in text, whole
    assert b"\x1b[31mred" not in done.stdout + done.stderr


def test_no_cell_of_a_table_is_a_formula_and_nothing_is_lost(measured):
    _, out = measured
    seen = set()
    for file in out.glob("*.csv"):
        rows = list(csv.reader(file.open(encoding="utf8", newline="")))
        for row in rows:
            for one in row:
                assert not NOT_SHOWN.search(one)
                assert not FORMULA.search(one) or NUMBER.fullmatch(one), one
        seen |= {one for row in rows for one in row}
    assert {cell(text) for text in NASTY} <= seen
    numbers = pd.read_csv(out / "measurements.csv")["value"].dropna()
    assert pd.api.types.is_float_dtype(numbers) and len(numbers) > len(NASTY)


def test_no_cell_of_a_workbook_is_a_formula(measured):
    _, out = measured
    kinds = {
        one.data_type
        for sheet in load_workbook(out / "results.xlsx")
        for row in sheet.iter_rows()
        for one in row
    }
    assert "f" not in kinds and "n" in kinds


def elements(page: str) -> set[str]:
    found = set()

    class Parser(HTMLParser):
        def handle_starttag(self, tag, attrs):
            found.add(tag)
            did = [what for name, what in attrs if name.startswith("on")]
            assert set(did) <= {"print()"}, did  # our own button

    Parser().feed(page)
    return found


def test_html_holds_no_element_of_theirs(measured):
    table = pd.DataFrame({text: [text] for text in NASTY})
    pages = [html(text, table, [text]) for text in NASTY]
    pages += [sheet(text, {text: [ToRecord(text, text)]}) for text in NASTY]
    for page in pages:
        assert not elements(page) & {"script", "img"}
    _, out = measured
    for page in out.rglob("*.html"):
        assert "script" not in elements(page.read_text("utf8"))


def test_import_writes_toml_that_says_no_more(tmp_path):
    """Names of foreign files stand in comments of what is drafted."""
    for n, text in enumerate(NASTY):
        rows = "".join(f"{k / 100},{k},{100 - k * k / 9}\n" for k in range(40))
        (tmp_path / f"{in_a_name(text)} {n}.csv").write_text("t,x,y\n" + rows, "utf8")
    done = command("import", *tmp_path.glob("*.csv"), "--out", tmp_path / "out")
    shown_as_text(done.stdout + done.stderr)
    drafts = list((tmp_path / "out").rglob("*.toml"))
    assert len(drafts) >= len(NASTY), done.stderr.decode()
    for file in drafts:
        text = file.read_text("utf8")
        assert not NOT_SHOWN.search(text)
        sections = {"rig", "provenance", "camera", "seed", "drop"}
        assert set(tomllib.loads(text)) <= sections


@pytest.mark.parametrize("text", NASTY)
def test_names_in_an_archive_are_shown_as_text(tmp_path, monkeypatch, capsys, text):
    row = {"bytes": 1, "sha256": "0"}
    listed = {"format": FORMAT, "versions": {text: text}, "files": {"a": row}}
    with zipfile.ZipFile(tmp_path / "a.zip", "w") as held:
        held.writestr(MANIFEST, json.dumps(listed))
        held.writestr("a", "a")
        held.writestr(in_a_name(text) + "z", "unlisted")
    monkeypatch.setattr("sys.argv", ["benchtwin", "unpack", str(tmp_path / "a.zip")])
    with pytest.raises(SystemExit):
        main()
    said = shown_as_text("".join(capsys.readouterr()).encode())
    assert "not as packed: a" in said and f"{plain(in_a_name(text))}z" in said


@pytest.mark.parametrize("name", [*MEASURED, "session", "order"])
def test_a_condition_by_the_name_of_a_column_is_one_sentence(tmp_path, name):
    (tmp_path / "bench" / "a").mkdir(parents=True)
    (tmp_path / "bench" / "a" / "recording.toml").write_text(
        f'rig = "drop"\n[drop]\nheight_mm = 100.0\n[conditions]\n{name} = 1.5\n'
    )
    (tmp_path / "bench" / "a" / "readings.csv").write_text("rebound_height_mm\n30.0\n")
    with pytest.raises(MeasurementError) as refused:
        read_toml(tmp_path / "bench" / "a" / "recording.toml")
    (line,) = str(refused.value).splitlines()
    assert f"[conditions] {name}: " in line


def test_conditions_that_are_words_of_python_or_quantities_are_kept(measured):
    _, out = measured
    for name in ("measurements", "readings"):
        table = pd.read_csv(out / f"{name}.csv")
        assert {"self", "count", "class"} <= set(table), name
        good = table[table["recording"].notna() & table["class"].notna()]
        assert len(good) >= len(NASTY) and set(good["class"]) == {1.5}


def test_a_number_of_thousands_of_digits_is_one_sentence(tmp_path):
    file = tmp_path / "recording.toml"
    file.write_text(f"[drop]\nheight_mm = {'9' * 5000}\n")
    with pytest.raises(MeasurementError, match=r"recording\.toml: not valid TOML"):
        read_toml(file)


@pytest.mark.parametrize("text", NASTY)
def test_the_gate_alone(text, tmp_path):
    assert not NOT_SHOWN.search(plain(text))
    rows = list(csv.reader(csv_text(pd.DataFrame({text: [text]})).splitlines(True)))
    assert rows == [[cell(text)], [cell(text)]]
    write_workbook(tmp_path / "a.xlsx", {"a": pd.DataFrame({text: [text]})})
    kinds = [c.data_type for r in load_workbook(tmp_path / "a.xlsx")["a"] for c in r]
    assert kinds == ["s", "s"]


@pytest.mark.parametrize("number", ["-1.5", "+3", "1e-3", "-.5", "-2.25E+10"])
def test_numbers_stay_numbers(number):
    assert cell(number) == number


@pytest.mark.parametrize("engine", ENGINES)
def test_a_folder_s_name_adds_no_line_to_a_program(tmp_path, engine):
    """Cards are read as programs; where the result lay stands in a comment."""
    stated = {"value": 0.3, "low": 0.2, "high": 0.4, "unit": "1"}
    stated |= {"most_probable_set": 0.3, "status": "calibrated", "remark": ""}
    solid = {"density_kg_m3": 1250.0, "shear_modulus_pa": 1e7, "poisson_ratio": 0.4}
    names = ("restitution", "static_friction", "rolling_friction")
    sizes = {"length_mm": 8.7, "width_mm": 6.8, "thickness_mm": 6.0}
    result = {
        "parameters": {f"{who}{n}": stated for who in ("", "seed_") for n in names},
        "conventions": {"rolling": "edem"},
        "materials": {who: solid | {"name": who} for who in ("seed", "wall")},
        "seed_shape": {**sizes, "spheres": [[0, 0, 0, 3.0], [2.0, 0, 0, 2.5]]},
    }
    folder = tmp_path / "a\nshell touch pwned\nimport os"
    folder.mkdir()
    (folder / "result.json").write_text(json.dumps(result))
    for text in cards(read_result(folder), engine).values():
        assert not re.search("^(shell|import os)", text, re.M)


def test_what_typer_prints_is_text_too():
    said = command("--version").stdout.decode()
    assert re.fullmatch(r"benchtwin [\w.]+\n", said)
    assert command("--help").stdout.decode().lstrip().startswith("Usage: ")
