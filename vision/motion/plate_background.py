"""The background of a tilting plate, in a film whose camera stands still.

Each pixel is the median over the FARTHEST frames in which the plate's edge is farthest
from it: plate and block are elsewhere then. Near the hinge, where the plate hardly
moves, they may be part of it."""

from dataclasses import dataclass

import numpy as np

from benchtwin.vision.evidence.frames import FrameSource, limit_to_memory
from benchtwin.vision.motion.edge_line import Line

PICTURES, FARTHEST = 40, 5  # over the film; of them, those whose median is taken
PLATE_PX = 16.0  # of a picture 640 px wide: so near its edge the plate may be seen
ROWS = 16  # at a time


@dataclass(frozen=True)
class Background:
    """picture: float32, of the frames' shape and levels; plate_rows: how far above its
    edge the plate itself reaches [px]."""

    picture: np.ndarray
    plate_rows: int


def background_of(
    source: FrameSource, lines: dict[int, Line], plate_rows: int
) -> Background:
    """The background of frames in which the plate's edge is known; lines: by frame."""
    first = next(source.iterate()).pixels
    number = limit_to_memory(PICTURES, first)
    frames = [f for f in source.picked(number) if f.index in lines]
    frames = [f for f in frames if f.pixels.shape == first.shape]
    pixels = np.array([np.atleast_3d(f.pixels) for f in frames])
    edges = [lines[f.index] for f in frames]
    across = np.array([edge.across for edge in edges], np.float32)[..., None, None]
    offset = np.array([edge.offset for edge in edges], np.float32)[:, None, None]
    height, width = first.shape[:2]
    near = max(PLATE_PX * width / 640, plate_rows + 2)
    columns, found = np.arange(width, dtype=np.float32), []
    for top in range(0, height, ROWS):
        rows = np.arange(top, min(top + ROWS, height), dtype=np.float32)[:, None]
        off = np.abs(across[:, 0] * columns + across[:, 1] * rows - offset)
        off[off < near] = 0.0
        best = np.argsort(-off, axis=0, kind="stable")[:FARTHEST]
        part = pixels[:, top : top + ROWS]
        found.append(np.median(np.take_along_axis(part, best[..., None], 0), axis=0))
    picture = np.concatenate(found).astype(np.float32).reshape(first.shape)
    return Background(picture, plate_rows)
