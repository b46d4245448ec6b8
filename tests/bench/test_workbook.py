"""A workbook holds numbers as numbers and text as text, whatever the text; spreadsheet
programs open it."""

import shutil
import subprocess
import warnings

import numpy as np
import pandas as pd
import pytest
from openpyxl import load_workbook

from benchtwin.bench.workbook import LONGEST_TEXT, write_workbook

TABLE = pd.DataFrame(
    {
        "recording": ["=HYPERLINK(A1)", "Körner 豆", "a\x00b\ud800", "x" * 40_000],
        "value": [0.1 + 0.2, np.nan, np.inf, -1e-300],
        "n": np.array([1, 2, 3, 2**40]),
        "agrees": [True, False, True, True],
        "outliers": [("drop-01", "drop-02"), (), None, ""],
    }
)


@pytest.fixture
def file(tmp_path):
    out = tmp_path / "results.xlsx"
    write_workbook(out, {"means over repeats": TABLE, "none": TABLE[:0]})
    return out


def cells(file, title):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        return load_workbook(file)[title]


def test_numbers_are_numbers_and_what_is_unknown_is_empty(file):
    sheet = cells(file, "means over repeats")
    rows = list(sheet.iter_rows(min_row=2, values_only=True))
    read = [r[1] for r in rows]
    # 16 digits are written
    assert read == [pytest.approx(0.3, rel=1e-15), None, None, pytest.approx(-1e-300)]
    assert [r[2] for r in rows] == [1, 2, 3, 2**40]
    assert [r[3] for r in rows] == [True, False, True, True]


def test_text_is_text(file):
    sheet = cells(file, "means over repeats")
    assert sheet["A2"].data_type == "s" and sheet["A2"].value == "=HYPERLINK(A1)"
    assert sheet["A3"].value == "Körner 豆" and sheet["A4"].value == r"a\x00b\ud800"
    assert len(sheet["A5"].value) == LONGEST_TEXT
    assert sheet["E2"].value == "drop-01; drop-02"


def test_a_table_without_rows_keeps_its_headings(file):
    assert [c.value for c in cells(file, "none")[1]] == list(TABLE.columns)


def test_nothing_is_left_of_what_cannot_be_written(tmp_path, monkeypatch):
    def full(self, part):
        part.write_bytes(b"half")
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("openpyxl.Workbook.save", full)
    with pytest.raises(OSError, match="No space left"):
        write_workbook(tmp_path / "results.xlsx", {"a": TABLE})
    assert list(tmp_path.iterdir()) == []


@pytest.mark.slow
@pytest.mark.skipif(not shutil.which("soffice"), reason="LibreOffice is not here")
def test_libreoffice_reads_it(file, tmp_path):
    """Its own text of the first sheet; a file that it repairs or refuses makes none."""
    command = ["soffice", f"-env:UserInstallation={(tmp_path / 'user').as_uri()}"]
    as_csv = "csv:Text - txt - csv (StarCalc):44,34,76"  # commas, quotes, UTF-8
    command += ["--headless", "--convert-to", as_csv]
    done = subprocess.run(
        [*command, "--outdir", str(tmp_path), str(file)],
        capture_output=True,
        text=True,
        timeout=120,
    )
    assert done.returncode == 0 and "rror" not in done.stderr, done.stderr
    read = pd.read_csv(tmp_path / "results.csv", dtype=str, keep_default_na=False)
    assert list(read.columns) == list(TABLE.columns)
    assert read["recording"][:2].tolist() == ["=HYPERLINK(A1)", "Körner 豆"]
    assert float(read["value"][0]) == pytest.approx(0.3, abs=1e-9)  # as it is shown
