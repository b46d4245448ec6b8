"""Tracker's .trk and .trz: places as Tracker shows them, its clock, its calibration;
and files without one."""

import zipfile

import numpy as np
import pytest
from bouncing import ball
from measure_all import measure

from benchtwin.vision.foreign import read_foreign, tool_of
from benchtwin.vision.foreign.as_evidence import read_track
from benchtwin.vision.measurement import MeasurementError

ORIGIN, PX_PER_M, ANGLE_DEG, FIRST = (320.0, 430.0), 640.0, 3.0, 4
TAPE = """<property name="item" type="object">\
<object class="org.opensourcephysics.cabrillo.tracker.TapeMeasure">
<property name="name" type="string">tape</property></object></property>"""


def prop(name: str, value: object, kind: str = "double") -> str:
    return f'<property name="{name}" type="{kind}">{value}</property>'


def point_mass(
    name: str, frames: np.ndarray, x_px: np.ndarray, y_px: np.ndarray
) -> str:
    kind = "org.opensourcephysics.cabrillo.tracker.PointMass"
    rows = "".join(
        f'<property name="[{n}]" type="object"><object'
        f' class="{kind}$FrameData">{prop("x", x)}{prop("y", y)}</object></property>'
        for n, x, y in zip(frames, x_px, y_px)
    )
    return (
        '<property name="item" type="object"><object'
        f' class="{kind}">{prop("mass", 1.0)}{prop("name", name, "string")}<property'
        ' name="framedata" type="array"'
        f' class="[L{kind}$FrameData;">{rows}</property></object></property>'
    )


def trk(
    items: str,
    *,
    scale: float = PX_PER_M,
    unit: str = "m",
    fps: float = 120.0,
    angle: float = ANGLE_DEG,
) -> str:
    system = (
        prop("xorigin", ORIGIN[0])
        + prop("yorigin", ORIGIN[1])
        + prop("angle", angle)
        + prop("xscale", scale)
        + prop("yscale", scale)
    )
    media = "org.opensourcephysics.media.core"
    axes = f"{media}.ImageCoordSystem"
    return f"""<?xml version="1.0" encoding="UTF-8"?>
<object class="org.opensourcephysics.cabrillo.tracker.TrackerPanel">
{prop("semantic_version", "5.1.5", "string")}
<property name="videoclip" type="object"><object class="{media}.VideoClip">
{prop("startframe", FIRST, "int")}{prop("stepsize", 1, "int")}\
{prop("starttime", 0.0)}</object></property>
<property name="clipcontrol" type="object"><object class="{media}.StepperClipControl">
{prop("delta_t", 1000 / fps)}</object></property>
<property name="coords" type="object"><object class="{axes}">
<property name="framedata" type="array" class="[L{axes}$FrameData;">
<property name="[0]" type="object">\
<object class="{axes}$FrameData">{system}</object></property>
</property></object></property>
{prop("length_unit", unit, "string") if unit else ""}
<property name="tracks" type="collection" class="java.util.ArrayList">{items}</property>
</object>
"""


def in_picture(
    x_m: np.ndarray, y_m: np.ndarray, angle: float = ANGLE_DEG
) -> tuple[np.ndarray, np.ndarray]:
    """Pixels (y down) of places in axes turned anticlockwise by `angle`."""
    a = np.radians(angle)
    right, up = x_m * np.cos(a) - y_m * np.sin(a), x_m * np.sin(a) + y_m * np.cos(a)
    return ORIGIN[0] + PX_PER_M * right, ORIGIN[1] - PX_PER_M * up


def drop_item(name: str = "mass A", **kind) -> str:
    frame, x, y = ball()
    return point_mass(name, frame + FIRST, *in_picture(x, y, **kind))


@pytest.mark.parametrize("packed", [False, True])
def test_places_and_times_are_what_tracker_shows(tmp_path, packed):
    file = tmp_path / ("drop.trz" if packed else "drop.trk")
    if packed:
        with zipfile.ZipFile(file, "w") as z:
            z.writestr("videos/drop.mp4", b"\0" * 100)
            z.writestr("drop.trk", trk(TAPE + drop_item()))
    else:
        file.write_text(trk(TAPE + drop_item()))
    frame, x, y = ball()
    rows = read_track(file).rows
    assert rows["t_s"].to_numpy() == pytest.approx(frame / 120, abs=1e-9)
    assert rows["x_mm"].to_numpy() == pytest.approx(1000 * x, abs=1e-6)
    assert rows["y_mm"].to_numpy() == pytest.approx(1000 * y, abs=1e-6)
    camera = read_foreign(file).keys["camera"]
    assert camera["fps"] == pytest.approx(120) and camera["mm_per_px"] == pytest.approx(
        1000 / PX_PER_M
    )


