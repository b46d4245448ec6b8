"""Kinovea: trajectories as CSV ("Time", "name/0/X", "name/0/Y") or text ("#Kinovea
Trajectory data export"), and .kva files (XML).

Exports are in the unit of Kinovea's calibration, which they do not name, y up; a .kva
holds pixels, y down, and its calibration."""

import math
import re
from xml.etree.ElementTree import Element

import numpy as np

from benchtwin.vision.foreign.contents import Tracked
from benchtwin.vision.foreign.source import LENGTH, Source, column
from benchtwin.vision.measurement import MeasurementError, require

TOOL = "Kinovea"
_TEXT = "#Kinovea Trajectory data export"
# hours, minutes, seconds, hundredths or thousandths
_CLOCK = re.compile(r"(-?)(\d+):(\d\d):(\d\d):(\d+)")


def recognises(source: Source) -> bool:
    """Whether a file is of this kind, by its name and its first lines."""
    if source.is_xml:
        return b"<KinoveaVideoAnalysis" in source.head
    if source.is_zip or source.is_workbook or not source.first_lines:
        return False
    if source.first_lines[0].startswith(_TEXT):
        return True
    heading = source.first_rows[0]
    return (
        len(heading) > 2
        and heading[0] == "Time"
        and all(re.fullmatch(r".*/[XY]", str(h)) for h in heading[1:] if h)
    )


def read(source: Source) -> Tracked:
    """The file's tracks, with the units that it names."""
    if source.is_xml:
        return _analysis(source)
    return _text(source) if source.first_lines[0].startswith(_TEXT) else _table(source)


def _table(source: Source) -> Tracked:
    headings = [str(h) for h in source.rows[0]]
    rows = source.rows[1:]
    path = source.path
    time, listed = column(path, rows, 0, "Time", 2), []
    for k, heading in enumerate(headings):
        if not heading.endswith("/X"):
            continue
        name = heading[:-2]
        require(
            f"{name}/Y" in headings,
            f"{path}: column {name}/Y is missing beside {heading}",
        )
        x = column(path, rows, k, heading, 2)
        y = column(path, rows, headings.index(f"{name}/Y"), f"{name}/Y", 2)
        listed.append((name.removesuffix("/0"), np.column_stack([time, x, y])))
    return Tracked(listed, up="up")


def _text(source: Source) -> Tracked:
    """Blocks of lines T X Y parted by empty lines; times as h:mm:ss:hundredths or as
    numbers."""
    blocks: list[tuple[str, list[list[float]]]] = [("", [])]
    clocked = False
    for k, line in enumerate(source.text.splitlines(), 1):
        cells = line.split()
        if not cells or line.startswith("#"):
            if blocks[-1][1]:
                blocks.append(("", []))
            if cells and line.startswith("# "):
                blocks[-1] = (line[2:52].strip(), [])
            continue
        if clock := _CLOCK.fullmatch(cells[0]):
            clocked, cells[0] = True, _seconds(clock)
        wrong = f"line {k} is not a time, an x and a y ({line[:40]!r})"
        blocks[-1][1].append(source.numbers(cells, 3, wrong))
    return Tracked(blocks, "s" if clocked else "", up="up")


def _seconds(clock: re.Match) -> str:
    hours, minutes, seconds = (int(clock[k]) for k in (2, 3, 4))
    whole = 3600 * hours + 60 * minutes + seconds
    return f"{clock[1]}{whole}.{clock[5]}"


def _analysis(source: Source) -> Tracked:
    root, path, guesses = source.xml, source.path, []
    step, fps = (
        source.number(root.findtext(n), n)
        for n in ("AverageTimeStampsPerFrame", "CaptureFramerate")
    )
    if not step or step <= 0:
        raise MeasurementError(
            f"{path}: AverageTimeStampsPerFrame is missing; without it its times cannot"
            " be told"
        )
    listed, rate = [], fps if fps and 0 < fps < 5e6 else None
    for track in root.iter("Track"):
        points = (
            _parted(source, p.text, "a TrackPoint", "x;y;time")
            for p in track.iter("TrackPoint")
        )
        rows = [(np.round(stamp / step) / (rate or 1), x, y) for x, y, stamp in points]
        listed.append(((track.get("name") or "")[:50], rows))
    keys: dict[str, dict[str, float]] = {"camera": {}}
    if rate:
        guesses.append(
            f"{rate:.6g} frames per second, as Kinovea's capture rate; a slowed film"
            " says another rate than its camera had"
        )
        keys["camera"]["fps"] = rate
    if scale := _scale(source, root):
        keys["camera"]["mm_per_px"] = scale
    return Tracked(listed, "s" if rate else "frame", "px", "down", keys, guesses)


def _scale(source: Source, root: Element) -> float | None:
    """Millimetres of a pixel by a calibration line; None where there is none, or a
    plane in perspective."""
    line = root.find(".//CalibrationLine")
    if line is not None:
        unit = root.findtext(".//Calibration/Unit") or root.findtext(".//Unit") or ""
        end = "an end of its calibration line"
        a, b = (
            _parted(source, line.findtext(f"Segment/{one}"), end, "x;y")
            for one in ("A", "B")
        )
        length = source.number(line.findtext("Length"), "Length")
        pixels = math.dist(a, b)
        mm = LENGTH.get(unit.strip().lower())
        if length and mm and pixels > 0:
            return float(f"{length * mm / pixels:.8g}")
        return None
    mm = LENGTH.get((root.findtext(".//LengthUnit") or "").strip().lower())
    scale = source.number(root.findtext(".//PixelToUnit"), "PixelToUnit")
    return float(f"{scale * mm:.8g}") if scale and mm else None


def _parted(source: Source, text: str | None, what: str, form: str) -> list[float]:
    """The first numbers of a text of a form such as "x;y;time"."""
    wrong = f"{what} is {(text or '')[:30]!r}; it should be {form}"
    return source.numbers((text or "").split(";"), 1 + form.count(";"), wrong)
