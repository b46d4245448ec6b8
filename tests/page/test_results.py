"""Results as the page shows them: what to record next, cards, the zip, recordings
beside their twins."""

import json
import shutil
import zipfile
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from typer.testing import CliRunner

from benchtwin.command_line import app
from benchtwin.page import downloads, results
from benchtwin.page.downloads import packed_bench, sheet
from benchtwin.page.folder import Folder, Refused
from benchtwin.page.side_by_side import browser_data, pairs_of, read_pair
from benchtwin.vision.find_recordings import find_recordings

from .visitor import Visitor

SAMPLES = Path(__file__).parents[2] / "samples"


@pytest.fixture(scope="module")
def calibrated(tmp_path_factory) -> Path:
    """What a calibration on a paper's tables leaves."""
    out = tmp_path_factory.mktemp("calibrated") / "calibrated"
    assert (
        CliRunner()
        .invoke(
            app,
            [
                "calibrate",
                str(SAMPLES / "soybean-paper"),
                "--tables",
                "--out",
                str(out),
                "--quiet",
            ],
        )
        .exit_code
        == 0
    )
    return out


@pytest.fixture
def bench(tmp_path, calibrated) -> Path:
    """A bench with a filmed drop, and results."""
    bench = tmp_path / "bench"
    shutil.copytree(SAMPLES / "drawn-bench" / "drop-phone", bench / "drop-phone")
    left = Folder(tmp_path).results(bench)
    shutil.copytree(calibrated, left / "calibrated")
    return bench


def diagnosis(left: Path, **more) -> None:
    found = {
        "verdict": "class",
        "matters": True,
        "next_record": "a drop from twice the height",
    }
    (left / "diagnosed").mkdir()
    (left / "diagnosed" / "diagnosis.json").write_text(
        json.dumps({"rigs": {"drop": found | more}})
    )


def test_what_to_record_next_is_gathered_and_escaped_on_paper(bench):
    left = bench / "results"
    diagnosis(left)
    (left / "measured").mkdir()
    failed = [
        ("<b>drop</b>", "failed", "no impact"),
        ("<b>drop</b>", "failed", "no impact"),
        ("drop-2", "good", ""),
    ]
    pd.DataFrame(failed, columns=["recording", "quality", "reason"]).to_csv(
        left / "measured" / "measurements.csv", index=False
    )
    told = results.next_recordings(left)
    assert told["To record again"] == [results.ToRecord("<b>drop</b>", "no impact")]
    assert told["To tell explanations apart"] == [
        results.ToRecord("drop: a drop from twice the height", results.SETTLES)
    ]
    table = pd.read_csv(left / "calibrated" / "tables" / "next_tests.csv").sort_values(
        "pick"
    )
    assert told["To narrow the parameters"][0].what == table["test"].iloc[0]
    page = sheet("be<nch", told)
    assert (
        "<b>drop" not in page
        and "&lt;b&gt;drop&lt;/b&gt;" in page
        and "be&lt;nch" in page
        and "print()" in page
    )


def test_a_test_that_gains_nothing_is_not_asked_for(tmp_path):
    (tmp_path / "calibrated" / "tables").mkdir(parents=True)
    rows = {
        "test": ["b", "a", "c"],
        "pick": [2, 1, 3],
        "variance_left_after": [0.1, 0.4, 0.0999],
    }
    pd.DataFrame(rows).to_csv(
        tmp_path / "calibrated" / "tables" / "next_tests.csv", index=False
    )
    assert [
        row.what
        for row in results.next_recordings(tmp_path)["To narrow the parameters"]
    ] == ["a", "b"]


def test_what_was_not_calibrated_is_listed_with_its_reason(tmp_path):
    (tmp_path / "calibrated").mkdir()
    why = {
        "drop": (
            "no drop was measured: /home/me/drop/recording.toml: [camera] mm_per_px is"
            " missing"
        )
    }
    (tmp_path / "calibrated" / "result.json").write_text(
        json.dumps({"not_calibrated": why})
    )
    (row,) = results.next_recordings(tmp_path)["Not calibrated yet"]
    assert (row.what, row.why) == (
        "drop",
        "no drop was measured: recording.toml: [camera] mm_per_px is missing",
    )


def test_cards_are_those_of_the_command(bench, tmp_path):
    left, out = bench / "results", tmp_path / "cards"
    command = [
        "export",
        str(left / "calibrated"),
        "--to",
        "lammps",
        "--out",
        str(out),
        "--quiet",
    ]
    assert CliRunner().invoke(app, command).exit_code == 0
    assert downloads.card_files(left, "lammps") == {
        p.name: p.read_text() for p in out.iterdir()
    }
    shutil.rmtree(bench / "results" / "calibrated")
    with pytest.raises(Refused, match="nothing is calibrated yet"):
        downloads.card_files(bench / "results", "lammps")


def test_the_unpacked_zip_is_the_bench_and_its_results_are_no_recordings(
    bench, tmp_path
):
    left = bench / "results" / "calibrated"
    shutil.copytree(bench / "drop-phone", left / "twin" / "drop" / "key")
    file = packed_bench(bench, tmp_path)
    with zipfile.ZipFile(file) as pack:
        pack.extractall(tmp_path / "elsewhere")
    there = tmp_path / "elsewhere" / "bench"
    assert [r.path for r in find_recordings(there)] == [there / "drop-phone"]
    assert (
        there / "results" / "calibrated" / "export" / "yade" / "seed_contact.py"
    ).is_file()
    assert (there / "results" / "calibrated" / "report.html").is_file()


