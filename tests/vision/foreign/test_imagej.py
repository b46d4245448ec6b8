"""Fiji's trackers: Manual Tracking, TrackMate (CSV and both kinds of XML), MTrackJ.
Pictures count y down, frames are no seconds."""

import numpy as np
import pytest
from bouncing import ball
from measure_all import measure

from benchtwin.vision.foreign import read_foreign, tool_of
from benchtwin.vision.foreign.as_evidence import read_track
from benchtwin.vision.measurement import MeasurementError

FRAME, X, Y = ball()
PX_PER_M, HIGH = 640.0, 480.0
COLUMN, ROW = 100 + PX_PER_M * X, HIGH - PX_PER_M * Y


def manual(parting: str, *, scale: float = 1.0, comma: bool = False) -> str:
    """Two tracks, slices from 1; the first row of each has no distance."""
    rows = []
    for track, moved in ((1, 0.0), (2, 1.0)):
        x, y = np.round(np.where(moved, 50, COLUMN)), np.round(np.where(moved, 60, ROW))
        gone = scale * np.hypot(np.diff(x, prepend=x[0]), np.diff(y, prepend=y[0]))
        for k in range(len(FRAME) - 5 * track):
            cells = [
                len(rows) + 1,
                track,
                k + 1,
                int(x[k]),
                int(y[k]),
                -1 if k == 0 else round(gone[k], 3),
                -1,
                230,
            ]
            rows.append(
                parting.join(
                    str(c).replace(".", ",") if comma else str(c) for c in cells
                )
            )
    return "\n".join(
        [
            parting.join(
                (
                    " ",
                    "Track n°",
                    "Slice n°",
                    "X",
                    "Y",
                    "Distance",
                    "Velocity",
                    "Pixel Value",
                )
            ),
            *rows,
        ]
    )


@pytest.mark.parametrize(
    ("name", "text", "code"),
    [
        ("Results.xls", manual("\t"), "utf8"),
        ("results.txt", manual("\t", comma=True, scale=0.5), "cp1252"),
        ("Results.csv", manual(","), "cp1252"),
    ],
)
def test_manual_tracking(tmp_path, name, text, code):
    (tmp_path / name).write_bytes(text.encode(code))
    assert tool_of(tmp_path / name) == "ImageJ Manual Tracking"
    found = read_foreign(tmp_path / name)
    assert (found.time_unit, found.length_unit) == ("frame", "px")
    assert [len(t.time) for t in found.tracks] == [len(FRAME) - 5, len(FRAME) - 10]
    assert np.ptp(found.tracks[0].y) == pytest.approx(np.ptp(np.round(ROW)))
    assert found.tracks[0].y[0] == -np.round(ROW[0])  # y up
    assert any("frames a second" in q.words for q in found.questions)
    assert any(
        "Distance says 0.5 units a pixel" in q.words for q in found.questions
    ) == (code == "cp1252" and name == "results.txt")


def test_manual_tracking_gives_the_restitution(tmp_path):
    (tmp_path / "Results.xls").write_text(manual("\t"), encoding="utf8")
    (observation,) = measure(tmp_path / "Results.xls")
    e = next(q for q in observation.quantities if q.name == "restitution")
    assert abs(e.value - 0.8) < max(3 * e.sd, 0.005)  # whole pixels of 1.6 mm
    assert any(
        "number 1 (track 1) is taken, the longest that falls" in note
        for note in observation.notes
    )


NAMES = (
    "LABEL,ID,TRACK_ID,QUALITY,POSITION_X,POSITION_Y,POSITION_Z,POSITION_T,FRAME,RADIUS"
)
HEADINGS = """{}
Label,Spot ID,Track ID,Quality,X,Y,Z,T,Frame,Radius
Label,Spot ID,Track ID,Quality,X,Y,Z,T,Frame,R
,,,(quality),({u}),({u}),({u}),({t}),,({u})
"""


def spots(unit: str, time: str, per_px: float, step: float) -> str:
    rows = [
        f"ID{k},{k},{track},7.5,{x * per_px:.9g},{y * per_px:.9g},0,"
        f"{f * step:.9g},{f},2.5"
        for track, xs, ys in ((0, COLUMN, ROW), (3, 0 * COLUMN + 7, 0 * ROW + 9))
        for k, (f, x, y) in enumerate(zip(FRAME, xs, ys))
    ]
    rng = np.random.default_rng(1)
    return HEADINGS.format(NAMES, u=unit, t=time) + "\n".join(
        rng.permutation(rows)
    )  # spots come in any order


@pytest.mark.parametrize(
    ("unit", "time", "per_px", "step", "units"),
    [
        ("pixel", "frame", 1.0, 1.0, ("frame", "px")),
        ("pixel", "sec", 1.0, 1.0, ("frame", "px")),
        ("mm", "sec", 1.5625, 1 / 120, ("s", "mm")),
        ("micron", "sec", 1562.5, 1 / 120, ("s", "mm")),
        ("cm", "msec", 0.15625, 1000 / 120, ("s", "mm")),
    ],
)
def test_trackmate_spots(tmp_path, unit, time, per_px, step, units):
    (tmp_path / "spots.csv").write_text(spots(unit, time, per_px, step))
    found = read_foreign(tmp_path / "spots.csv")
    assert (found.tool, found.time_unit, found.length_unit) == ("TrackMate", *units)
    expected = 1.5625 if units[1] == "mm" else 1.0
    assert found.tracks[0].y == pytest.approx(-ROW * expected, abs=1e-4)
    assert found.tracks[0].time == pytest.approx(
        FRAME / 120 if units[0] == "s" else FRAME, abs=1e-6
    )
    assert len(found.tracks) == 2 and not found.doubt
    rows = read_track(tmp_path / "spots.csv")
    assert (
        "2 tracks: number 1 (track 0) is taken, the longest that falls" in rows.notes[0]
    )


