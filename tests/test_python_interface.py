"""The Python interface: what docs/python.md shows runs, each name is loaded late and
typed, and bad input is refused in words."""

import ast
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import benchtwin
from benchtwin import calibrate, diagnose, export, measure, simulate
from benchtwin.measuring import Measurements

ROOT = Path(__file__).parents[1]
PAGE = (ROOT / "docs" / "python.md").read_text(encoding="utf8")


@pytest.fixture(scope="module")
def shown(tmp_path_factory):
    """The page's examples, run one after another where samples/ is, and left there:
    what their names stand for."""
    place = tmp_path_factory.mktemp("page")
    (place / "samples").symlink_to(ROOT / "samples")
    names: dict = {}
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(place)
        for example in re.findall(r"```python\n(.*?)```", PAGE, re.DOTALL):
            exec(compile(example, "docs/python.md", "exec"), names)
        yield names


def test_measurements_are_the_command_s(shown):
    found: Measurements = shown["found"]
    slope = found.summary.query("quantity == 'slope'").iloc[0]
    assert slope["low"] < 0.14 < slope["high"] and slope["unit"] == "deg"
    assert set(found.table["recording"]) == set(found.quantities["recording"])
    rolls = found.table.dropna(subset="acceleration_m_s2")
    assert (rolls["acceleration_sd_m_s2"] > 0).all() and len(rolls) >= 6
    assert shown["doubtful"]["reason"].ne("").all()


def test_simulated_rolls_are_measured_as_the_simulation_knows_them(shown):
    rolls = shown["rolls"]
    off = rolls.measured.table["run_out_mm"] - rolls.truth["run_out_mm"]
    assert (
        len(off) == 2
        and (off.abs() < 0.5).all()
        and rolls.measured.table["run_out_mm"].nunique() == 2
    )
    assert (
        simulate(
            "roll",
            shown["Parameters"](rolling_friction=0.02),
            out=rolls.folder,
            repeats=2,
        ).names
        == rolls.names
    )  # kept


def test_a_calibration_holds_the_printed_values(shown):
    table = shown["answer"].parameters.set_index("parameter")
    assert table.loc["restitution", "low"] < 0.54 < table.loc["restitution", "high"]
    assert (shown["answer"].folder / "result.json").is_file() and shown[
        "answer"
    ].not_calibrated == {}


def test_a_diagnosis_names_what_is_concealed(shown):
    missing = shown["missing"]
    assert (
        missing.verdicts.loc[0, "names"] == "slope"
        and missing.verdicts.loc[0, "probability"] > 0.99
    )
    slope = missing.effects.query("effect == 'slope'").iloc[0]
    assert slope["low95"] < slope["value"] < slope["high95"] and slope["unit"] == "deg"
    assert (
        "the plate is not level" in missing.in_words[0] and missing.not_diagnosed == {}
    )


def test_cards_are_written(shown):
    cards = shown["cards"]
    assert {
        p.name: p.read_text(encoding="utf8") for p in cards.folder.iterdir()
    } == cards.texts
    with pytest.raises(FileExistsError, match="exists already"):
        export(shown["answer"].folder, "lammps")


def test_the_engine_s_drop_rises_by_its_restitution(shown):
    assert np.isclose(shown["bean"].mass_kg, 2.27e-4, rtol=0.01)
    assert 0.3 < shown["motion"].truth["restitution"] < 0.8
    assert shown["windy"].laws[0].numbers == (2e-4,)


def test_the_page_names_all_of_the_interface():
    assert [name for name in benchtwin.__all__ if f"`{name}`" not in PAGE] == []
    assert len(benchtwin.__all__) == 10 and set(benchtwin.__all__) == set(
        benchtwin._MODULES
    ) == set(dir(benchtwin))


def test_a_type_checker_and_python_find_each_name_in_the_same_file():
    tree = ast.parse(Path(benchtwin.__file__).read_text(encoding="utf8"))
    (block,) = [
        n
        for n in tree.body
        if isinstance(n, ast.If) and ast.unparse(n.test) == "TYPE_CHECKING"
    ]
    typed = {
        alias.name: n.module
        for n in block.body
        if isinstance(n, ast.ImportFrom)
        for alias in n.names
    }
    assert typed == benchtwin._MODULES


def test_importing_it_loads_nothing_that_is_slow():
    looks = (
        "import sys, benchtwin; print(sorted({'numpy', 'pandas', 'numba', 'cv2',"
        " 'benchtwin.sim', 'benchtwin.vision'} & set(sys.modules)))"
    )
    done = subprocess.run(
        [sys.executable, "-c", looks],
        capture_output=True,
        cwd=ROOT,
        check=True,
        text=True,
    )
    assert done.stdout.strip() == "[]"


def test_measured_files_are_the_command_s(tmp_path):
    found = measure(ROOT / "samples" / "gates-roll", out=tmp_path / "out")
    assert (
        tmp_path / "out" / "measurements.csv"
    ).is_file() and found.folder == tmp_path / "out"
    with pytest.raises(benchtwin.MeasurementError, match="not empty"):
        measure(ROOT / "samples" / "gates-roll", out=tmp_path / "out")


def test_bad_input_is_refused_in_words(tmp_path):
    paper = ROOT / "samples" / "soybean-paper"
    with pytest.raises(FileNotFoundError, match="nowhere: no such file"):
        measure(tmp_path / "nowhere")
    with pytest.raises(ValueError, match="two heights"):
        measure(paper, window_pct=(50.0, 55.0))
    with pytest.raises(ValueError, match="no such rig"):
        simulate("tower", out=tmp_path / "t")
    with pytest.raises(ValueError, match="unknown key"):
        simulate("drop", out=tmp_path / "t", settings={"height": 1.0})
    with pytest.raises(ValueError, match="out names the folder"):
        calibrate(paper)
    with pytest.raises(ValueError, match=r"--range restitution"):
        calibrate(paper, out=tmp_path / "c", ranges={"restitution": (0.1, 0.2)})
    with pytest.raises(ValueError, match="no rig 'tower'"):
        diagnose(paper, rigs=["tower"])
    with pytest.raises(FileNotFoundError):
        diagnose(tmp_path / "nowhere")
    with pytest.raises(FileNotFoundError, match=r"result\.json"):
        export(tmp_path, "lammps")
