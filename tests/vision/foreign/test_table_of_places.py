"""Tables of t, x, y as Tracker exports them and as scripts write them: parting,
decimals, several tracks, units, y down."""

import struct
import tracemalloc
import zlib

import numpy as np
import pytest
from bouncing import ball
from measure_all import measure
from scipy.io import savemat
from workbooks import workbook

from benchtwin.vision.foreign import read_foreign, tool_of
from benchtwin.vision.foreign.as_evidence import read_track
from benchtwin.vision.measurement import MeasurementError

FPS = 120.0
FRAME, X, Y = ball(FPS)
T = FRAME / FPS


def lines(parting: str, comma: bool, *columns: np.ndarray) -> list[str]:
    rows = [parting.join(f"{v:.9g}" for v in row) for row in zip(*columns)]
    return [row.replace(".", ",") for row in rows] if comma else rows


@pytest.mark.parametrize(
    ("parting", "comma"),
    [("\t", False), ("\t", True), (";", False), (";", True), (",", False), (" ", True)],
)
@pytest.mark.parametrize("named", [False, True])
def test_every_parting_and_decimal_is_read(tmp_path, parting, comma, named):
    name = [f"{parting}mass A{parting}"] if named and parting != " " else []
    heading = parting.join(("t", "x", "y"))
    (tmp_path / "run.txt").write_text(
        "\n".join([*name, heading, *lines(parting, comma, T, X, Y)]), encoding="utf8"
    )
    rows = read_track(tmp_path / "run.txt").rows
    assert rows["t_s"].to_numpy() == pytest.approx(T, abs=1e-8)
    assert rows["y_mm"].to_numpy() == pytest.approx(1000 * Y, abs=1e-4)
    assert rows["x_mm"].to_numpy() == pytest.approx(1000 * X, abs=1e-4)


def test_tracks_side_by_side_with_one_clock(tmp_path):
    """As "Export Data" writes two tracks: a mark for gnuplot, names over columns, and a
    separator at the end of the headings."""
    rows = [
        f"{t:.6E},{x:.6E},{y:.6E},0.5,{'' if k < 3 else '0.1'}"
        for k, (t, x, y) in enumerate(zip(T, X, Y))
    ]
    (tmp_path / "run.csv").write_text(
        "\n".join(["#multi:", ",ball,,mark,,", "t,x,y,x,y,", *rows])
    )
    found = read_foreign(tmp_path / "run.csv")
    assert [(t.name, len(t.time)) for t in found.tracks] == [
        ("ball", len(T)),
        ("mark", len(T) - 3),
    ]
    assert found.tracks[0].y == pytest.approx(1000 * Y, abs=1e-2)


def test_tracks_side_by_side_each_with_its_clock(tmp_path):
    rows = [
        "\t".join(f"{v:.8g}" for v in (t, x, y, t + 1, 0.2, 0.3))
        for t, x, y in zip(T, X, Y)
    ]
    (tmp_path / "run.txt").write_text(
        "\n".join(["mass A\t\t\tmass B\t\t", "t\tx\ty\tt\tx\ty", *rows])
    )
    a, b = read_foreign(tmp_path / "run.txt").tracks
    assert (a.name, b.name) == ("mass A", "mass B")
    assert b.time == pytest.approx(T + 1, abs=1e-6)


@pytest.mark.parametrize(
    ("heading", "times", "unit", "value"),
    [
        ("t (ms),x (cm),y (cm)", 1000.0, 100.0, "mm"),
        ("t_s,x_m,y_m", 1.0, 1.0, "mm"),
        ("time [s],x [mm],y [mm]", 1.0, 1000.0, "mm"),
        ("t,x_in,y_in", 1.0, 1 / 0.0254, "mm"),
    ],
)
def test_units_come_from_the_headings(tmp_path, heading, times, unit, value):
    (tmp_path / "run.csv").write_text(
        "\n".join([heading, *lines(",", False, times * T, unit * X, unit * Y)])
    )
    found = read_foreign(tmp_path / "run.csv")
    assert (found.time_unit, found.length_unit) == ("s", value)
    assert found.tracks[0].time == pytest.approx(T, abs=1e-6) and found.tracks[
        0
    ].y == pytest.approx(1000 * Y, abs=1e-3)
    assert not found.doubt


