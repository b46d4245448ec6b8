"""Several drops in one recording: counted, measured each by itself, and their mean with
the scatter between them.

The sound is drawn by benchmarks/drawn_sound.py, which shares nothing with the reader.
"""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pandas as pd
import pytest
from benchtwin.twin.bench_folder import read_bench
from benchtwin.twin.tracks import read_drops
from benchtwin.vision.measurement import GOOD
from benchtwin.vision.motion.drop_sound import impacts_in_sound
from benchtwin.vision.observe import observe
from benchtwin.vision.recording import read_recording
from drawn_sound import SCENES, draw_session, write
from scipy import stats
from typer.testing import CliRunner

from benchtwin.command_line import app

LOUD = replace(next(s for s in SCENES if s.name == "pink"), db=(25, 30))
N, E, E_SD = 10, 0.6, 0.02


def session(folder, seed=0, n=N, mean=E, lines="height_mm = 300", **more):
    """A recording of `n` drops with thumps between, and what was drawn."""
    rng = np.random.default_rng([41, seed])
    first = mean + E_SD * rng.standard_normal(n)
    drawn = draw_session(LOUD, first, 300.0, rng, **more)
    folder.mkdir(parents=True)
    write(drawn[0], "", folder, "sound")
    (folder / "recording.toml").write_text(
        f'rig = "drop"\n[drop]\n{lines}\n[air]\ndensity_kg_m3 = 0.0\n'
    )
    return read_recording(folder), drawn


def named(quantities):
    return {q.name: q for q in quantities}


@pytest.mark.parametrize(("seed", "mean"), [(0, 0.6), (1, 0.5), (2, 0.88)])
def test_ten_drops_are_ten_and_their_mean_has_the_scatter_in_it(tmp_path, seed, mean):
    """Times are known to 0.05 ms, e of a drop to 0.0015 by the height: the interval is
    Student's of the scatter that was drawn, the height's error added."""
    recording, drawn = session(tmp_path / "ten", seed, mean=mean)
    seen = observe(recording)
    truth = np.array([d.e[0] for d in drawn])
    q = named(seen.quantities)["restitution_normal"]
    assert len(seen.repeats) == N and q.quality == GOOD
    assert abs(q.value - truth.mean()) < 2e-3
    by_scatter = stats.t.ppf(0.975, N - 1) * truth.std(ddof=1) / np.sqrt(N) / 1.96
    by_height = mean / 300 / 2
    assert q.sd == pytest.approx(np.hypot(by_scatter, by_height), rel=0.1)
    each = [named(one)["restitution_normal"].value for one in seen.repeats]
    np.testing.assert_allclose(each, truth, atol=4e-3)
    first = seen.bounces[seen.bounces.bounce == 1]
    assert list(first["drop"]) == list(range(1, N + 1))
    np.testing.assert_allclose(first.t_s, [d.times[0] for d in drawn], atol=1e-3)


def test_the_command_counts_events_and_calibration_and_diagnosis_get_all(tmp_path):
    session(tmp_path / "bench" / "ten")
    out = tmp_path / "out"
    ran = CliRunner().invoke(
        app, ["measure", str(tmp_path / "bench"), "--out", str(out)]
    )
    assert ran.exit_code == 0, ran.output
    summary = pd.read_csv(out / "summary.csv").set_index("quantity")
    line = summary.loc["restitution_normal"]
    assert line.n == N and line.low < E < line.high
    assert line.scatter == pytest.approx(E_SD, rel=0.7)  # sd of ten: ± 45 % in 95 %
    whole = pd.read_csv(out / "measurements.csv").set_index("quantity")
    row = whole.loc["restitution_normal"]
    assert (row.value - 1.96 * row.sd, row.value + 1.96 * row.sd) == pytest.approx(
        (line.low, line.high), abs=1e-5
    )
    assert (out / "overlays" / "ten.png").is_file()
    assert "10 drops heard" in pd.read_csv(out / "notes.csv").note.to_list()
    (read,) = read_bench(tmp_path / "bench")
    assert len(read.readings) == N
    drops = read_drops(tmp_path / "bench")
    assert [d.recording for d in drops] == [f"ten/{k}" for k in range(1, N + 1)]
    assert all(len(d.contacts_s) > 2 for d in drops)


def test_one_file_of_ten_drops_and_ten_of_one_have_one_mean(tmp_path):
    """The same sound cut between the drops: each impact is heard to a tenth of a
    millisecond either way."""
    recording, drawn = session(tmp_path / "ten", 3)
    whole = named(observe(recording).quantities)["restitution_normal"]
    ends = [0.0, *((a.times[-1] + b.times[0]) / 2 for a, b in pairwise(drawn))]
    values = []
    for k, (begin, one) in enumerate(zip(ends, drawn)):
        end = ends[k + 1] if k + 1 < N else one.times[-1] + 1
        part = one.samples[int(begin * one.rate) : int(end * one.rate)]
        folder = tmp_path / f"{k}"
        folder.mkdir()
        write(replace(one, samples=part), "", folder, "sound")
        (folder / "recording.toml").write_text(
            (recording.path / "recording.toml").read_text()
        )
        found = observe(read_recording(folder))
        assert found.repeats == ()
        values.append(named(found.quantities)["restitution_normal"].value)
    assert np.mean(values) == pytest.approx(whole.value, abs=5e-4)


def test_impacts_set_by_hand_belong_to_the_drop_beside_them(tmp_path):
    recording, drawn = session(tmp_path / "three", 4, n=3)
    second = drawn[1].times
    found = impacts_in_sound(recording.files[0], recording).drops
    assert len(found) == 3
    struck = ", ".join(f"{t:.4f}" for t in found[1].times)
    without, _ = session(
        tmp_path / "two", 4, n=3, lines=f"impacts_struck_s = [{struck}]"
    )
    left = impacts_in_sound(without.files[0], without).drops
    assert [d.times[0] for d in left] == [found[0].times[0], found[2].times[0]]
    less, _ = session(
        tmp_path / "less", 4, n=3, lines=f"impacts_struck_s = [{second[1]:.4f}]"
    )
    fewer = impacts_in_sound(less.files[0], less).drops
    assert [len(d.times) for d in fewer] == [
        len(found[0].times),
        len(found[1].times) - 1,
        len(found[2].times),
    ]


def test_a_further_drop_is_not_made_of_handling(tmp_path):
    """One drop between two loud minutes of handling is one drop."""
    for seed in range(3):
        recording, _ = session(tmp_path / f"{seed}", seed + 10, n=2, handling=25)
        assert len(impacts_in_sound(recording.files[0], recording).drops) == 2
