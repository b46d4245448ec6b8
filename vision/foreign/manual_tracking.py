"""ImageJ's and Fiji's Manual Tracking: a results table of Track n°, Slice n°, X, Y,
Distance, Velocity, Pixel Value, in pixels, y down."""

import re
from dataclasses import replace

import numpy as np

from benchtwin.vision.foreign.contents import Asked, Tracked, numbered
from benchtwin.vision.foreign.source import Source, column, need
from benchtwin.vision.foreign.unit_inference import SCALE

TOOL = "ImageJ Manual Tracking"
_NUMBERED = re.compile(r"(track|slice)\s*n\S*")  # "Track n°", in any encoding


def recognises(source: Source) -> bool:
    """Whether a file is of this kind, by its name and its first lines."""
    heading = " ".join(map(str, source.first_rows[0])).lower() if source.is_text else ""
    return {*_NUMBERED.findall(heading)} == {"track", "slice"}


def read(source: Source) -> Tracked:
    """The table's tracks; frames are numbered, and units are those that its headings
    name."""
    headings = [_NUMBERED.sub(r"\1", str(h).lower()) for h in source.rows[0]]
    rows, path = source.rows[1:], source.path
    places = need(path, headings, ("track", "slice", "x", "y"))
    number, frame, x, y = (column(path, rows, k, headings[k], 2) for k in places)
    questions: list[Asked] = []
    if "distance" in headings:
        gone = column(path, rows, headings.index("distance"), "distance", 2)
        pixels = np.hypot(np.diff(x, prepend=np.nan), np.diff(y, prepend=np.nan))
        use = (np.diff(number, prepend=np.nan) == 0) & (gone > 0) & (pixels > 0)
        scale = float(np.median(gone[use] / pixels[use])) if use.any() else 1.0
        if abs(scale - 1) > 1e-3:
            says = f"its Distance says {scale:.5g} units a pixel, in the unit chosen in"
            questions.append(replace(SCALE, words=f"{says} ImageJ; {SCALE.words}"))
    return Tracked(
        numbered(number, frame, x, y),
        "frame",
        "px",
        "down",
        guesses=["a slice is a frame"],
        questions=questions,
    )