@pytest.mark.parametrize(
    ("unit", "times"),
    [("m", 1.0), ("cm", 100.0), ("mm", 1000.0), ("in", 1 / 0.0254), ("ft", 1 / 0.3048)],
)
def test_a_unit_that_nobody_states_is_the_one_in_which_the_fall_is_gravity_s(
    tmp_path, unit, times
):
    (tmp_path / "run.csv").write_text(
        "\n".join(["t,x,y", *lines(",", False, T, times * X, times * Y)])
    )
    found = read_foreign(tmp_path / "run.csv")
    assert found.tracks[0].y == pytest.approx(1000 * Y, abs=1e-3)
    assert any(
        f"lengths in {unit}, which the file does not say" in g for g in found.guesses
    )


def test_pixels_of_a_picture_are_turned_to_y_up_and_measured(tmp_path):
    x, y = np.round(400 * X), np.round(480 - 800 * Y)
    (tmp_path / "run.csv").write_text("\n".join(["t,x,y", *lines(",", False, T, x, y)]))
    found = read_foreign(tmp_path / "run.csv")
    assert found.length_unit == "px" and any("y is down" in g for g in found.guesses)
    (observation,) = measure(tmp_path / "run.csv")
    e = next(q for q in observation.quantities if q.name == "restitution")
    assert abs(e.value - 0.8) < max(
        3 * e.sd, 0.005
    )  # rounded to whole pixels of 1.25 mm


ASKED = {
    "t (s)": (1000.0, "are the times milliseconds"),
    "time (s)": (1 / 60, "are the times minutes"),
    "t_s": (FPS, "are the times frame numbers, at 120 frames per second"),
}


@pytest.mark.parametrize("heading", ASKED)
def test_times_that_gravity_contradicts_are_asked_and_not_changed(tmp_path, heading):
    times, said = ASKED[heading]
    (tmp_path / "run.csv").write_text(
        "\n".join(
            [
                f"{heading},x (mm),y (mm)",
                *lines(",", False, times * T, 1000 * X, 1000 * Y),
            ]
        )
    )
    found = read_foreign(tmp_path / "run.csv")
    assert said in found.doubt
    assert found.tracks[0].time == pytest.approx(times * T, rel=1e-8)
    with pytest.raises(
        MeasurementError, match=rf"run\.csv: the fall accelerates by .* m/s².*{said}"
    ):
        read_track(tmp_path / "run.csv")


@pytest.mark.parametrize(
    ("heading", "times", "lengths", "said"),
    [
        ("t (s),x (m),y (m)", 30.0, 1.0, "are the times frame numbers, at 30"),
        (
            "t (ms),x (m),y (m)",
            1.0,
            1.0,
            "are the times seconds or the lengths micrometres?",
        ),
        ("t (s),x (m),y (m)", 1.0, 1000.0, "are the lengths millimetres?"),
    ],
)
def test_what_is_asked_stands_beside_what_the_heading_says(
    tmp_path, heading, times, lengths, said
):
    clock = np.arange(0, 1, 1 / 30) if times == 30 else T
    y = np.interp(clock, T, Y)
    rows = lines(
        ",",
        False,
        np.round(times * clock) if times == 30 else times * clock,
        lengths * 0.02 * clock,
        lengths * y,
    )
    (tmp_path / "run.csv").write_text("\n".join([heading, *rows]))
    assert said in read_foreign(tmp_path / "run.csv").doubt


def test_lengths_without_a_unit_are_no_pixels_of_a_stated_scale(tmp_path):
    """A roll in metres that the table does not name, beside a camera's scale: a run-out
    of a thousandth would be measured."""
    (tmp_path / "recording.toml").write_text(
        'rig = "roll"\n[camera]\nmm_per_px = 0.3\n'
    )
    (tmp_path / "run.txt").write_text(
        "\n".join(["t\tx\ty", *lines("\t", False, T, 0.3 * (1 - np.exp(-T)), 0 * T)])
    )
    (reason,) = {q.reason for o in measure(tmp_path) for q in o.quantities}
    assert (
        "run.txt: its lengths have no unit, and [camera] mm_per_px = 0.3 is of pixels;"
        " write the unit into its heading" in reason
    )


def test_own_tables_are_asked_too(tmp_path):
    (tmp_path / "recording.toml").write_text('rig = "drop"\n')
    (tmp_path / "track.csv").write_text(
        "\n".join(["t_s,x_mm,y_mm", *lines(",", False, T / 60, 1000 * X, 1000 * Y)])
    )
    (reason,) = {q.reason for o in measure(tmp_path) for q in o.quantities}
    assert "track.csv" in reason and "are the times minutes" in reason


