"""`benchtwin pdf`: a report's page comes out as PDF with its figures; what cannot be
printed is a sentence, and nothing is left half-written."""

import shutil

import pytest
from typer.testing import CliRunner

from benchtwin.command_line import app
from benchtwin.report import pdf
from benchtwin.report.template import PAGE, PRINTED, write_page

INSTALLED = any(map(shutil.which, pdf.BROWSERS))
FOLDED = "<details><summary>rows</summary>forty-two</details>"
OPEN = (
    '<script>addEventListener("beforeprint", () => {'
    'document.body.append("figure drawn".repeat(3000))})</script>'
)


def run(*arguments):
    return CliRunner().invoke(app, ["pdf", *map(str, arguments)])


@pytest.fixture
def results(tmp_path):
    folder = tmp_path / "Körner kalibriert"
    folder.mkdir()
    page = f"<!doctype html><title>t</title><body>{FOLDED}{OPEN}</body>"
    write_page(folder, page)
    return folder


@pytest.mark.skipif(not INSTALLED, reason="no browser to print with is installed")
def test_a_report_is_printed_and_its_scripts_run_before(results):
    done = run(results)
    assert done.exit_code == 0, done.output
    printed = (results / PRINTED).read_bytes()
    assert printed.startswith(b"%PDF") and printed.rstrip().endswith(b"%%EOF")
    assert printed.count(b"/Type /Page\n") > 3  # what the script appends, page by page
    assert {p.name for p in results.iterdir()} == {PAGE, PRINTED}
    write_page(results, "<p>newer</p>")
    assert not (results / PRINTED).exists()


def test_what_has_no_page_is_said(tmp_path):
    done = run(tmp_path)
    assert done.exit_code == 2 and "no report.html there" in done.output


def test_without_a_browser_it_says_what_to_install(results, monkeypatch):
    monkeypatch.setattr(pdf, "BROWSERS", ())
    done = run(results)
    assert done.exit_code == 1 and "Chromium, Chrome or Edge" in done.output


def test_a_browser_that_fails_is_quoted(results, monkeypatch, tmp_path):
    broken = tmp_path / "broken"
    broken.write_text("#!/bin/sh\necho 'no display' >&2\nexit 1\n")
    broken.chmod(0o755)
    monkeypatch.setattr(pdf, "BROWSERS", (str(broken),))
    done = run(results)
    assert done.exit_code == 1 and done.output.strip().endswith("no display")
    assert not (results / PRINTED).exists()