def test_a_trk_is_measured_as_it_is(tmp_path):
    (tmp_path / "drop.trk").write_text(trk(TAPE + drop_item()))
    (observation,) = measure(tmp_path / "drop.trk")
    found = {q.name: q for q in observation.quantities}
    assert observation.rig == "drop"
    assert (
        abs(found["restitution"].value - 0.8) < 0.003
    )  # 120 frames a second, no noise: the sds are of the scale


def test_without_calibration_lengths_are_pixels_and_it_is_asked(tmp_path):
    (tmp_path / "drop.trk").write_text(trk(drop_item(angle=0.0), scale=1.0, angle=0.0))
    found = read_foreign(tmp_path / "drop.trk")
    assert found.length_unit == "px" and any(
        "no calibration" in q.words and "mm_per_px" in q.keys for q in found.questions
    )
    (observation,) = measure(tmp_path / "drop.trk")
    assert {q.name: q.value for q in observation.quantities}[
        "restitution"
    ] == pytest.approx(0.8, abs=0.003)


def test_of_several_the_longest_that_falls_is_taken_and_said(tmp_path):
    still = point_mass("mark", np.arange(200), np.full(200, 10.0), np.full(200, 20.0))
    (tmp_path / "drop.trk").write_text(trk(TAPE + still + drop_item("ball")))
    table = read_track(tmp_path / "drop.trk")
    assert len(table.rows) == len(ball()[0])
    assert (
        "2 tracks: number 2 (ball) is taken, the longest that falls" in table.notes[0]
    )


def test_letters_of_windows_in_what_says_it_is_utf8_are_no_fault(tmp_path):
    text = trk(TAPE + drop_item()).replace(
        "<property",
        '<property name="author" type="string">García</property>\n<property',
        1,
    )
    (tmp_path / "drop.trk").write_bytes(text.encode("cp1252"))
    assert len(read_track(tmp_path / "drop.trk").rows) == len(ball()[0])


WRONG = {
    "several tabs": (
        trk(drop_item()).replace("TrackerPanel", "TrackerTabs"),
        "several tabs or none; save one tab as .trk",
    ),
    "a model": (trk(TAPE), "no point mass that was tracked"),
    "two places": (
        trk(point_mass("A", np.arange(2), np.ones(2), np.ones(2))),
        "no track of 3 or more places",
    ),
    "no clock": (trk(drop_item()).replace("delta_t", "delta"), "delta_t = None"),
    "words": (
        trk(drop_item()).replace(
            'name="x" type="double">', 'name="x" type="double">q', 1
        ),
        "x = 'q.*' is not a number",
    ),
    "cut short": (trk(drop_item())[:5000], "not valid XML"),
    "entities": (
        '<!DOCTYPE a [<!ENTITY b "ha"><!ENTITY c "&b;&b;">]>'
        + trk("&c;").partition("?>")[2],
        "not valid XML",
    ),
    "a scale of nil": (trk(drop_item(), scale=0.0), "lacks origin or scale"),
}


@pytest.mark.parametrize("name", WRONG)
def test_what_is_wrong_is_one_sentence_with_the_file(tmp_path, name):
    content, said = WRONG[name]
    (tmp_path / "drop.trk").write_text(content)
    assert tool_of(tmp_path / "drop.trk")
    with pytest.raises(MeasurementError, match=rf"drop\.trk: .*{said}"):
        read_track(tmp_path / "drop.trk")
    (failed,) = {q.reason for o in measure(tmp_path) for q in o.quantities}
    assert "drop.trk" in failed


def test_a_zip_that_is_none_is_named(tmp_path):
    (tmp_path / "drop.trz").write_bytes(b"PK\x03\x04 and no more")
    with pytest.raises(MeasurementError, match=r"drop\.trz: the zip file is damaged"):
        read_track(tmp_path / "drop.trz")