WRONG = {
    "t\tx\ty\n0.1\t1,5\t1\n0.2\t1\t1\n0.3\t1\t1\n": (
        "numbers with points and with commas"
    ),
    "t\tx\ty\tx\n0.1\t1.5\t1\t2\n0.2\t1\t1\t2\n0.3\t1\t1\t2\n": (
        "2 columns x and 1 columns y"
    ),
    "t,x,y\n0.1,1,1\n0.2,one,1\n0.3,1,1\n": "x = 'one' in line 3 is not a number",
    "t,x,y\n0.1,1,1\n0.1,2,1\n0.3,1,1\n": "two places at the time 0.1",
    "t,x,y\n0.1,1,1\n0.2,,1\n0.3,1,1\n": "no track of 3 or more places",
    "t,x,y\n0.1,1,1\n0.2,1e300,1\n0.3,1,1\n0.4,1,1\n": "x = 1e.300 in line 3 cannot be",
}


@pytest.mark.parametrize("content", WRONG)
def test_what_is_wrong_is_one_sentence_with_the_file(tmp_path, content):
    (tmp_path / "run.txt").write_text(content)
    with pytest.raises(MeasurementError, match=rf"run\.txt: .*{WRONG[content]}"):
        read_track(tmp_path / "run.txt")


@pytest.mark.parametrize(
    "content",
    [
        "",
        "a note\n",
        "t_s,x_mm,y_mm\n0,0,0\n1,0,0\n2,0,0\n",
        "frame,t_s,x_px,y_px\n0,0,0,0\n",
        "x\n" * 30,
    ],
)
def test_other_files_are_left_alone(tmp_path, content):
    (tmp_path / "run.txt").write_text(content)
    assert tool_of(tmp_path / "run.txt") == ""


SUMMARY = ["", "Track \tLength\tDistance traveled\tNr of Frames", "1\t710.2\t366.5\t2"]


