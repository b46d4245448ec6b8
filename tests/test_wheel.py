"""The wheel works outside the checkout: built, unpacked alone, its command run on a
sample from another folder."""

import os
import shutil
import subprocess
import sys
import sysconfig
import venv
import zipfile
from pathlib import Path

import pytest
import trimesh
from packages import FOLDERS, ROOT

from benchtwin.command_line import COMMANDS


@pytest.fixture(scope="module")
def wheel(tmp_path_factory):
    place = tmp_path_factory.mktemp("wheel")
    shutil.rmtree(
        ROOT / "build" / "lib", ignore_errors=True
    )  # what an earlier build left would be packed again
    command = [
        sys.executable,
        "-m",
        "pip",
        "wheel",
        "--no-deps",
        "--no-build-isolation",
        "-qq",
        "-w",
        str(place),
        str(ROOT),
    ]
    built = subprocess.run(command, capture_output=True, text=True)
    assert built.returncode == 0, built.stderr
    (built_wheel,) = place.glob("*.whl")
    return built_wheel


@pytest.fixture(scope="module")
def installed(wheel):
    """A folder that holds what the wheel holds. Its dependencies are this
    environment's."""
    with zipfile.ZipFile(wheel) as packed:
        packed.extractall(wheel.parent / "site")
    return wheel.parent / "site"


def run(installed, tmp_path, code):
    """Python that sees the unpacked wheel before this checkout."""
    environment = os.environ | {"PYTHONPATH": str(installed)}
    return subprocess.run(
        [sys.executable, "-P", "-c", code],
        cwd=tmp_path,
        env=environment,
        capture_output=True,
        text=True,
    )


def test_it_holds_every_package_and_file_that_is_not_python(installed):
    files = {
        Path("benchtwin", *(p.relative_to(ROOT).parts[name == "benchtwin" :]))
        for name in FOLDERS
        for p in (ROOT / name).rglob("*")
        if p.is_file() and "__pycache__" not in p.parts
    }
    assert {f for f in files if not (installed / f).is_file()} == set()


def test_it_brings_one_name(installed):
    """A user's own sim.py or vision.py stands in nobody's way."""
    assert {p.name for p in installed.iterdir() if p.suffix != ".dist-info"} == {
        "benchtwin"
    }


def test_a_sample_is_measured_and_calibrated_from_it(installed, tmp_path):
    samples = ROOT / "samples"
    done = run(
        installed,
        tmp_path,
        "import sys, benchtwin.vision, benchtwin.command_line as command\n"
        f"assert benchtwin.vision.__file__.startswith({str(installed)!r})\n"
        f"sys.argv = ['benchtwin', 'calibrate', {str(samples / 'soybean-paper')!r},"
        " '--tables', '--out', 'out']\n"
        "command.main()",
    )
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "out" / "report.html").stat().st_size > 100_000


@pytest.fixture(scope="module")
def elsewhere(wheel, tmp_path_factory):
    """`benchtwin` of an environment whose path has spaces and umlauts, and a folder of
    that kind to work in; dependencies are this environment's."""
    place = tmp_path_factory.mktemp("Büro mit Körnern")
    venv.create(place / "my env ü", with_pip=False)
    scripts = sysconfig.get_path("scripts", "venv", {"base": str(place / "my env ü")})
    python = Path(scripts) / Path(sys.executable).name
    told = "import sysconfig; print(sysconfig.get_path('purelib'))"
    site = subprocess.run(
        [python, "-c", told], capture_output=True, text=True, check=True
    ).stdout.strip()
    ours = "\n".join(p for p in sys.path if p.endswith("site-packages"))
    (Path(site) / "dependencies.pth").write_text(ours, encoding="utf8")
    command = [python, "-m", "pip", "install", "-qq", "--no-deps", "--no-index"]
    command += ["--force-reinstall", "--disable-pip-version-check", str(wheel)]
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return Path(scripts) / "benchtwin", place


def typed(elsewhere, *words):
    program, place = elsewhere
    told = {"PYTHONPATH": "", "NUMBA_CACHE_DIR": ""}
    done = subprocess.run(
        [program, *map(str, words)],
        cwd=place,
        env=os.environ | told,
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, (words, done.stdout, done.stderr)
    assert "Traceback" not in done.stderr
    return done.stdout


@pytest.mark.slow
def test_every_command_says_what_it_is_from_a_path_with_spaces_and_umlauts(elsewhere):
    for name in COMMANDS:
        assert f"benchtwin {name}" in typed(elsewhere, name, "--help")
    where = "import benchtwin; print(benchtwin.__file__)"
    python = elsewhere[0].with_name(Path(sys.executable).name)
    found = subprocess.run([python, "-P", "-c", where], capture_output=True, text=True)
    assert "my env ü" in found.stdout


@pytest.mark.slow
def test_the_commands_work_there(elsewhere):
    """Each that needs neither a browser, LAMMPS nor minutes; results lie in a folder of
    that kind, too."""
    samples, place = ROOT / "samples", elsewhere[1]
    typed(elsewhere, "new", "neue Körner")
    typed(elsewhere, "import", samples / "imported-drop" / "film.txt", "--out", "Bänke")
    bench = shutil.copytree(samples / "heard-drop", place / "gehörte Tropfen")
    typed(elsewhere, "measure", bench, "--out", "gemessen ä")
    assert (place / "gemessen ä" / "results.xlsx").is_file()
    typed(elsewhere, "seeds", "soybean")
    trimesh.creation.icosphere(radius=3).export(place / "Körner.stl")
    words = ("Körner.stl", "--unit", "mm", "--spheres", "1", "--out", "Klumpen ö")
    typed(elsewhere, "clump", *words)
    typed(elsewhere, "simulate", "drop", "--track", "--save", "vtkhdf", "--out", "s ü")
    assert (place / "s ü" / "drop-01" / "state.vtkhdf").is_file()
    paper = samples / "soybean-paper"
    typed(elsewhere, "calibrate", paper, "--tables", "--out", "kalibriert ü")
    typed(elsewhere, "export", "kalibriert ü", "--to", "edem")
    typed(elsewhere, "diagnose", bench, "--no-twin", "--out", "Diagnose ä")
    typed(elsewhere, "pack", bench, "kalibriert ü", "--out", "für Zenodo.zip")
    assert "as it was packed" in typed(elsewhere, "unpack", "für Zenodo.zip")
