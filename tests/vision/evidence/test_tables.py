"""CSV evidence: what is mended with a note, what is refused with file, column and
row."""

import numpy as np
import pytest

from benchtwin.vision.evidence.tables import (
    read_gates,
    read_impacts_csv,
    read_track_csv,
)
from benchtwin.vision.measurement import MeasurementError
from benchtwin.vision.motion.track import make_track, track_from_table
from benchtwin.vision.recording import Camera


def write(folder, text, name="track.csv"):
    file = folder / name
    file.write_text(text, encoding="utf8")
    return file


GOOD = "t_s,x_mm,y_mm\n0,0,3\n0.1,0,2\n0.2,0,1\n0.3,0,0\n"


def test_a_plain_track(tmp_path):
    table = read_track_csv(write(tmp_path, GOOD))
    assert table.notes == () and len(table.rows) == 4


@pytest.mark.parametrize(
    ("text", "name", "read"),
    [
        ("t_s;x_mm;y_mm\n0;0;3\n0,1;0;2,5\n0,2;0;1\n", "track.csv", read_track_csv),
        (
            "t_s\tx_mm\ty_mm\n0\t0\t3\n0.1\t0\t2.5\n0.2\t0\t1\n",
            "track.csv",
            read_track_csv,
        ),
        (
            "x_mm;t_s\n0;0\n10;0,1\n20;0,2\n30;0,3\n",
            "gates.csv",
            lambda file: read_gates(file, "roll"),
        ),
        ("t_s\n0\n0,1\n0,2\n", "impacts.csv", read_impacts_csv),
        (
            "# heard by a phone; in a corner\nt_s\n0\n0.1\n0.2\n",
            "impacts.csv",
            read_impacts_csv,
        ),
    ],
)
def test_semicolons_tabs_and_decimal_commas_are_read_where_they_are_plain(
    tmp_path, text, name, read
):
    table = read(write(tmp_path, text, name))
    assert table.rows["t_s"].to_numpy()[:3] == pytest.approx([0, 0.1, 0.2])
    assert "y_mm" not in table.rows or table.rows["y_mm"].to_list() == [3, 2.5, 1]


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("", "empty"),
        ("t_s,x_mm,y_mm\n", "no rows"),
        ("t_s,x_mm\n0,1\n", "y_mm is missing"),
        (GOOD.replace("y_mm", "y_mn"), "y_mm is missing"),
        ("t_s,x_mm,y_mm,agle_deg\n0,0,0,1\n0.1,0,0,1\n0.2,0,0,1\n", "agle_deg"),
        ("t_s,x_mm,y_mm\n0,0,3\n0.1,zero,2\n0.2,0,1\n", "'zero' in row 3"),
        ("t_s,x_mm,y_mm\n0,0,3\n0.1,0,2\n0.1,0,1\n0.2,0,0\n", "two rows for t_s = 0.1"),
        (
            "t_s,x_mm,y_mm\n0,0,3\n2.2e-308,0,2\n0.1,0,1\n0.2,0,0\n",
            "two rows for t_s = 2.2e-308",
        ),
        ("t_s,x_mm,y_mm\n0,0,3\n0.1,,2\n0.2,nan,1\n0.3,0,1\n", "2 usable rows"),
    ],
)
def test_what_cannot_be_read_is_told_by_file_and_place(tmp_path, text, says):
    with pytest.raises(MeasurementError, match=says) as caught:
        read_track_csv(write(tmp_path, text))
    assert "track.csv" in str(caught.value)


def test_an_unknown_column_names_the_nearest_known(tmp_path):
    with pytest.raises(MeasurementError, match="did you mean angle_deg"):
        read_track_csv(
            write(tmp_path, "t_s,x_mm,y_mm,agle_deg\n0,0,0,1\n0.1,0,0,1\n0.2,0,0,1\n")
        )


def test_nan_rows_are_left_out_and_rows_put_in_order_with_notes(tmp_path):
    text = "t_s,x_mm,y_mm\n0,0,3\n0.2,0,1\n0.1,0,2\n0.25,,1\n0.3,0,0\n"
    table = read_track_csv(write(tmp_path, text))
    assert list(table.rows.t_s) == [0, 0.1, 0.2, 0.3]
    assert any("row 5" in note for note in table.notes) and any(
        "backwards" in note for note in table.notes
    )


def test_impacts_must_increase(tmp_path):
    assert (
        len(
            read_impacts_csv(
                write(tmp_path, "t_s\n0.25\n0.5\n0.62\n", "impacts.csv")
            ).rows
        )
        == 3
    )
    with pytest.raises(MeasurementError, match="in row 4 does not increase"):
        read_impacts_csv(write(tmp_path, "t_s\n0.25\n0.5\n0.5\n", "impacts.csv"))
    with pytest.raises(MeasurementError, match="interval needs two"):
        read_impacts_csv(write(tmp_path, "t_s\n0.25\n", "impacts.csv"))


