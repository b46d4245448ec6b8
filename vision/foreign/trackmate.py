"""TrackMate (Fiji): "Spots in tracks" as CSV with four rows of headings, its own XML,
and the simple XML of "Export tracks to XML file".

Places are in the picture's calibrated unit, y down.
"""

from dataclasses import replace
from xml.etree.ElementTree import Element

import numpy as np

from benchtwin.vision.foreign.contents import Tracked, numbered
from benchtwin.vision.foreign.source import (
    FRAMES,
    Source,
    column,
    heading_and_unit,
    need,
)
from benchtwin.vision.measurement import MeasurementError

TOOL = "TrackMate"
_SECONDS = ("s", "sec", "second", "seconds")
_COLUMNS = ("TRACK_ID", "POSITION_X", "POSITION_Y", "POSITION_T", "FRAME")


def recognises(source: Source) -> bool:
    """Whether a file is of this kind, by its name and its first lines."""
    if source.is_zip:
        return False
    if source.is_xml:
        return b"<TrackMate" in source.head or (
            b"<Tracks" in source.head and b"TrackMate" in source.head
        )
    return all(
        name in source.first_rows[0]
        for name in ("TRACK_ID", "POSITION_X", "POSITION_Y")
    )


def read(source: Source) -> Tracked:
    """The file's tracks, with the units that it names."""
    if not source.is_xml:
        found = _table(source)
    else:
        found = _simple(source) if source.xml.tag == "Tracks" else _model(source)
    times = np.array([row[0] for _, rows in found.listed for row in rows])
    whole = (times == np.round(times))[np.isfinite(times)].all()
    if not whole or found.time_unit.lower() not in (*_SECONDS, ""):
        return found
    guess = (
        "times are frame numbers: whole seconds from frame to frame are what ImageJ"
        " writes where no interval is set"
    )
    return replace(found, time_unit="frame", guesses=[guess])


def _table(source: Source) -> Tracked:
    path, headings = source.path, [str(h) for h in source.rows[0]]
    lines = enumerate(source.rows)
    numbers = (k for k, row in lines if k and any(isinstance(c, float) for c in row))
    first = next(numbers, len(source.rows))
    rows, at = source.rows[first:], need(path, headings, _COLUMNS)
    units = {name: "" for name in _COLUMNS}
    for row in source.rows[1:first]:  # the third of them names the units, in brackets
        units |= {
            n: u
            for n, k in zip(_COLUMNS, at)
            if k < len(row) and (u := heading_and_unit(row[k])[1])
        }
    number, x, y, time, frame = (
        column(path, rows, k, n, first + 1) for n, k in zip(_COLUMNS, at)
    )
    # without a frame interval POSITION_T is empty
    when = frame if np.isnan(time).all() else time
    listed = numbered(number, when, x, y)
    return Tracked(listed, units["POSITION_T"], units["POSITION_X"], "down")


def _model(source: Source) -> Tracked:
    """The XML that TrackMate saves: spots, and edges that join them into tracks."""
    model = source.xml.find("Model")
    if model is None:
        raise MeasurementError(f"{source.path}: no Model in it, so no tracks")
    spots = {s.get("ID", ""): s for s in model.iterfind("AllSpots/SpotsInFrame/Spot")}
    listed = []
    for track in model.iterfind("AllTracks/Track"):
        ends = ("SPOT_SOURCE_ID", "SPOT_TARGET_ID")
        joined = {e.get(end, "") for e in track.iterfind("Edge") for end in ends}
        if missing := joined - set(spots):
            name = track.get("name", "a track")[:50]
            raise MeasurementError(
                f"{source.path}: {name} names a spot that is not there (ID"
                f" {sorted(missing)[0][:20]})"
            )
        places = ("POSITION_T", "POSITION_X", "POSITION_Y")
        rows = [[_number(source, spots[i], key) for key in places] for i in joined]
        listed.append((track.get("name", "")[:50], rows))
    time_unit, length_unit = model.get("timeunits", ""), model.get("spatialunits", "")
    return Tracked(listed, time_unit, length_unit, "down")


def _simple(source: Source) -> Tracked:
    """<Tracks spaceUnits frameInterval timeUnits> of <particle> of <detection t x y z>,
    t in frames."""
    root, listed = source.xml, []
    unit, interval = root.get("timeUnits", ""), 1.0
    if unit.lower() not in FRAMES and root.get("frameInterval"):
        interval = max(_number(source, root, "frameInterval"), 0.0) or 1.0
    for k, particle in enumerate(root.iterfind("particle"), 1):
        seen = particle.findall("detection")
        rows = [[_number(source, d, key) for key in ("t", "x", "y")] for d in seen]
        listed.append((f"track {k}", [(interval * t, x, y) for t, x, y in rows]))
    return Tracked(listed, unit, root.get("spaceUnits", ""), "down")


def _number(source: Source, element: Element, key: str) -> float:
    value = source.number(element.get(key, ""), f"{key} of a {element.tag}")
    if value is None:
        raise MeasurementError(f"{source.path}: {key} of a {element.tag} is missing")
    return value
