"""The documentation: its links lead somewhere, its pages are in the site, and what is
generated is current."""

import os
import re
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
DOCS = sorted((ROOT / "docs").glob("*.md"))


@pytest.mark.parametrize(
    "page", [*DOCS, ROOT / "README.md", ROOT / "CONTRIBUTING.md"], ids=lambda p: p.name
)
def test_every_link_to_a_file_leads_to_one(page):
    text = page.read_text(encoding="utf8")
    for target in re.findall(r"\]\(([^)#:]+)(?:#[^)]*)?\)", text):
        assert (page.parent / target).exists(), target
    for named in re.findall(r"`?\b(docs/[\w-]+\.md)\b", text):
        assert (ROOT / named).exists(), named


@pytest.mark.parametrize("page", DOCS, ids=lambda p: p.name)
def test_every_file_of_the_code_that_is_named_is_there(page):
    text = page.read_text(encoding="utf8")
    named = re.findall(
        r"`((?:vision|sim|calibrate|page|prove|benchmarks|samples|tests|scripts)/[\w./-]+\.py)`",
        text,
    )
    there = [
        name for name in named if not re.search(r"[A-Z]{3}", name)
    ]  # NAME, RIG, ENGINE stand for any
    assert [name for name in there if not (ROOT / name).is_file()] == []


def test_every_page_stands_in_the_site_s_menu():
    menu = re.findall(r"[\w-]+\.md", (ROOT / "mkdocs.yml").read_text(encoding="utf8"))
    assert sorted(menu) == [page.name for page in DOCS]


def test_the_site_builds_without_a_warning(tmp_path):
    """Links between pages and to headings included, and every name that the Python page
    shows."""
    build = [
        sys.executable,
        "-m",
        "mkdocs",
        "build",
        "--strict",
        "--quiet",
        "--site-dir",
        str(tmp_path),
    ]
    done = subprocess.run(
        build,
        cwd=ROOT,
        env=os.environ | {"NO_MKDOCS_2_WARNING": "1"},
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    reference = (tmp_path / "python.html").read_text(encoding="utf8")
    assert "benchtwin.recording_commands.measure" in reference


def test_the_reference_of_keys_is_current():
    sys.path.insert(0, str(ROOT / "scripts"))
    import keys_reference

    assert (ROOT / "docs" / "keys.md").read_text(
        encoding="utf8"
    ) == keys_reference.reference(), "run scripts/keys_reference.py"


def test_the_tables_of_published_seeds_are_current():
    sys.path.insert(0, str(ROOT / "scripts"))
    import seeds_reference

    assert seeds_reference.OUT.read_text(encoding="utf8") == seeds_reference.page(), (
        "run scripts/seeds_reference.py"
    )


def test_the_same_version_stands_everywhere():
    version = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf8"))[
        "project"
    ]["version"]
    assert f"version: {version}\n" in (ROOT / "CITATION.cff").read_text(encoding="utf8")
    assert (
        re.findall(
            r"^## ([\d.]+)", (ROOT / "CHANGELOG.md").read_text(encoding="utf8"), re.M
        )[0]
        == version
    )


def test_readme_is_short():
    """A first page that is read to its end: 120 lines at most."""
    assert len((ROOT / "README.md").read_text(encoding="utf8").splitlines()) <= 120
