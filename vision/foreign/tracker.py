"""Tracker's own files: .trk (XML) and .trz (a zip with one .trk in it and its video).

Places are stored in pixels of the picture (y down); the coordinate system (origin,
angle, pixels per unit) converts them."""

import re
from collections.abc import Iterator
from dataclasses import dataclass, replace
from xml.etree.ElementTree import Element

import numpy as np

from benchtwin.vision.foreign.contents import Asked, Tracked
from benchtwin.vision.foreign.source import LENGTH, Source
from benchtwin.vision.foreign.unit_inference import SCALE
from benchtwin.vision.measurement import MeasurementError, require

TOOL = "Tracker"
_PANEL, _ANY = "tracker.TrackerPanel", b"org.opensourcephysics.cabrillo.tracker."
_CALIBRATIONS = (".TapeMeasure", ".Calibration")


@dataclass(frozen=True)
class _System:
    """The coordinate system at one frame: origin [px, y down], angle of the x axis
    [deg, anticlockwise], pixels per unit."""

    x0: float
    y0: float
    angle: float
    scale: tuple[float, float]

    def place(self, x: float, y: float) -> tuple[float, float]:
        turn, right, up = np.radians(self.angle), x - self.x0, self.y0 - y
        across = right * np.cos(turn) + up * np.sin(turn)
        along = up * np.cos(turn) - right * np.sin(turn)
        return float(across / self.scale[0]), float(along / self.scale[1])


def recognises(source: Source) -> bool:
    """Whether a file is of this kind, by its name and its first lines."""
    if source.is_zip:
        return any(name.lower().endswith(".trk") for name in source.members)
    return source.is_xml and _ANY in source.head


def read(source: Source) -> Tracked:
    """The project's tracks, with its clip's times, its scale and its axes."""
    panel, inside = _panel(source)
    clip, control, coords = (
        panel.find(f"*[@name='{name}']/object")
        for name in ("videoclip", "clipcontrol", "coords")
    )
    step_ms = _number(source, control, "delta_t")
    if step_ms is None or not 1e-4 < step_ms < 1e7:
        raise MeasurementError(
            f"{source.path}: delta_t = {step_ms} of its clip; it should be the"
            " milliseconds from frame to frame"
        )
    start_ms = _number(source, clip, "starttime") or 0.0
    first = _number(source, clip, "startframe") or 0.0
    systems = _systems(source, coords)
    points = [
        item for item in _items(panel) if item.get("class", "").endswith(".PointMass")
    ]
    require(
        points,
        f"{source.path}: no point mass that was tracked; a model or a ruler is no"
        " measurement",
    )
    listed = []
    for item in points:
        rows = [
            ((start_ms + (frame - first) * step_ms) / 1000, x, y)
            for frame, x, y in _places(source, item, systems)
        ]
        listed.append((_text(item, "name"), rows))
    return _scaled(panel, inside, listed, 1000 / step_ms, systems)


def _scaled(
    panel: Element,
    inside: str,
    listed: list[tuple[str, list[tuple[float, float, float]]]],
    fps: float,
    systems: dict[int, _System],
) -> Tracked:
    """The tracks with the panel's unit and what is to be said on it."""
    guesses = [
        f"{fps:.6g} frames per second and times as {inside} says; a slowed film says"
        " another rate than its camera had"
    ]
    questions: list[Asked] = []
    keys = {"camera": {"fps": round(fps, 6)}}
    first, unit = systems[min(systems)], _text(panel, "length_unit")
    if {round(s.angle, 3) for s in systems.values()} != {0.0}:
        guesses.append(
            f"x and y along Tracker's axes, which are turned by {first.angle:.3g}°"
        )
    if first.scale[0] == 1.0 and not any(
        item.get("class", "").endswith(_CALIBRATIONS) for item in _items(panel)
    ):
        questions.append(replace(SCALE, words=f"it has no calibration: {SCALE.words}"))
        unit = "px"
    elif unit and unit.lower() not in LENGTH:
        asked = f"lengths are in {unit!r}: how many millimetres is one of them?"
        questions.append(replace(SCALE, words=f"{asked} Without it, ratios only"))
        unit = "px"
    elif not unit:
        guesses.append("lengths in metres, Tracker's unit where the file names none")
    if unit != "px" and len({s.scale for s in systems.values()}) == 1:
        keys["camera"]["mm_per_px"] = float(
            f"{LENGTH[unit.lower() or 'm'] / abs(first.scale[0]):.8g}"
        )
    return Tracked(listed, "s", unit or "m", "up", keys, guesses, questions)


def _panel(source: Source) -> tuple[Element, str]:
    """The TrackerPanel's element, and the name of the file it stands in."""
    name = source.path.name
    if source.is_zip:
        inside = [m for m in source.members if m.lower().endswith(".trk")]
        require(
            len(inside) <= 1,
            f"{source.path}: {len(inside)} .trk files in it; unpack it and take one"
            f" ({', '.join(inside)[:200]})",
        )
        name = inside[0]
        panel = source.parsed(source.member(name))
    else:
        panel = source.xml
    require(
        _PANEL in panel.get("class", ""),
        f"{source.path}: {name} holds several tabs or none; save one tab as .trk",
    )
    return panel, name


def _systems(source: Source, coords: Element | None) -> dict[int, _System]:
    """Coordinate systems by the first frame to which each applies."""
    systems = {}
    for frame, data in _frames(coords):
        x0, y0, angle, x_scale, y_scale = (
            _number(source, data, n)
            for n in ("xorigin", "yorigin", "angle", "xscale", "yscale")
        )
        if x0 is None or y0 is None or not x_scale or not y_scale:
            raise MeasurementError(
                f"{source.path}: its coordinate system at frame {frame} lacks origin or"
                " scale"
            )
        require(
            all(1e-9 < abs(s) < 1e12 for s in (x_scale, y_scale)),
            f"{source.path}: a scale of {x_scale:g} pixels a unit at frame {frame}"
            " cannot be",
        )
        systems[frame] = _System(x0, y0, angle or 0.0, (x_scale, y_scale))
    require(systems, f"{source.path}: no coordinate system in it")
    return systems


def _places(
    source: Source, item: Element, systems: dict[int, _System]
) -> Iterator[tuple[int, float, float]]:
    """Frame and place of a point mass, one after the other, in Tracker's
    coordinates."""
    for frame, data in _frames(item):
        x, y = _number(source, data, "x"), _number(source, data, "y")
        if x is None or y is None:
            continue
        holds = max((f for f in systems if f <= frame), default=min(systems))
        yield frame, *systems[holds].place(x, y)


def _items(panel: Element) -> list[Element]:
    return [
        o
        for p in panel.iterfind("*[@name='tracks']/*")
        if (o := p.find("object")) is not None
    ]


def _frames(element: Element | None) -> Iterator[tuple[int, Element]]:
    """(frame, object) of an element's framedata; those that are empty are left out."""
    for child in () if element is None else element.iterfind("*[@name='framedata']/*"):
        number = re.fullmatch(r"\[(\d{1,9})\]", child.get("name", ""))
        inside = child.find("object")
        if number and inside is not None:
            yield int(number[1]), inside


def _text(element: Element, name: str) -> str:
    return (element.findtext(f"*[@name='{name}']") or "").strip()


def _number(source: Source, element: Element | None, name: str) -> float | None:
    return None if element is None else source.number(_text(element, name), name)