def model() -> str:
    """TrackMate's own XML: spots by frame, and edges that do not come in order."""
    spot = "".join(
        f'<SpotsInFrame frame="{f}"><Spot ID="{100 + f}" name="ID{100 + f}"'
        f' POSITION_X="{1.5625 * x}" POSITION_Y="{1.5625 * y}" POSITION_Z="0.0"'
        f' POSITION_T="{f / 120}" FRAME="{f}" RADIUS="2.5"'
        ' VISIBILITY="1"/></SpotsInFrame>'
        for f, x, y in zip(FRAME, COLUMN, ROW)
    )
    edges = "".join(
        f'<Edge SPOT_SOURCE_ID="{100 + f}" SPOT_TARGET_ID="{101 + f}" LINK_COST="1.0"/>'
        for f in FRAME[:-1][::-1]
    )
    return (
        '<?xml version="1.0" encoding="UTF-8"?>\n<TrackMate'
        ' version="7.11.1"><Log>…</Log><Model spatialunits="mm" timeunits="sec">'
        f'<FeatureDeclarations/><AllSpots nspots="{len(FRAME)}">{spot}</AllSpots>'
        f'<AllTracks><Track name="Track_0" TRACK_ID="0">{edges}</Track></AllTracks>'
        "<FilteredTracks/></Model></TrackMate>"
    )


def simple(time: str, interval: float) -> str:
    rows = "".join(
        f'<detection t="{f}" x="{x}" y="{y}" z="0.0" />\n'
        for f, x, y in zip(FRAME, COLUMN, ROW)
    )
    return (
        '<?xml version="1.0" encoding="UTF-8"?>\n<Tracks nTracks="1"'
        f' spaceUnits="pixel" frameInterval="{interval}" timeUnits="{time}"'
        ' generationDateTime="Tue" from="TrackMate v7.12.2"><particle'
        f' nSpots="{len(FRAME)}">{rows}</particle></Tracks>'
    )


@pytest.mark.parametrize(
    ("text", "units"),
    [
        (model(), ("s", "mm")),
        (simple("sec", 1 / 120), ("s", "px")),
        (simple("sec", 1.0), ("frame", "px")),
        (simple("frame", 1.0), ("frame", "px")),
    ],
)
def test_trackmate_xml(tmp_path, text, units):
    (tmp_path / "tracks.xml").write_text(text, encoding="utf8")
    found = read_foreign(tmp_path / "tracks.xml")
    assert (found.tool, found.time_unit, found.length_unit) == ("TrackMate", *units)
    assert found.tracks[0].time == pytest.approx(
        FRAME / 120 if units[0] == "s" else FRAME, abs=1e-9
    )
    assert found.tracks[0].y == pytest.approx(
        -ROW * (1.5625 if units[1] == "mm" else 1), abs=1e-9
    )


def mdf() -> str:
    points = "".join(
        f"Point {f + 1} {x:.1f} {y:.1f} 1.0 {f + 1:.1f} 1.0\n"
        for f, x, y in zip(FRAME, COLUMN, ROW)
    )
    return (
        "MTrackJ 1.5.1 Data File\nDisplaying true true true 1 2 0 3 100 4 0 0 0 2 1 12"
        " 0 true true true false\nAssembly 1 FF0000\nCluster 1 FF0000\nTrack 1 FF0000"
        f" true\nPoint 1 5.0 5.0 1.0 1.0 1.0\nTrack 2 FF0000 true\n{points}End of"
        " MTrackJ Data File\n"
    )


def test_mtrackj(tmp_path):
    (tmp_path / "drop.mdf").write_text(mdf())
    found = read_foreign(tmp_path / "drop.mdf")
    (trail,) = found.tracks  # one point is no track
    assert (found.tool, trail.name, found.time_unit, found.length_unit) == (
        "MTrackJ",
        "track 2",
        "frame",
        "px",
    )
    assert trail.y == pytest.approx(-ROW, abs=0.051) and trail.time == pytest.approx(
        FRAME + 1
    )


WRONG = {
    "Results.csv": (manual(",").replace(",X,", ",Z,"), "column x is missing"),
    "spots.csv": (
        spots("pixel", "frame", 1, 1).replace("FRAME", "TIME"),
        "column FRAME is missing",
    ),
    "furlong.csv": (spots("furlong", "sec", 1, 0.1), "unit of length is 'furlong'"),
    "lost.xml": (
        model().replace('<Spot ID="105"', '<Spot ID="905"'),
        "names a spot that is not there",
    ),
    "words.xml": (
        simple("sec", 1.0).replace('x="', 'x="q', 1),
        "x of a detection = 'q.*' is not a number",
    ),
    "empty.xml": (
        '<Tracks from="TrackMate v7" timeUnits="frame" spaceUnits="pixel"></Tracks>',
        "no track of 3 or more places",
    ),
    "short.mdf": (
        mdf().replace("Point 7 ", "Point 7\nPoint "),
        "line 14 is no Point with number, x, y, z, t and channel",
    ),
    "early.mdf": (
        "MTrackJ 1.5.1 Data File\nPoint 1 1 1 1 1 1\n",
        "line 2 is a Point before any Track",
    ),
}


@pytest.mark.parametrize("name", WRONG)
def test_what_is_wrong_is_one_sentence_with_the_file(tmp_path, name):
    (tmp_path / name).write_text(WRONG[name][0], encoding="utf8")
    with pytest.raises(MeasurementError, match=rf"{name}: .*{WRONG[name][1]}"):
        read_track(tmp_path / name)
