"""phyphox: impact times of the acoustic stopwatch and angles of a tilting phone, in its
workbooks, zips and CSV, in any language."""

import io
import zipfile

import numpy as np
import pytest
from bouncing import HEIGHT_M, IMPACTS_S
from measure_all import measure
from workbooks import bomb, workbook

from benchtwin.vision.foreign import read_foreign, tool_of
from benchtwin.vision.foreign.as_evidence import read_impacts
from benchtwin.vision.measurement import MeasurementError

START_S = 1.2345
HEARD = START_S + IMPACTS_S
GAPS = np.append(np.diff(HEARD), 0.0)
SHEETS = {
    "Simple": [
        ["Start (s)", "Stop (s)", "Difference (s)"],
        [HEARD[0], HEARD[1], GAPS[0]],
    ],
    "Multiple": [["Start (s)", *(f"Stop {k} (s)" for k in range(1, 5))], [*HEARD]],
    "All": [["Event time (s)", "Interval (s)"], *zip(HEARD, GAPS)],
    "Metadata Device": [
        ["property", "value"],
        ["version", "1.1.8"],
        ["deviceModel", "phone"],
    ],
    "Metadata Time": [
        ["event", "experiment time", "system time"],
        ["START", 0.0, 1617465215.998],
    ],
}
GERMAN = {
    "Event time": "Ereigniszeit",
    "Interval": "Intervall",
    "Difference": "Differenz",
}


def table(rows: list[list], parting: str = ",", decimal: str = ".") -> str:
    said = [
        parting.join(
            f'"{c}"' if isinstance(c, str) else f"{c:.9E}".replace(".", decimal)
            for c in row
        )
        for row in rows
    ]
    return "\n".join(said) + "\n"


def packed(parting: str, decimal: str, names: dict[str, str]) -> bytes:
    with zipfile.ZipFile(out := io.BytesIO(), "w", zipfile.ZIP_DEFLATED) as z:
        for name in ("Simple", "Multiple", "All"):
            text = table(SHEETS[name], parting, decimal)
            for word, other in names.items():
                text = text.replace(word, other)
            z.writestr(f"{name}.csv", text)
        z.writestr("meta/device.csv", table(SHEETS["Metadata Device"]))
        z.writestr("meta/time.csv", table(SHEETS["Metadata Time"]))
    return out.getvalue()


FILES = {
    "clap.xlsx": workbook(SHEETS),
    "clap.zip": packed(",", ".", {}),
    "klatsch.zip": packed(";", ",", GERMAN),
    "tab.zip": packed("\t", ",", GERMAN),
    "All.csv": table(SHEETS["All"]).encode(),
    "alle.csv": table(SHEETS["All"], ";", ",").encode(),
    "Multiple.csv": table(SHEETS["Multiple"]).encode(),
}


@pytest.mark.parametrize("name", FILES)
def test_every_form_of_the_stopwatch_gives_the_impact_times(tmp_path, name):
    (tmp_path / name).write_bytes(FILES[name])
    assert tool_of(tmp_path / name) == "phyphox"
    assert read_impacts(tmp_path / name).rows["t_s"].to_numpy() == pytest.approx(
        HEARD, abs=1e-8
    )


def test_the_stopwatch_gives_the_restitution(tmp_path):
    told = f"[drop]\nheight_mm = {1000 * HEIGHT_M}\n[air]\ndensity_kg_m3 = 0\n"
    (tmp_path / "bench.toml").write_text(told)
    (tmp_path / "clap.xlsx").write_bytes(FILES["clap.xlsx"])
    (observation,) = measure(tmp_path)
    assert {q.name: q.value for q in observation.quantities}[
        "restitution_normal"
    ] == pytest.approx(0.8, abs=1e-3)  # ± .01 by the height


def test_several_runs_in_one_table_are_told_apart(tmp_path):
    pair = ["Event time (s)", "Interval (s)"]
    rows = [[*pair, "", *pair], *([t, g, "", t + 1, g] for t, g in zip(HEARD, GAPS))]
    (tmp_path / "two.xlsx").write_bytes(
        workbook({"All": rows, "Metadata Time": SHEETS["Metadata Time"]})
    )
    (_, first), (_, second) = read_foreign(tmp_path / "two.xlsx").runs
    assert second == pytest.approx(first + 1)
    with pytest.raises(
        MeasurementError,
        match=r"two\.xlsx: 2 runs of impact times in it: `benchtwin import`",
    ):
        read_impacts(tmp_path / "two.xlsx")


RATE_DEG_S, STOPPED_DEG = 1.9, 24.0


def tilting() -> tuple[np.ndarray, np.ndarray]:
    """Times [s] and what a phone feels [m/s²] (n, 3): level for 2 s, raised steadily
    about an axis across it, then held."""
    t = np.arange(0, 18, 0.01)
    angle = np.radians(np.clip(RATE_DEG_S * (t - 2), 0, STOPPED_DEG))
    felt = 9.81 * np.column_stack(
        [np.sin(angle) * 0.6, np.sin(angle) * 0.8, np.cos(angle)]
    )
    return t, felt + np.random.default_rng(3).normal(0, 0.02, felt.shape)