def test_pairs_are_found_and_laid_over_each_other(bench, tmp_path):
    left = bench / "results"
    shutil.copytree(bench / "drop-phone", left / "calibrated" / "twin" / "drop" / "key")
    shutil.copytree(
        bench / "drop-phone", left / "diagnosed" / "twin" / "drop-phone-new"
    )
    result = json.loads((left / "calibrated" / "result.json").read_text())
    pairs = [
        {
            "rig": "drop",
            "recording": "drop-phone",
            "alike": True,
            "twin": "twin/drop/key",
        },
        {"rig": "drop", "recording": "gone", "alike": True, "twin": "twin/drop/key"},
        {
            "rig": "drop",
            "recording": "drop-phone",
            "alike": True,
            "twin": "../../../../../etc",
        },
    ]
    (left / "calibrated" / "result.json").write_text(
        json.dumps(result | {"pairs": pairs})
    )
    folder = Folder(tmp_path)
    found = pairs_of(bench, folder)
    assert [b.title for b in found] == [
        "Calibration: drop-phone",
        "Diagnosis: drop-phone, new twin",
    ]
    shown = browser_data(found[0], read_pair(found[0]), folder)
    assert (
        shown["bench"] == pytest.approx(shown["twin"], abs=1e-6)
        and shown["frames"][0] == shown["frames"][1]
    )
    assert np.all(np.diff(shown["frames"][0]) >= 0) and shown["xname"] == "time (s)"


SPOILT = {
    "empty": b"",
    "cut": b'{"parameters": {"restit',
    "binary": bytes(range(256)) * 40,
    "a number": b"1",
    "a list": b"[1, 2, 3]",
    "null": b"null",
    "nested": b"[" * 100_000,
    "digits": b'{"rigs": ' + b"9" * 5000 + b"}",
    "wrong inside": json.dumps(
        {
            "parameters": {"restitution": {"value": "=1+1", "low": [], "status": {}}},
            "pairs": [{"recording": ["a"]}, 3],
            "not_calibrated": {"pile": 3},
            "rigs": {"drop": {"explanations": [{"effects": 3}], "matters": "x"}},
        }
    ).encode(),
    "lists inside": b'{"parameters": [1], "pairs": 3, "not_calibrated": [1],'
    b' "rigs": [1]}',
    "not finite": b'{"parameters": {"restitution": {"value": NaN, "low": 1e999,'
    b' "high": 1, "status": "x"}}}',
    "other columns": b"a,b,c\n1,x,2\n3,y,4\n",
    "rows cut": b'recording,quality,reason\n"a,failed',
    "columns of words": b"pick,test,variance_left_after,n\nx,y,z,w\n,,,\n",
}
FILES = (
    "calibrated/result.json",
    "calibrated/tables/next_tests.csv",
    "diagnosed/diagnosis.json",
    "measured/measurements.csv",
    "measured/summary.csv",
)


@pytest.mark.parametrize("file", FILES)
@pytest.mark.parametrize("how", SPOILT)
def test_a_spoilt_result_is_read_or_refused_with_one_sentence(bench, file, how):
    left = bench / "results"
    place = left / file
    place.parent.mkdir(parents=True, exist_ok=True)
    place.write_bytes(SPOILT[how])
    folder = Folder(bench.parent)
    for read in (
        lambda: results.next_recordings(left),
        lambda: pairs_of(bench, folder),
        lambda: downloads.card_files(left, "edem"),
        lambda: packed_bench(bench, bench.parent),
    ):
        try:
            read()
        except Refused as error:
            assert "\n" not in str(error) and str(bench) not in str(error)


def test_a_huge_result_is_refused_unread(bench):
    with (bench / "results" / "calibrated" / "result.json").open("wb") as file:
        file.truncate(20_000_000_000)
    with pytest.raises(Refused, match=r"calibrated/result\.json cannot be read"):
        results.next_recordings(bench / "results")


def test_a_twin_outside_the_results_is_not_shown(bench):
    left, folder = bench / "results", Folder(bench.parent)
    shutil.copytree(bench / "drop-phone", bench.parent / "elsewhere")
    file = left / "calibrated" / "result.json"
    for twin in ("../../../elsewhere", str(bench.parent / "elsewhere")):
        pair = {"recording": "drop-phone", "twin": twin, "alike": True}
        file.write_text(json.dumps(json.loads(file.read_text()) | {"pairs": [pair]}))
        assert pairs_of(bench, folder) == []


def test_every_page_of_a_bench_with_spoilt_results_answers(serve, bench):
    left = bench / "results"
    with serve(bench.parent) as address:
        visitor = Visitor(address)
        for how, content in SPOILT.items():
            for file in FILES:
                (left / file).parent.mkdir(parents=True, exist_ok=True)
                (left / file).write_bytes(content)
            for path in ("/bench?b=bench&tab=Results", "/bench?b=bench", "/"):
                status, page = visitor.get(path)
                assert status == 200 and b"Traceback" not in page, (how, path)
            for path in ("/next?bench=bench", "/cards?bench=bench&engine=edem"):
                status, said = visitor.get(path)
                assert status in (200, 422) and b"Traceback" not in said, (how, path)
                assert status == 200 or said.count(b"\n") == 0, said
