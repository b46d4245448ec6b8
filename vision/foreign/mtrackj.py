"""MTrackJ (ImageJ): .mdf, lines of "Track n …" and "Point n x y z t channel", in
pixels, y down, t the frame."""

from benchtwin.vision.foreign.contents import Tracked
from benchtwin.vision.foreign.source import Source
from benchtwin.vision.measurement import require

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
            wrong = f"line {k} is no Point with number, x, y, z, t and channel"
            _, x, y, _, frame = source.numbers(rest, 5, wrong)
            listed[-1][1].append([frame, x, y])
    return Tracked(listed, "frame", "px", "down")
