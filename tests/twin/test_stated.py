"""What recordings state of their conditions and of the reading arrives with every
reader, the recording's before the bench's."""

import numpy as np
import pandas as pd
import pytest

from benchtwin.bench.priors import unstated_sd
from benchtwin.measure.observe import observe
from benchtwin.rigs.drop.read import read_drops
from benchtwin.rigs.pile.read import read_piles
from benchtwin.rigs.roll.read import FEW_ROWS, LEAST_ROWS, read_rolls
from benchtwin.rigs.roll.roll_path import ends_on_incline
from benchtwin.rigs.slide.read import read_slides
from benchtwin.vision.measurement import FAILED, MeasurementError
from benchtwin.vision.recording import read_recording

READERS = {
    "drop": read_drops,
    "slide": read_slides,
    "roll": read_rolls,
    "pile": read_piles,
}
EVIDENCE = {  # by rig: what can be read, and what cannot
    "drop": [
        ("impacts.csv", "t_s\n0.1\n0.4\n0.6\n"),
        ("track.csv", "t_s,x_mm,y_mm\n0,0,0\n1,0,0\n2,0,0\n"),
    ],
    "slide": [
        ("readings.csv", "slide_angle_deg\n20\n20.5\n"),
        ("readings.csv", "run_out_mm\n3\n"),
    ],
    "roll": [
        ("readings.csv", "run_out_mm\n100\n104\n"),
        ("track.csv", "t_s,x_mm,y_mm\n0,0,0\n1,0,0\n2,0,0\n"),
    ],
    "pile": [("readings.csv", "repose_angle_deg\n30\n")],
}
BENCH = (
    '[conditions]\nmoisture_pct = 12\nplate = "A"\n[reading]\nresolution_deg = 0.5\n'
)


@pytest.mark.parametrize(
    ("rig", "evidence"),
    [(rig, e) for rig, several in EVIDENCE.items() for e in several],
)
def test_conditions_and_reading_arrive_with_every_reader_if_there_is_something_or_not(
    tmp_path, rig, evidence
):
    (tmp_path / "bench.toml").write_text(BENCH, encoding="utf8")
    for name, more in (
        ("a", ""),
        (
            "b",
            '[conditions]\nplate = "B"\nload_g = 3\n[reading]\nresolution_deg = 0.1\n',
        ),
    ):
        (tmp_path / name).mkdir()
        (tmp_path / name / "recording.toml").write_text(
            f'rig = "{rig}"\n{more}', encoding="utf8"
        )
        (tmp_path / name / evidence[0]).write_text(evidence[1], encoding="utf8")
    first, second = READERS[rig](tmp_path)
    assert first.description["conditions"] == {"moisture_pct": 12.0, "plate": "A"}
    assert second.description["conditions"] == {
        "moisture_pct": 12.0,
        "plate": "B",
        "load_g": 3.0,
    }
    assert [s.description["reading"]["resolution_deg"] for s in (first, second)] == [
        0.5,
        0.1,
    ]


def test_readout_and_rails_arrive_too_and_what_is_not_stated_is_not_there(tmp_path):
    stated = (
        "[camera]\nreadout_s = 0.004\n[roll]\nrail_gap_mm = 6\n[seed]\nlength_mm = 15\n"
    )
    for name, more in (("a", stated), ("b", "")):
        roll(tmp_path / name, "track.csv", np.linspace(0, 1, 40), more=more)
    first, second = (s.description for s in read_rolls(tmp_path))
    assert (first["camera"]["readout_s"], first["roll"]["rail_gap_mm"]) == (0.004, 6.0)
    assert "readout_s" not in second["camera"] and "rail_gap_mm" not in second["roll"]
    assert second["conditions"] == {} and second["reading"] == {}


def roll(folder, name, time, *, length=800, accelerates=1000.0, more="", **columns):
    """A ball that is seen at these times [s], from 100 mm on, at 200 mm/s at first;
    incline of that length [mm]."""
    folder.mkdir(parents=True)
    stated = "" if length is None else f"incline_length_mm = {length}\n"
    more = (
        more
        if "[roll]" in more
        else f"[roll]\n{more}"
        if "[" not in more
        else f"{more}[roll]\n"
    )
    text = more.replace("[roll]\n", f"[roll]\nincline_deg = 14\n{stated}")
    (folder / "recording.toml").write_text(f'rig = "roll"\n{text}', encoding="utf8")
    x = 100 + 200 * time + accelerates * time**2 / 2
    table = pd.DataFrame(
        {"x_mm": x, "t_s": time}
        | ({"y_mm": 0.0} if name == "track.csv" else {})
        | columns
    )
    table.to_csv(folder / name, index=False)
    return x


@pytest.mark.parametrize("name", ["track.csv", "gates.csv"])
@pytest.mark.parametrize("rows", [LEAST_ROWS, 5, 12])
def test_a_roll_past_a_few_gates_is_read_as_a_track(tmp_path, name, rows):
    time = np.linspace(0, 0.9, rows)
    x = roll(tmp_path / "a", name, time)
    (seen,) = read_rolls(tmp_path)
    assert not seen.trouble and seen.gates == (name == "gates.csv")
    np.testing.assert_allclose(seen.x_mm, x)
    np.testing.assert_allclose(seen.time_s, time)
    assert (
        seen.description["roll"]["seen_direction"] == "+x"
        and np.isnan(seen.sd_mm).all()
    )


