"""MTrackJ (ImageJ): .mdf, lines of "Track n …" and "Point n x y z t channel", in
pixels, y down, t the frame."""

from benchtwin.vision.foreign.contents import Tracked
from benchtwin.vision.foreign.source import Source
from benchtwin.vision.measurement import MeasurementError, require

TOOL = "MTrackJ"


def recognises(source: Source) -> bool:
    """Whether a file is of this kind, by its name and its first lines."""
    return (
        source.head.lstrip(b"\xef\xbb\xbf").startswith(b"MTrackJ ")
        and b"Data File" in source.head[:60]
    )


def read(source: Source) -> Tracked:
    """The file's tracks, cluster by cluster."""
    listed: list[tuple[str, list[list[float]]]] = []
    cluster = ""
    for k, line in enumerate(source.text.splitlines(), 1):
        word, *rest = line.split() or [""]
        if word == "Cluster":
            cluster = rest[0][:20] if rest else ""
        elif word == "Track":
            name = f"track {rest[0][:20] if rest else len(listed) + 1}"
            listed.append(
                (name if cluster in ("", "1") else f"{name} of cluster {cluster}", [])
            )
        elif word == "Point":
            require(listed, f"{source.path}: line {k} is a Point before any Track")
            listed[-1][1].append(_point(source, k, rest))
    return Tracked(listed, "frame", "px", "down")


def _point(source: Source, line: int, cells: list[str]) -> list[float]:
    try:
        return [float(cells[k]) for k in (4, 1, 2)]  # frame, x, y
    except (ValueError, IndexError) as error:
        raise MeasurementError(
            f"{source.path}: line {line} is no Point with number, x, y, z, t and"
            " channel"
        ) from error