GATES = "x_mm,t_s,sd_s\n0,0,0.001\n100,0.5,0.001\n300,0.9,0.001\n700,1.4,0.001\n"


def test_gates_come_in_the_order_of_time_those_that_did_not_fire_left_out(tmp_path):
    table = read_gates(
        write(
            tmp_path,
            "gate,x_mm,t_s\nE,900,1.6\nA,0,0\nB,100,0.5\nC,300,\nD,700,1.4\n",
            "gates.csv",
        ),
        "roll",
    )
    assert list(table.rows.x_mm) == [0, 100, 700, 900] and "row 5" in table.notes[0]
    other_way = (
        GATES.replace("100,", "-100,").replace("300,", "-300,").replace("700,", "-700,")
    )
    down = read_gates(write(tmp_path, other_way, "gates.csv"), "roll")
    assert list(down.rows.x_mm) == [0, -100, -300, -700] and down.notes == ()


@pytest.mark.parametrize(
    ("text", "says"),
    [
        (
            "x_mm,t_s\n0,0\n100,0.5\n300,0.9\n",
            "3 passages; a roll past light gates needs at least 4",
        ),
        (GATES.replace("0.9", "0.5"), "two gates at t_s = 0.5"),
        (GATES.replace("300,", "100,"), "x_mm = 100 in row 4 is out of its order"),
        (GATES.replace("300,", "50,"), "x_mm = 50 in row 4 is out of its order"),
        (GATES.replace("700,", "0,"), "out of its order"),
        (
            GATES.replace("0.9,0.001", "0.9,0"),
            "sd_s = 0 in row 4; it should be above 0",
        ),
        (GATES.replace("x_mm", "x_m"), "x_mm is missing"),
        (GATES.replace("sd_s", "sd_ms"), "did you mean sd_s"),
        (GATES.replace("0.9,", "late,"), "'late' in row 4"),
    ],
)
def test_gates_that_cannot_be_read_are_told_by_file_and_place(tmp_path, text, says):
    with pytest.raises(MeasurementError, match=says) as caught:
        read_gates(write(tmp_path, text, "gates.csv"), "roll")
    assert "gates.csv" in str(caught.value)


def test_gates_of_a_drop_are_passed_down_and_up(tmp_path):
    text = "y_mm,t_s\n300,0\n200,0.1\n50,0.2\n50,0.23\n200,0.4\n"
    assert list(read_gates(write(tmp_path, text, "gates.csv"), "drop").rows.y_mm) == [
        300,
        200,
        50,
        50,
        200,
    ]
    with pytest.raises(
        MeasurementError, match="y_mm = 350 in row 3 is out of its order"
    ):
        read_gates(
            write(tmp_path, text.replace("200,0.1", "350,0.1"), "gates.csv"), "drop"
        )
    with pytest.raises(MeasurementError, match="y_mm is missing"):
        read_gates(write(tmp_path, GATES, "gates.csv"), "drop")


def test_a_track_goes_to_a_table_and_back():
    track = make_track(
        np.arange(5) / 100,
        np.arange(5.0),
        -np.arange(5.0),
        sd=0.1,
        angle_deg=np.arange(5.0),
    )
    track = track.marked(np.array([False, True, False, False, False]))
    back = track_from_table(track.to_table(), Camera())
    assert np.allclose(back.y, track.y) and np.array_equal(back.outlier, track.outlier)
    assert back.unit == "mm" and back.timed and back.tilt_deg is None


def test_pixels_and_frames_become_millimetres_and_seconds_where_the_camera_knows(
    tmp_path,
):
    rows = read_track_csv(
        write(tmp_path, "frame,x_px,y_px\n10,0,3\n11,0,2\n13,0,1\n")
    ).rows
    bare = track_from_table(rows, Camera())
    assert (bare.unit, bare.timed, bare.time_unit) == ("px", False, "frame")
    known = track_from_table(rows, Camera(fps=100, mm_per_px=0.5))
    assert (
        known.unit == "mm"
        and np.allclose(known.y, [1.5, 1.0, 0.5])
        and np.allclose(known.t_s, [0, 0.01, 0.03])
    )


def test_a_gap_in_time_is_a_gap_in_frame_numbers(tmp_path):
    rows = read_track_csv(
        write(tmp_path, "t_s,x_mm,y_mm\n0,0,3\n0.01,0,2\n0.02,0,2\n0.05,0,1\n")
    ).rows
    assert list(track_from_table(rows, Camera()).frame) == [0, 1, 2, 5]
