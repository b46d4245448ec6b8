"""The wheel works outside the checkout: built, unpacked alone, its command run on a
sample from another folder."""

import os
import shutil
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest
from packages import FOLDERS, ROOT


@pytest.fixture(scope="module")
def installed(tmp_path_factory):
    """A folder that holds what the wheel holds. Its dependencies are this
    environment's."""
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
    (wheel,) = place.glob("*.whl")
    with zipfile.ZipFile(wheel) as packed:
        packed.extractall(place / "site")
    return place / "site"


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