def test_a_gate_s_doubt_in_time_is_one_in_place_by_the_speed_there(tmp_path):
    time = np.linspace(0, 0.9, 7)
    roll(tmp_path / "a", "gates.csv", time, sd_s=np.full(7, 2e-3))
    (seen,) = read_rolls(tmp_path)
    assert seen.sd_mm[1:-1] == pytest.approx(
        np.hypot(2e-3 * (200 + 1000 * time[1:-1]), unstated_sd("gate-place"))
    )
    assert (np.diff(seen.sd_mm) > 0).all()


def test_gates_passed_the_other_way_are_turned_round(tmp_path):
    folder = tmp_path / "a"
    roll(folder, "gates.csv", np.linspace(0, 0.9, 5))
    table = pd.read_csv(folder / "gates.csv")
    table.assign(x_mm=-table.x_mm).to_csv(folder / "gates.csv", index=False)
    (seen,) = read_rolls(tmp_path)
    assert (
        seen.description["roll"]["seen_direction"] == "-x"
        and (np.diff(seen.x_mm) > 0).all()
    )


def test_few_rows_are_read_only_where_they_go_one_way(tmp_path):
    for name, n, spoil in (
        ("few", 5, True),
        ("many", FEW_ROWS, True),
        ("three", LEAST_ROWS - 1, False),
    ):
        folder = tmp_path / name
        x = roll(folder, "track.csv", np.linspace(0, 0.9, n))
        x[2] = x[0] - 30 if spoil else x[2]
        table = pd.read_csv(folder / "track.csv")
        table.assign(x_mm=x).to_csv(folder / "track.csv", index=False)
    seen = {s.recording: s.trouble for s in read_rolls(tmp_path)}
    assert "5 usable rows, and x_mm goes back and forth" in seen["few"]
    assert seen["many"] == ""  # its neighbours tell
    assert f"at least {LEAST_ROWS}" in seen["three"]


@pytest.mark.parametrize(
    ("length", "accelerates", "stays"),
    [
        (800, 1000.0, True),
        (585, 1000.0, True),
        (400, 1000.0, False),
        (800, -200.0, False),
        (None, 1000.0, None),
        (None, -200.0, False),
    ],
)
@pytest.mark.parametrize("rows", [5, 200])
def test_a_roll_that_never_leaves_its_incline_says_so(
    tmp_path, length, accelerates, stays, rows
):
    """It runs 585 mm; one that slows down lies on the level, however long the incline.
    Where no length is stated, many rows tell (None), few do not."""
    roll(
        tmp_path / "a",
        "track.csv",
        np.linspace(0, 0.9, rows),
        length=length,
        accelerates=accelerates,
    )
    (seen,) = read_rolls(tmp_path)
    expected = rows == 200 if stays is None else stays
    assert seen.description["roll"].get("ends_on_incline") is expected


def test_a_release_that_is_waited_for_and_noise_do_not_hide_the_incline():
    time = np.arange(0, 1.5, 0.005)
    x = 1000 * np.clip(time - 0.5, 0, None) ** 2 / 2 + np.random.default_rng(1).normal(
        0, 0.1, len(time)
    )
    assert ends_on_incline(time, x, 520.0) and ends_on_incline(time, -x, 520.0)
    assert not ends_on_incline(time, x, 480.0)
    assert not ends_on_incline(time[:3], np.zeros(3), 480.0)


def test_gates_on_an_incline_measure_an_acceleration(tmp_path):
    roll(tmp_path / "a", "gates.csv", np.linspace(0, 0.9, 5), length=800)
    observation = observe(read_recording(tmp_path / "a"))
    found = {q.name: q for q in observation.quantities}
    assert (
        found["acceleration"].value == pytest.approx(1.0, abs=2e-3)
        and len(observation.track) == 5
    )
    # a (1 + I/(m r²)) = g (sin β − μ cos β)
    expected = np.tan(np.radians(14)) - 1.4 / 9.80665 / np.cos(np.radians(14))
    assert found["rolling_resistance"].value == pytest.approx(expected, abs=1e-3)


def test_gates_behind_an_incline_that_are_passed_ever_faster_tell_nothing(tmp_path):
    roll(tmp_path / "a", "gates.csv", np.linspace(0, 0.9, 5), length=300)
    observation = observe(read_recording(tmp_path / "a"))
    assert {q.quality for q in observation.quantities} == {FAILED}
    assert all(
        "does not slow down on the level" in q.reason for q in observation.quantities
    )


def test_a_ball_that_falls_between_its_rails_is_refused(tmp_path):
    for name, gap in (("falls", 15.0), ("rolls", 14.0)):
        roll(
            tmp_path / name,
            "gates.csv",
            np.linspace(0, 0.9, 5),
            more=f"[seed]\nlength_mm = 15\n[roll]\nrail_gap_mm = {gap}\n",
        )
    seen = {s.recording: s.trouble for s in read_rolls(tmp_path)}
    assert (
        seen["rolls"] == ""
        and "rail_gap_mm = 15: a ball of 15 mm falls between such rails"
        in seen["falls"]
    )


def test_gates_are_those_of_their_rig_and_come_behind_a_track(tmp_path):
    roll(tmp_path / "a", "gates.csv", np.linspace(0, 0.9, 5))
    assert read_recording(tmp_path / "a").evidence == "gates.csv"
    (tmp_path / "a" / "recording.toml").write_text('rig = "drop"\n', encoding="utf8")
    with pytest.raises(MeasurementError, match="column y_mm is missing"):
        observe(read_recording(tmp_path / "a"))
    assert "y_mm is missing" in read_drops(tmp_path)[0].trouble
    for name, evidence in (("impacts.csv", "gates.csv"), ("track.csv", "track.csv")):
        (tmp_path / "a" / name).write_text("t_s\n", encoding="utf8")
        assert read_recording(tmp_path / "a").evidence == evidence
