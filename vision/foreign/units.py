"""Names of units in headings of tables and in files."""

import re

LENGTH = {  # → millimetres
    "mm": 1.0, "millimeter": 1.0, "millimetre": 1.0, "cm": 10.0, "centimeter": 10.0, "centimetre": 10.0, "dm": 100.0, "m": 1000.0,
    "meter": 1000.0, "metre": 1000.0, "meters": 1000.0, "metres": 1000.0, "µm": 1e-3, "μm": 1e-3, "um": 1e-3, "micron": 1e-3,
    "microns": 1e-3, "nm": 1e-6, "in": 25.4, "inch": 25.4, "inches": 25.4, "ft": 304.8, "feet": 304.8, "yd": 914.4,
}  # fmt: skip
PIXELS = ("px", "pixel", "pixels", "pix")
TIME = {  # → seconds
    "s": 1.0, "sec": 1.0, "secs": 1.0, "second": 1.0, "seconds": 1.0, "ms": 1e-3, "msec": 1e-3, "millisecond": 1e-3,
    "milliseconds": 1e-3, "µs": 1e-6, "μs": 1e-6, "us": 1e-6, "ns": 1e-9, "nanoseconds": 1e-9, "min": 60.0, "minute": 60.0,
    "minutes": 60.0, "h": 3600.0, "hour": 3600.0,
}  # fmt: skip
FRAMES = ("frame", "frames", "slice", "slices")
_IN_BRACKETS = re.compile(r"(.*?)[\s_]*[\(\[]\s*([^()\[\]]*?)\s*[\)\]]\s*")


def name_and_unit(heading: object) -> tuple[str, str]:
    """A column's name and the unit in brackets behind it, both in small letters: "Time (s)" → ("time", "s")."""
    text = str(heading).strip().strip('"').lower()
    found = _IN_BRACKETS.fullmatch(text)
    return (found[1].strip(), found[2]) if found else (text, "")