@pytest.mark.parametrize(
    ("heading", "times", "per_g"),
    [
        (
            (
                "Time (s),Acceleration x (m/s^2),Acceleration y (m/s^2),Acceleration z"
                " (m/s^2),Absolute acceleration (m/s^2)"
            ),
            1.0,
            1.0,
        ),
        (
            (
                "Zeit (s),Beschleunigung x (m/s^2),Beschleunigung y"
                " (m/s^2),Beschleunigung z (m/s^2),Absolutbeschleunigung (m/s^2)"
            ),
            1.0,
            1.0,
        ),
        (
            (
                "accelerometerTimestamp_sinceReboot(s),"
                "accelerometerAccelerationX(G),accelerometerAccelerationY(G),accelerometerAccelerationZ(G),n"
            ),
            1.0,
            9.81,
        ),
        (
            (
                "locationTimestamp_since1970(s),accelerometerAccelerationX(G),accelerometerAccelerationY(G),accelerometerAccelerationZ(G),"
                "accelerometerTimestamp_sinceReboot(s)"
            ),
            0.0,
            9.81,
        ),
        ("timestamp (ms),ax (g),ay (g),az (g),n", 1000.0, 9.81),
        ("seconds_elapsed,x,y,z,n", 1.0, 1.0),
        ("time (s),gFx,gFy,gFz,TgF", 1.0, 9.81),
    ],
)
def test_a_phone_on_a_plate_gives_its_angle(tmp_path, heading, times, per_g):
    t, felt = tilting()
    rows = [
        ",".join(f"{v:.7g}" for v in (times * (5 + s), *(f / per_g), 5 + s))
        for s, f in zip(t, felt)
    ]
    (tmp_path / "plate.csv").write_text("\n".join([heading, *rows]))
    found = read_foreign(tmp_path / "plate.csv")
    assert found.tilt["t_s"].to_numpy() == pytest.approx(t, abs=0.002)
    assert found.tilt["tilt_deg"].iloc[-100:].mean() == pytest.approx(
        STOPPED_DEG, abs=0.05
    )
    assert found.keys["slide"]["tilt_rate_deg_s"] == pytest.approx(RATE_DEG_S, rel=0.02)
    assert any(
        "24" in q.words and "slide_angle_deg" in q.words for q in found.questions
    )
    (reason,) = {
        q.reason for o in measure(tmp_path / "plate.csv") for q in o.quantities
    }
    assert "plate.csv: the angle of a plate" in reason and "no motion" in reason


def without_gravity() -> bytes:
    t, felt = tilting()
    return table(
        [
            ["Time (s)", *(f"Linear Acceleration {a} (m/s^2)" for a in "xyz")],
            *([s, *(f - f)] for s, f in zip(t, felt)),
        ]
    ).encode()


def spread_wide() -> bytes:
    """A cell in the last column of the last row: as a dense table, 550 GB."""
    far = '<row r="1048576"><c r="XFD1048576"><v>1</v></c></row></sheetData>'
    with (
        zipfile.ZipFile(io.BytesIO(FILES["clap.xlsx"])) as z,
        zipfile.ZipFile(out := io.BytesIO(), "w") as spread,
    ):
        for name in z.namelist():
            text = z.read(name).decode()
            text = (
                text.replace("<row>", '<row r="1">', 1).replace("</sheetData>", far)
                if name.endswith("sheet1.xml")
                else text
            )
            spread.writestr(name, text)
    return out.getvalue()


WRONG = {
    "bomb.xlsx": (bomb(600), r"it unpacks to 63\d MB; .* has 500 MB at most"),
    "wide.xlsx": (spread_wide(), "spread too wide|more than 2,000,000 cells"),
    "cut.xls": (
        b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1" + b"\0" * 600,
        "the workbook is damaged",
    ),
    "linear.csv": (
        without_gravity(),
        "gravity is not in it; record the acceleration with g",
    ),
    "spectrum.xlsx": (
        workbook(
            {
                "FFT": [["Frequency (Hz)", "Amplitude (a.u.)"], [1.0, 2.0]],
                "Metadata Time": [["event"]],
            }
        ),
        "holds FFT: Frequency",
    ),
    "cut.xlsx": (FILES["clap.xlsx"][:900], "the zip file is damaged"),
    "back.csv": (
        table([SHEETS["All"][0], [1.0, -0.5], [0.5, 0.2]]).encode(),
        "do not increase",
    ),
}


@pytest.mark.parametrize("name", WRONG)
def test_what_is_wrong_is_one_sentence_with_the_file(tmp_path, name):
    (tmp_path / name).write_bytes(WRONG[name][0])
    with pytest.raises(MeasurementError, match=rf"{name}: .*({WRONG[name][1]})"):
        (
            read_foreign(tmp_path / name)
            if name != "back.csv"
            else read_impacts(tmp_path / name)
        )


def test_a_time_without_a_unit_is_asked_for(tmp_path):
    (tmp_path / "plate.csv").write_text(
        "timestamp,ax,ay,az\n" + "".join(f"{k},0,0,1\n" for k in range(30))
    )
    with pytest.raises(
        MeasurementError, match=r"plate\.csv: no column of time says its unit"
    ):
        read_foreign(tmp_path / "plate.csv")


def test_a_workbook_under_another_suffix_is_told_by_its_content(tmp_path):
    (tmp_path / "clap.xls").write_bytes(FILES["clap.xlsx"])
    (_, times), *_ = read_foreign(tmp_path / "clap.xls").runs
    assert times == pytest.approx(HEARD)
