"""MTrackJ (ImageJ): .mdf, lines of "Track n …" and "Point n x y z t channel", in pixels, y down, t the frame."""

import numpy as np

from vision.foreign.found import Found
from vision.foreign.settle import Stated, settled
from vision.foreign.source import Source
from vision.foreign.trails import some, trail
from vision.measurement import MeasurementError

TOOL = "MTrackJ"


def holds(source: Source) -> bool:
    """Whether the file is a data file of ImageJ's plug-in MTrackJ."""
    return source.head.lstrip(b"\xef\xbb\xbf").startswith(b"MTrackJ ") and b"Data File" in source.head[:60]


def read(source: Source) -> Found:
    """The file's tracks, cluster by cluster."""
    tracks: list[tuple[str, list[list[float]]]] = []
    cluster = ""
    for k, line in enumerate(source.text.splitlines(), 1):
        word, *rest = line.split() or [""]
        if word == "Cluster":
            cluster = rest[0][:20] if rest else ""
        elif word == "Track":
            name = f"track {rest[0][:20] if rest else len(tracks) + 1}"
            tracks.append((name if cluster in ("", "1") else f"{name} of cluster {cluster}", []))
        elif word == "Point":
            if not tracks:
                raise MeasurementError(f"{source.path}: line {k} is a Point before any Track")
            tracks[-1][1].append(_point(source, k, rest))
    trails = []
    for name, points in tracks:
        x, y, frame = np.array(points, dtype=float).reshape(-1, 3).T
        trails.append(trail(source.path, name, frame, x, y))
    return settled(Stated(source.path, TOOL, some(source.path, trails), "frame", "px", "down"), {}, [], [])


def _point(source: Source, line: int, cells: list[str]) -> list[float]:
    try:
        x, y, frame = float(cells[1]), float(cells[2]), float(cells[4])
    except (ValueError, IndexError) as error:
        raise MeasurementError(f"{source.path}: line {line} is no Point with number, x, y, z, t and channel") from error
    return [x, y, frame]
