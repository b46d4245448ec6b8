"""A rig of somebody's own, written as docs/extending.md says: one folder, and every
command knows it."""

import subprocess
import sys
from pathlib import Path

import pytest

OWN = Path(__file__).parent / "own_rig"
WITH_IT = f"import benchtwin.rigs; benchtwin.rigs.__path__.append({str(OWN)!r})\n"


def run(script: str, folder: Path) -> str:
    """What a script prints that sees the rig beside ours."""
    command = [sys.executable, "-c", WITH_IT + script]
    done = subprocess.run(
        command, cwd=folder, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


def cli(folder: Path, *words: str, ends: int = 0) -> str:
    """What a command of benchtwin prints, errors among it."""
    script = f"""
from benchtwin.command_line import main
import sys
sys.argv = ["benchtwin", *{list(words)!r}]
sys.stderr = sys.stdout
try:
    main()
except SystemExit as end:
    assert (end.code or 0) == {ends}, end.code
"""
    return run(script, folder)


@pytest.fixture(scope="module")
def simulated(tmp_path_factory):
    folder = tmp_path_factory.mktemp("own")
    words = ("simulate", "toss", "--track", "--repeats", "2")
    cli(folder, *words, "--out", "tosses", "--set", "toss.speed_mm_s=1800")
    return folder


def test_it_is_simulated_and_measured_as_the_simulation_knows_it(simulated):
    table = (simulated / "tosses" / "measured" / "measurements.csv").read_text()
    speeds = [float(row.split(",")[3]) for row in table.splitlines()[1:]]
    # Air, which its model leaves out, takes 1 % of the speed of 0.25 s.
    assert speeds == [pytest.approx(1.8, rel=0.01)] * 2


def test_what_its_recordings_state_is_kept_and_checked(simulated):
    text = (simulated / "tosses" / "toss-01" / "recording.toml").read_text()
    assert 'rig = "toss"' in text and "speed_mm_s = 1800" in text
    (simulated / "odd" / "a").mkdir(parents=True)
    toml = simulated / "odd" / "a" / "recording.toml"
    toml.write_text('rig = "toss"\n[toss]\nsped_mm_s = 3\n')
    (toml.parent / "readings.csv").write_text("flight_time_s\n0.31\n0.33\n")
    said = cli(simulated, "measure", "odd", "--out", "m", ends=1)
    assert "sped_mm_s" in said and "speed_mm_s" in said
    toml.write_text('rig = "toss"\n[toss]\nspeed_mm_s = 1600\n')
    said = cli(simulated, "measure", "odd", "--out", "m2")
    assert "flight_time" in said and "0.32" in said


def test_pages_and_lists_know_it(simulated):
    said = run(
        "from benchtwin.page.form import form\n"
        "from benchtwin.diagnose.bench import diagnose_bench\n"
        "from benchtwin.bench.rigs import rigs_in_words\n"
        "print([s.name for s in form('toss', {}, {})], rigs_in_words())\n"
        "print(diagnose_bench('tosses').refused)\n",
        simulated,
    )
    assert "'toss'" in said and "bump or toss" in said
    assert "a toss cannot be diagnosed yet" in said


def test_a_folder_without_its_record_says_so(tmp_path):
    (tmp_path / "hopper").mkdir()
    (tmp_path / "hopper" / "__init__.py").write_text('"""Nothing yet."""\n')
    script = WITH_IT.replace(str(OWN), str(tmp_path)) + "import benchtwin.bench.rigs"
    done = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, check=False
    )
    assert "rigs/hopper/__init__.py holds no RIG" in done.stderr


CALIBRATED = """
from pathlib import Path
import numpy as np, pandas as pd
from benchtwin.calibrate.procedure import parameters
from benchtwin.calibrate.procedure.effort import QUICK
from benchtwin.calibrate.procedure.simulated import calibrate_simulated

def simulate(runs):
    rows = []
    for r in runs:
        rng, e = np.random.default_rng(list(r.rng)), r.values["restitution"]
        drop = {"rebound_height_mm": 310 * e**2 + rng.normal()}
        back = 2 * np.degrees(np.arcsin(e * 0.5)) + 0.5 * rng.normal()
        bump = {"swing_back_deg": back}
        rows.append({"status": "done"} | (drop if r.rig == "drop" else bump))
    return pd.DataFrame(rows)

c = calibrate_simulated(Path("bench"), simulate, effort=QUICK)
row, = parameters(c).itertuples()
print(row.parameter, row.low < 0.6 < row.high, row.source, list(c.findings))
middle = np.ptp(c.joint.posterior.draws["restitution"].quantile([0.16, 0.84])) / 2
print(middle < c.steel["drop"].sd)
"""


def read_bench(folder, **readings):
    for rig, (column, values) in readings.items():
        place = folder / "bench" / rig
        place.mkdir(parents=True, exist_ok=True)
        stated = {"drop": "height_mm = 310", "bump": "start_deg = 60"}[rig]
        (place / "recording.toml").write_text(f'rig = "{rig}"\n[{rig}]\n{stated}\n')
        (place / "readings.csv").write_text("\n".join([column, *map(str, values)]))


def test_what_it_tells_is_calibrated_together_with_what_our_rigs_tell(tmp_path):
    drop = ("rebound_height_mm", (106.0, 117.1, 109.9, 113.4))  # e = .6
    bump = ("swing_back_deg", (34.7, 35.1, 34.9, 35.3))  # the same
    read_bench(tmp_path, drop=drop, bump=bump)
    said = run(CALIBRATED, tmp_path)
    assert "restitution True drop: " in said and "; bump: " in said
    assert said.endswith("[]\nTrue\n")
    # the control: a rig that says something else is left out, and named
    read_bench(tmp_path, bump=("swing_back_deg", (41.0, 40.8, 41.2, 41.1)))
    said = run(CALIBRATED, tmp_path)
    assert "; bump: " not in said and "contradicts 0.60" in said


PROVED = """
from pathlib import Path
import numpy as np
from benchtwin.prove.make import make_folder
from benchtwin.prove.plan import plan

specs = [s for s in plan(40, np.random.default_rng(1)) if s.rig == "bump"]
for spec in specs:
    key = make_folder(spec, 1, Path("cases") / spec.name)
    print(spec.kind, [(e["name"], e["value"], e["snr"]) for e in key["effects"]])
print(len(specs))
"""


def test_cases_are_drawn_of_it(tmp_path):
    (tmp_path / "cases").mkdir()
    said = run(PROVED, tmp_path)
    assert "clean []" in said and "single [('wear', -0." in said
    tables = list((tmp_path / "cases").glob("*/bump-01/readings.csv"))
    assert len(tables) == int(said.split()[-1]) >= 3
