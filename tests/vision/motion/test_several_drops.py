"""Several drops in one recording: counted, measured each by itself, and their mean with
the scatter between them.

The sound is drawn by benchmarks/drawn_sound.py, which shares nothing with the reader.
"""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pandas as pd
import pytest
from drawn_sound import SCENES, draw_session, write
from scipy import stats
from synthetic.film import Look, film, write_frames
from synthetic.motion import Motion, draw_drop
from typer.testing import CliRunner

from benchtwin.bench.keys import Air, Camera
from benchtwin.command_line import app
from benchtwin.measure.observe import observe
from benchtwin.rigs.drop.keys import Drop
from benchtwin.rigs.drop.read import read_drops
from benchtwin.twin.bench_folder import read_bench
from benchtwin.vision.measurement import GOOD
from benchtwin.vision.motion.drop_sound import impacts_in_sound
from benchtwin.vision.motion.split_flights import releases
from benchtwin.vision.recording import Recording, read_recording

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


MORE = ((1, 0.5), (2, 0.88))


@pytest.mark.parametrize(
    ("seed", "mean"),
    [(0, 0.6), *(pytest.param(*case, marks=pytest.mark.slow) for case in MORE)],
)
def test_ten_drops_are_ten_and_their_mean_has_the_scatter_in_it(tmp_path, seed, mean):
    """Times are known to 0.05 ms, the height to 5 mm: the interval is Student's of the
    scatter that was drawn, the height's error added."""
    recording, drawn = session(tmp_path / "ten", seed, mean=mean)
    seen = observe(recording)
    truth = np.array([d.e[0] for d in drawn])
    q = named(seen.quantities)["restitution_normal"]
    assert len(seen.repeats) == N and q.quality == GOOD
    assert abs(q.value - truth.mean()) < 2e-3
    by_scatter = stats.t.ppf(0.975, N - 1) * truth.std(ddof=1) / np.sqrt(N) / 1.96
    by_height = mean / 300 / 2 * 5
    assert q.sd == pytest.approx(np.hypot(by_scatter, by_height), rel=0.1)
    each = [named(one)["restitution_normal"].value for one in seen.repeats]
    np.testing.assert_allclose(each, truth, atol=4e-3)
    first = seen.bounces[seen.bounces.bounce == 1]
    assert list(first["drop"]) == list(range(1, N + 1))
    np.testing.assert_allclose(first.t_s, [d.times[0] for d in drawn], atol=1e-3)


@pytest.mark.slow
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


@pytest.mark.slow
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


def again(heights_e, hidden, rest_s=0.5, lift_s=0.6):
    """A motion in which the seed is let go several times, from 180 mm: between two
    drops it is lifted in sight, or (hidden) in a hand outside the picture's sight."""
    parts = [draw_drop(height_mm=180, restitution=e, rest_s=0.15) for e in heights_e]
    begins = np.cumsum([0.0, *(p.end_s + rest_s + lift_s for p in parts)])

    def path(time):
        time = np.asarray(time, float)
        x, y, angle = (np.zeros_like(time) for _ in range(3))
        for begin, end, part in zip(begins, begins[1:], parts):
            here = (time >= begin) & (time < end)
            x[here], y[here], angle[here] = part.path(time[here] - begin)
            lift = here & (time > end - lift_s)
            share = (time[lift] - end + lift_s) / lift_s
            low, high = y[lift], part.path(np.array([0.0]))[1]
            y[lift] = low + (high - low) * (3 * share**2 - 2 * share**3)
            if hidden:
                x[lift] = 5000.0
        return x, y, angle

    return Motion(path, float(begins[-1]) - lift_s, {})


@pytest.mark.slow
@pytest.mark.parametrize("hidden", [False, True])
def test_a_film_in_which_the_seed_is_released_again_counts_each_release(
    tmp_path, hidden
):
    """Three drops of 60 frames each give e to 0.005 in one drop of such films (tests of
    observe_motion); their mean and scatter are those of what was drawn."""
    truth = np.array([0.45, 0.55, 0.5])
    known = Recording(
        "again",
        tmp_path,
        "drop",
        "frames",
        (),
        camera=Camera(fps=240, mm_per_px=0.5, mm_per_px_sd=5e-4),
        air=Air(density_kg_m3=0),
        drop=Drop(height_mm=180),
    )
    look = Look(noise=3, plate_row=440)
    rng = np.random.default_rng(6)
    write_frames(known, film(again(truth, hidden), look, rng, fps=240))
    recording = read_recording(tmp_path)
    seen = observe(recording)
    each = [named(one)["restitution_normal"].value for one in seen.repeats]
    np.testing.assert_allclose(each, truth, atol=0.01)
    q = named(seen.quantities)["restitution_normal"]
    assert q.value == pytest.approx(truth.mean(), abs=0.006) and q.quality == GOOD
    by_scatter = stats.t.ppf(0.975, 2) * 0.05 / np.sqrt(3) / 1.96
    assert q.sd == pytest.approx(by_scatter, rel=0.2)
    assert sorted(set(seen.bounces["drop"])) == [1, 2, 3]
    drops = read_drops(tmp_path)
    assert [len(d.contacts_s) > 0 and d.trouble == "" for d in drops] == [True] * 3


def test_one_drop_is_one_also_where_the_seed_is_lifted_at_the_end():
    """Also where a lift follows that no fall follows, or the track begins in a
    rebound."""
    t = np.linspace(0, 1.5, 600)
    fall = draw_drop(height_mm=180, restitution=0.6, rest_s=0.1).path(t)[1]
    assert len(releases(fall)) == 1
    lifted = np.concatenate([fall, np.linspace(fall[-1], 180, 200)])
    assert len(releases(lifted)) == 1
    late = fall[t > 0.29]
    assert len(releases(late)) == 1
    twice = np.concatenate([lifted, fall])
    first, second = releases(twice)
    assert 600 <= first.stop == second.start <= 650