@pytest.mark.parametrize("by", ["\t", " "])
def test_a_table_of_mtrack2_is_frames_and_pixels_turned_up(tmp_path, by):
    """Object by object with a mark, a line of words under the headings, a table of
    lengths behind; y down. With blanks between cells empty marks are not there, and
    full ones move what follows; a second object stands still."""
    mark = {"\t": ["", "*"], " ": [None, "*"]}[by]
    rows = []
    for k, y in zip(FRAME, Y):
        one, other = mark[int(k % 7 == 0)], mark[int(k % 5 == 0)]
        cells = [k, f"{120 + 4 * k / FPS:.5f}", f"{400 - 500 * y:.5f}", one]
        cells += ["300.50000", "380.25000", other]
        rows.append(by.join(str(c) for c in cells if c is not None))
    head = ["Frame X1 Y1 Flag1 X2 Y2 Flag2".replace(" ", by), f"Tracks 1 to 2 {by}"]
    behind = [line.replace("\t", by) for line in SUMMARY]
    (tmp_path / "track.txt").write_text("\n".join([*head, *rows, *behind]))
    found = read_foreign(tmp_path / "track.txt")
    assert (found.time_unit, found.length_unit) == ("frame", "px")
    track, other = found.tracks
    assert len(track.y) == len(Y) and np.ptp(other.x) == np.ptp(other.y) == 0
    assert np.ptp(track.y) == pytest.approx(500 * np.ptp(Y), abs=1e-3)
    assert track.y[0] > track.y[len(track.y) // 6]  # it falls


def test_lines_without_a_time_are_passed_over_and_end_no_table(tmp_path):
    """Words in every cell among the numbers: what follows is of the same table."""
    rows = [f"{t:.5f},{x:.5f},{y:.5f}" for t, x, y in zip(T, X, Y)]
    rows.insert(20, "lost,lost,lost")
    (tmp_path / "fall.csv").write_text("\n".join(["t (s),x (m),y (m)", *rows]))
    (track,) = read_foreign(tmp_path / "fall.csv").tracks
    assert len(track.y) == len(Y)


@pytest.mark.parametrize(
    ("heading", "unit"),
    [
        ("Bild; Zeit (in s); Objekt 1 x-Koordinate; Objekt 1 y-Koordinate; vx", 1.0),
        ("n; temps (s); objet x / m; objet y / m; vitesse", 1.0),
        ("Nr; t/s; x/cm; y/cm; v/(cm/s)", 100.0),
        ("step; tiempo [s]; posición x (m); posición y (m); velocidad", 1.0),
    ],
)
def test_headings_of_other_languages_and_habits(tmp_path, heading, unit):
    rows = [
        f"{k}; {t:.5E}; {unit * x:.4E}; {unit * y:.4E}; ".replace(".", ",")
        for k, t, x, y in zip(FRAME, T, X, Y)
    ]
    above = ["Export of a tracking program", "measured by hand", ""]
    (tmp_path / "fall.csv").write_text("\n".join([*above, heading, *rows]))
    found = read_foreign(tmp_path / "fall.csv")
    assert found.tracks[0].y == pytest.approx(1000 * Y, abs=0.1)


@pytest.mark.parametrize(("heading", "falls"), [("t,y", True), ("time,x", False)])
def test_one_length_and_one_time(tmp_path, heading, falls):
    """A height over time falls; a way x is along a line."""
    (tmp_path / "run.csv").write_text("\n".join([heading, *lines(",", False, T, Y)]))
    found = read_foreign(tmp_path / "run.csv")
    assert any("one length a row" in g for g in found.guesses)
    (track,) = found.tracks
    moving, still = (track.y, track.x) if falls else (track.x, track.y)
    assert np.ptp(moving) > 0 and np.ptp(still) == 0


@pytest.mark.parametrize(
    "head", ["recording,bounce,t_s,height_mm,restitution", "nr,distance_mm"]
)
def test_one_length_among_other_columns_is_no_track(tmp_path, head):
    """A table of bounces has a time and a height, and is none; so are distances that
    are numbered."""
    cells = head.count(",") + 1
    rows = [",".join(["a", str(k), "0.1", "50", "0.6"][-cells:]) for k in range(9)]
    (tmp_path / "bounces.csv").write_text("\n".join([head, *rows]))
    assert tool_of(tmp_path / "bounces.csv") == ""


@pytest.mark.parametrize(
    ("heading", "unit"),
    [
        ("Zeit in Sekunden;x in Metern;y in Metern", 1.0),
        ("Temps (secondes);x (mètres);y (mètres)", 1.0),
        ("Tiempo [segundos];x [cm];altura [cm]", 100.0),
        ("Tempo (s);x, m;altezza, m", 1.0),
        ("Czas [s];x [m];Wysokość [m]", 1.0),
        ("Tijd (s);x (m);hoogte (m)", 1.0),
        ("Время, с;x, м;высота, м", 1.0),
        ("時間 (s);x (m);高さ (m)", 1.0),
        ("Run 1: Time;Run 1: X;Run 1: Y\ns;m;m", 1.0),
        ("Zeit;Ort x;Ort y\n(s);(cm);(cm)", 100.0),
    ],
)
def test_units_in_words_and_in_a_line_of_their_own(tmp_path, heading, unit):
    rows = lines(";", True, T, unit * X, unit * Y)
    (tmp_path / "fall.csv").write_text("\n".join([heading, *rows]), encoding="utf8")
    found = read_foreign(tmp_path / "fall.csv")
    assert found.tracks[0].y == pytest.approx(1000 * Y, abs=1e-3)
    assert not any("which the file does not say" in g for g in found.guesses)


def test_a_length_beside_x_and_y_is_no_place(tmp_path):
    """Of the way along a path, in another unit."""
    (tmp_path / "run.csv").write_text(
        "\n".join(["t (s),x (m),y (m),distance (cm)", *lines(",", False, T, X, Y, Y)])
    )
    (track,) = read_foreign(tmp_path / "run.csv").tracks
    assert track.y == pytest.approx(1000 * Y, abs=1e-3)


@pytest.mark.parametrize(
    "heading",
    ["t (s),y1 (m),y2 (m)", "t/s,Trial 1/m,Trial 2/m", "Time,Run 1,Run 2\ns,m,m"],
)
def test_columns_of_repeats_are_a_recording_each(tmp_path, heading):
    (tmp_path / "runs.csv").write_text(
        "\n".join([heading, *lines(",", False, T, Y, Y + 0.01)])
    )
    found = read_foreign(tmp_path / "runs.csv")
    assert found.repeats
    assert [t.y[0] for t in found.tracks] == pytest.approx(
        [1000 * Y[0], 1000 * Y[0] + 10]
    )
    with pytest.raises(MeasurementError, match="2 repeats in it: `benchtwin import`"):
        read_track(tmp_path / "runs.csv")


@pytest.mark.parametrize("columns", [(T, Y), (T, X, Y)])
def test_numbers_without_headings_are_told_by_their_fall(tmp_path, columns):
    (tmp_path / "run.txt").write_text("\n".join(lines(" ", False, *columns)))
    found = read_foreign(tmp_path / "run.txt")
    assert found.tracks[0].y == pytest.approx(1000 * Y, abs=1e-3)
    assert any("no headings" in g for g in found.guesses)
    still = (columns[0], *(0.0 * c + 1 for c in columns[1:]))
    (tmp_path / "other.txt").write_text("\n".join(lines(" ", False, *still)))
    assert tool_of(tmp_path / "other.txt") == ""


def test_a_workbook_with_lines_above_its_table(tmp_path):
    rows = [[float(t), float(100 * y)] for t, y in zip(T, Y)]
    sheet = [["Ball, let go by hand"], [], ["Zeit", "Höhe"], ["s", "cm"], *rows]
    (tmp_path / "fall.xls").write_bytes(workbook({"Messung": sheet}))
    found = read_foreign(tmp_path / "fall.xls")
    assert found.tracks[0].y == pytest.approx(1000 * Y, abs=1e-3)
    assert not found.repeats


def test_metres_can_be_said_by_the_scale(tmp_path):
    """1000 mm a pixel are no pixels: what table of a roll is in metres says so."""
    (tmp_path / "recording.toml").write_text(
        'rig = "roll"\n[camera]\nmm_per_px = 1000\n'
    )
    (tmp_path / "run.txt").write_text(
        "\n".join(["t\tx\ty", *lines("\t", False, T, 0.3 * (1 - np.exp(-T)), 0 * T)])
    )
    reasons = {q.reason for o in measure(tmp_path) for q in o.quantities}
    assert not any("no unit" in reason for reason in reasons)


@pytest.mark.parametrize("in_struct", [False, True])
def test_vectors_of_a_matlab_file(tmp_path, in_struct):
    held = {"t": T, "x": X, "y": Y, "note": "by hand", "limits": [0.0, 1.0]}
    savemat(tmp_path / "fall.mat", {"run": held} if in_struct else held)
    found = read_foreign(tmp_path / "fall.mat")
    assert found.tracks[0].y == pytest.approx(1000 * Y, abs=1e-6)
    whole = (tmp_path / "fall.mat").read_bytes()
    (tmp_path / "cut.mat").write_bytes(whole[: len(whole) // 2])
    with pytest.raises(MeasurementError, match=r"cut\.mat: the MATLAB file is damaged"):
        read_foreign(tmp_path / "cut.mat")


LIST = np.array([np.zeros(9), None], object)[:1]


def compressed(size):
    """An element of so many zeros."""
    data = zlib.compress(bytes(size))
    return struct.pack("<II", 15, len(data)) + data


@pytest.mark.parametrize(
    ("held", "added", "said"),
    [
        ({"run": {"t": np.zeros(3_000_000)}}, b"", "more than 2,000,000 cells"),
        ({"run": {"a": {"t": np.zeros(3_000_000)}}}, b"", "more than 2,000,000"),
        ({"t": np.zeros(9)}, compressed(80_000_000), "is damaged"),
        ({"run": LIST}, b"", "larger than memory"),
    ],
)
def test_a_matlab_file_that_unfolds_is_refused_before_it_does(
    tmp_path, held, added, said
):
    """The last says of its list, in which nothing stands, that it is long."""
    lies = held.get("run") is LIST
    savemat(tmp_path / "a.mat", held, do_compression=not lies)
    raw = (tmp_path / "a.mat").read_bytes()
    if lies:
        shape, stated = struct.pack("<II", 1, 1), struct.pack("<II", 1, 2_000_000_000)
        assert shape in raw
        raw = raw.replace(shape, stated, 1)
    (tmp_path / "a.mat").write_bytes(raw + added)
    tracemalloc.start()
    with pytest.raises(MeasurementError, match=rf"a\.mat: .*{said}"):
        read_foreign(tmp_path / "a.mat")
    assert tracemalloc.get_traced_memory()[1] < 200e6
    tracemalloc.stop()


def test_structs_in_structs_end_with_a_sentence(tmp_path):
    held = {"t": np.zeros(9)}
    for _ in range(40):
        held = {"a": held}
    savemat(tmp_path / "deep.mat", held)
    with pytest.raises(MeasurementError, match=r"deep\.mat: no tool is known"):
        read_foreign(tmp_path / "deep.mat")
