"""Kinovea's exports (CSV, text) and its .kva."""

import numpy as np
import pytest
from bouncing import ball

from benchtwin.vision.foreign import read_foreign, tool_of
from benchtwin.vision.foreign.as_evidence import read_track
from benchtwin.vision.measurement import MeasurementError

FRAME, X, Y = ball()
MS, PX_PER_M = 1000 * FRAME / 120, 640.0


def exported(
    times: np.ndarray, lengths: float, parting: str = ",", decimal: str = "."
) -> str:
    """One clock; each cell in quotes; empty where the second trajectory has no
    point."""
    heading = ["Time", "ball/0/X", "ball/0/Y", "mark/0/X", "mark/0/Y"]
    rows = [
        [
            f"{t:.6g}",
            f"{lengths * x:.7g}",
            f"{lengths * y:.7g}",
            *(("1.5", "2.5") if k > 2 else ("", "")),
        ]
        for k, (t, x, y) in enumerate(zip(times, X, Y))
    ]
    quoted = [
        parting.join(f'"{c.replace(".", decimal)}"' if c else "" for c in row)
        for row in [heading, *rows]
    ]
    return "\n".join(quoted)


@pytest.mark.parametrize(
    ("text", "unit"),
    [
        (exported(MS, 1.0), "m"),
        (exported(MS, 100.0, ";", ","), "cm"),
        (exported(MS / 1000, 1000.0), "mm"),
    ],
)
def test_csv(tmp_path, text, unit):
    (tmp_path / "run.csv").write_text(text, encoding="utf8")
    found = read_foreign(tmp_path / "run.csv")
    assert (found.tool, [t.name for t in found.tracks]) == ("Kinovea", ["ball", "mark"])
    assert any(f"lengths in {unit}, which" in g for g in found.guesses) and any(
        g.startswith("times in") for g in found.guesses
    )
    rows = read_track(tmp_path / "run.csv").rows
    assert rows["t_s"].to_numpy() == pytest.approx(FRAME / 120, abs=1e-5)
    assert rows["y_mm"].to_numpy() == pytest.approx(1000 * Y, abs=1e-3)


def clock(frame: int) -> str:
    """h:mm:ss:thousandths."""
    ms = round(1000 * frame / 120)
    return f"0:00:{ms // 1000:02d}:{ms % 1000:03d}"


@pytest.mark.parametrize("decimal", [".", ","])
def test_text(tmp_path, decimal):
    rows = "".join(
        f"{clock(f)} {1000 * x:.2f} {1000 * y:.2f} \n".replace(".", decimal)
        for f, x, y in zip(FRAME, X, Y)
    )
    (tmp_path / "run.txt").write_text(
        "#Kinovea Trajectory data export\n#T X Y\n"
        + rows
        + "\n"
        + rows[:200].rpartition("\n")[0]
    )
    found = read_foreign(tmp_path / "run.txt")
    assert found.tool == "Kinovea" and len(found.tracks[0].time) == len(FRAME) > len(
        found.tracks[1].time
    )
    assert found.tracks[0].time == pytest.approx(
        FRAME / 120, abs=6e-4
    )  # whole milliseconds
    assert found.tracks[0].y == pytest.approx(1000 * Y, abs=6e-3)


def kva(calibrated: bool, fps: float | None = 120.0) -> str:
    places = zip(FRAME, PX_PER_M * X, 480 - PX_PER_M * Y)
    points = "".join(
        f"<TrackPoint>{x:.3f};{y:.3f};{9000 + 1502 * f}</TrackPoint>"
        for f, x, y in places
    )
    line = """<Calibration><CalibrationLine><Length>50</Length>\
<Segment><A>10;20</A><B>330;20</B></Segment></CalibrationLine>
<Unit Abbreviation="cm">Centimeters</Unit></Calibration>"""
    rate = f"<CaptureFramerate>{fps}</CaptureFramerate>" if fps else ""
    return f"""\ufeff<?xml version="1.0" encoding="utf-8"?>
<KinoveaVideoAnalysis><FormatVersion>2.1</FormatVersion>\
<AverageTimeStampsPerFrame>1502</AverageTimeStampsPerFrame>{rate}
{line if calibrated else ""}
<Tracks><Track id="a" name="ball">\
<TrackPointList Count="{len(FRAME)}">{points}</TrackPointList></Track></Tracks>
</KinoveaVideoAnalysis>"""


def test_kva(tmp_path):
    (tmp_path / "run.kva").write_text(kva(True), encoding="utf8")
    found = read_foreign(tmp_path / "run.kva")
    assert (found.tool, found.time_unit, found.length_unit) == ("Kinovea", "s", "px")
    assert found.keys["camera"] == {"fps": 120.0, "mm_per_px": pytest.approx(500 / 320)}
    assert np.diff(found.tracks[0].time) == pytest.approx(1 / 120)
    assert np.diff(found.tracks[0].y) == pytest.approx(PX_PER_M * np.diff(Y), abs=2e-3)


def test_a_kva_without_calibration_or_rate_asks_for_them(tmp_path):
    (tmp_path / "run.kva").write_text(kva(False, None), encoding="utf8")
    found = read_foreign(tmp_path / "run.kva")
    assert (found.time_unit, found.keys["camera"]) == ("frame", {})
    assert any("mm_per_px" in q.keys for q in found.questions) and any(
        "fps" in q.keys for q in found.questions
    )


WRONG = {
    "no.csv": (
        exported(MS, 1.0).replace("ball/0/Y", "ball/1/Y"),
        "column ball/0/Y is missing",
    ),
    "word.csv": (exported(MS, 1.0).replace('"0.1"', '"q"'), "ball/0/X = 'q' in line 2"),
    "line.txt": (
        "#Kinovea Trajectory data export\n#T X Y\n0:00:00:00 1.0\n",
        "line 3 is not a time, an x and a y",
    ),
    "word.txt": (
        "#Kinovea Trajectory data export\n#T X Y\n0:00:00:00 one 2\n",
        "line 3 is not a time, an x and a y",
    ),
    "point.kva": (
        kva(True).replace("<TrackPoint>", "<TrackPoint>q", 1),
        "a TrackPoint is 'q.*it should be x;y;time",
    ),
    "clock.kva": (
        kva(True).replace("AverageTimeStampsPerFrame", "Other"),
        "AverageTimeStampsPerFrame is missing",
    ),
}


@pytest.mark.parametrize("name", WRONG)
def test_what_is_wrong_is_one_sentence_with_the_file(tmp_path, name):
    (tmp_path / name).write_text(WRONG[name][0], encoding="utf8")
    assert tool_of(tmp_path / name) == "Kinovea"
    with pytest.raises(MeasurementError, match=rf"{name}: .*{WRONG[name][1]}"):
        read_track(tmp_path / name)
