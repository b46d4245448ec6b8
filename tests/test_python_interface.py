"""The Python interface: what docs/python.md shows runs, each name is loaded late and
typed, and bad input is refused in words."""

import ast
import linecache
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from threadpoolctl import threadpool_info, threadpool_limits

import benchtwin
from benchtwin import (
    audit,
    calibrate,
    compare,
    diagnose,
    export,
    measure,
    predict,
    simulate,
)
from benchtwin.blas import CHOSEN_BY, on_one_blas_thread
from benchtwin.measure import observed
from benchtwin.measuring import Measurements
from benchtwin.rigs.drop.read import read_drops
from benchtwin.rigs.pile.read import read_piles
from benchtwin.rigs.roll.read import read_rolls
from benchtwin.rigs.slide.read import read_slides
from benchtwin.twin.bench_folder import read_bench

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
            # as a notebook does, so that a law's source is found
            cell = f"cell {hash(example)}"
            linecache.cache[cell] = len(example), None, example.splitlines(True), cell
            exec(compile(example, cell, "exec"), names)
        yield names


def test_measurements_are_the_command_s(shown):
    found: Measurements = shown["found"]
    slope = found.summary.query("quantity == 'slope'").iloc[0]
    assert slope["low"] < -0.14 < slope["high"] and slope["unit"] == "deg"
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
    verdict = missing.verdicts.loc[0]
    assert verdict["names"] == "slope" and verdict["probability"] > 0.8  # nothing else
    slope = missing.effects.query("effect == 'slope'").iloc[0]
    assert slope["probability"] > 0.99
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
    assert len(benchtwin.__all__) == 13 and set(benchtwin.__all__) == set(
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
    with pytest.raises(ValueError, match=r"range of restitution"):
        calibrate(paper, out=tmp_path / "c", ranges={"restitution": (0.1, 0.2)})
    with pytest.raises(ValueError, match="tower: no such rig"):
        diagnose(paper, rigs=["tower"])
    with pytest.raises(FileNotFoundError):
        diagnose(tmp_path / "nowhere")
    with pytest.raises(FileNotFoundError, match=r"result\.json"):
        export(tmp_path, "lammps")
    with pytest.raises(FileNotFoundError, match=r"result\.json"):
        predict(tmp_path, "drum", out=tmp_path / "p")
    with pytest.raises(ValueError, match="no such rig to predict"):
        predict(tmp_path, "tower", out=tmp_path / "p")
    with pytest.raises(ValueError, match="no parameter 'bounce'"):
        compare(out=tmp_path / "e", rows=[{"bounce": 0.5}])
    with pytest.raises(FileNotFoundError, match="nowhere: no such file"):
        audit(tmp_path / "nowhere")
    with pytest.raises(ValueError, match=r"setting drop\.height_mm = high"):
        simulate("drop", out=tmp_path / "t", settings={"drop.height_mm": "high"})


def alike(one: object, other: object) -> bool:
    """Whether two results are the same to the last bit, arrays and tables in them
    too."""
    if isinstance(one, np.ndarray):
        return np.array_equal(one, other, equal_nan=one.dtype.kind == "f")
    if isinstance(one, pd.DataFrame):
        return one.equals(other)
    if isinstance(one, dict):
        return one.keys() == other.keys() and all(
            alike(one[key], other[key]) for key in one
        )
    if isinstance(one, list | tuple):
        return len(one) == len(other) and all(map(alike, one, other))
    if hasattr(one, "__dataclass_fields__"):
        return alike(vars(one), vars(other))
    return one == other or (one != one and other != other)


def not_again(*_, **__):
    raise AssertionError("a recording was measured again")


@pytest.mark.slow
def test_what_was_measured_is_not_measured_again(monkeypatch):
    """Photos, frames, a video, a sound and tracks: what calibration and diagnosis read
    of them is the same to the last bit, and nobody looks at them twice."""
    bench = ROOT / "samples" / "drawn-bench"
    readers = (read_bench, read_drops, read_slides, read_rolls, read_piles)
    anew = [reader(bench) for reader in readers]
    found = measure(bench)
    monkeypatch.setattr(observed, "observe", not_again)
    assert alike(anew, [reader(found.observed) for reader in readers])
    with pytest.raises(AssertionError, match="measured again"):
        read_piles(bench)  # the control
    heap = found.picture("pile-heap")
    assert heap.ndim == 3 and heap.dtype == np.uint8
    with pytest.raises(KeyError, match="nothing: no picture"):
        found.picture("nothing")


def test_calibration_and_diagnosis_of_measurements_are_those_of_the_folder(
    monkeypatch,
):
    paper, rolls = ROOT / "samples" / "soybean-paper", ROOT / "samples" / "gates-roll"
    by_folder = calibrate(paper, tables=True), diagnose(rolls)
    found = measure(paper), measure(rolls)
    monkeypatch.setattr(observed, "observe", not_again)
    answer, missing = calibrate(found[0], tables=True), diagnose(found[1])
    pd.testing.assert_frame_equal(
        answer.parameters, by_folder[0].parameters, check_exact=True
    )
    pd.testing.assert_frame_equal(
        missing.effects, by_folder[1].effects, check_exact=True
    )
    assert missing.in_words == by_folder[1].in_words


def test_a_recording_that_failed_is_told_in_the_same_words(tmp_path):
    (tmp_path / "drop-01").mkdir()
    (tmp_path / "drop-01" / "recording.toml").write_text('rig = "drop"\n')
    (tmp_path / "drop-01" / "track.csv").write_text("frame,t_s,x_mm\n1,0,0\n")
    by_folder, handed_on = diagnose(tmp_path), diagnose(measure(tmp_path))
    assert by_folder.not_diagnosed == handed_on.not_diagnosed != {}
    assert by_folder.details.trouble == handed_on.details.trouble


def test_an_audit_says_what_is_unknown_and_what_stating_it_adds():
    found = audit(ROOT / "samples" / "gates-roll")
    keys = found.keys.set_index("key")
    incline = keys.loc["roll.incline_deg"]
    assert incline["stated_by"] == incline["of"] == 8 and incline["unit"] == "°"
    inertia = found.unknown.set_index("key").loc["seed.inertia_factor"]
    assert inertia["value"] is None and inertia["absent"].startswith("solid")
    assert "drop.height_mm" not in keys.index  # another rig's
    assert "camera.target_mm" not in keys.index  # a simulation's


def test_an_audit_names_what_a_measurement_asked_for(tmp_path):
    (tmp_path / "drop-01").mkdir()
    (tmp_path / "drop-01" / "recording.toml").write_text('rig = "drop"\n')
    (tmp_path / "drop-01" / "readings.csv").write_text("rebound_height_mm\n90\n")
    row = audit(tmp_path).unknown.iloc[0]
    assert row["key"] == "drop.height_mm" and "height_mm is missing" in row["asked"]


def test_results_show_themselves_and_escape_what_comes_from_outside(shown, tmp_path):
    evil = tmp_path / "<img src=x onerror=alert(1)>"
    evil.mkdir()
    (evil / "recording.toml").write_text('rig = "slide"\n')
    (evil / "readings.csv").write_text("slide_angle_deg\n18\n19\n20\n")
    results = [
        measure(tmp_path),
        audit(tmp_path),
        shown["rolls"],
        shown["answer"],
        shown["missing"],
    ]
    for result in results:
        page, figure = result._repr_html_(), result.plot()
        assert "<table" in page and "<img" not in page
        assert len(figure.data) and "<img" not in figure.to_json()
    assert "&lt;img" in results[0]._repr_html_()
    assert "±" in results[0]._repr_html_() and "good" in results[0]._repr_html_()
    assert "<pre>" in shown["cards"]._repr_html_()


def test_a_prediction_is_the_command_s(tmp_path):
    """The mean friction of the stand-in's posterior, by its linear law."""
    from command_code import simulated_by
    from prediction_stand_in import Angles, write_calibrated

    calibrated = write_calibrated(tmp_path / "calibrated")
    with simulated_by(Angles()):
        found = predict(
            calibrated, "drum", out=tmp_path / "p", settings={"drum.speed_rpm": 20.0}
        )
    (row,) = found.quantities.itertuples()
    written = pd.read_csv(tmp_path / "p" / "predicted.csv").iloc[0]
    assert row.mean == pytest.approx(written["mean"], rel=1e-5)
    assert row.low < row.mean_low < row.mean < row.mean_high < row.high
    assert len(found.runs) == 16 and "<table" in found._repr_html_()
    assert len(found.plot().data) == 4 and found.beside.empty


def test_a_comparison_shows_where_engines_part():
    from benchtwin.comparing import EngineComparison
    from benchtwin.twin.compare import QUANTITIES, differences, verdict

    lines = [
        {"row": 1, "parameters": "p", "packing": packing, "engine": engine}
        | dict.fromkeys(QUANTITIES, 20.0 + packing + more)
        for packing in range(4)
        for engine, more in (("benchtwin", 0.0), ("lammps", 0.5 + 0.01 * packing))
    ]
    runs = pd.DataFrame(lines)
    table = differences(runs)
    found = EngineComparison(table, runs, verdict(table), (), Path())
    assert "+0.52" in found._repr_html_() and "the engines part" in found._repr_html_()
    assert len(found.plot().data) == 2 * len(QUANTITIES)


def blas_threads() -> set[int]:
    return {
        found["num_threads"]
        for found in threadpool_info()
        if found["user_api"] == "blas"
    }


def test_blas_takes_one_thread_while_we_compute_unless_the_user_has_chosen(monkeypatch):
    for name in CHOSEN_BY:
        monkeypatch.delenv(name, raising=False)
    with threadpool_limits(2, user_api="blas"):
        assert on_one_blas_thread(blas_threads)() == {1}
        assert blas_threads() == {2}  # as it was
        monkeypatch.setenv("OMP_NUM_THREADS", "2")
        assert on_one_blas_thread(blas_threads)() == {2}


def test_every_function_of_the_interface_is_guarded():
    computing = (audit, calibrate, compare, diagnose, measure, predict, simulate)
    assert all(hasattr(function, "__wrapped__") for function in computing)


TRAP = """
import pickle
import benchtwin.calibrate.statistics.box
import benchtwin.diagnose.words
import benchtwin.measure.batch
from benchtwin.calibrate.statistics.box import Box
import benchtwin
from benchtwin import calibrate, diagnose, measure
assert callable(benchtwin.calibrate) and callable(benchtwin.diagnose)
assert callable(benchtwin.measure) and benchtwin.measure is measure
assert benchtwin.calibrate is calibrate
import benchtwin.calibrate.procedure
assert benchtwin.calibrate is calibrate and benchtwin.diagnose is diagnose
assert pickle.loads(pickle.dumps(calibrate)) is calibrate
box = Box.of({"a": (0.0, 1.0)})
assert pickle.loads(pickle.dumps(box)).names == box.names
print("kept")
"""


def test_functions_that_bear_the_name_of_a_package_stay_functions():
    """Whatever of the package was imported before and after."""
    done = subprocess.run(
        [sys.executable, "-c", TRAP], capture_output=True, cwd=ROOT, text=True
    )
    assert done.stdout.strip() == "kept", done.stderr
