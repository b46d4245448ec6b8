"""Every seed that was found, with outline, number, length and width, drawn over its picture."""

import cv2
import numpy as np

from vision.measurement import DOUBTFUL, FAILED, GOOD
from vision.overlay.canvas import WHITE, Canvas
from vision.paper.scale import Scale
from vision.shape.grains import Grain, Grains

COLOURS = {GOOD: (60, 255, 60), DOUBTFUL: (255, 190, 0), FAILED: (255, 60, 60)}
REGION, LINE = (0, 120, 255), (0, 200, 255)


def draw_grains(image: np.ndarray, grains: Grains, paper: Scale | None = None) -> np.ndarray:
    """Overlay (uint8 RGB): seeds that count green, doubtful ones amber, what was left out red; numbers as in seeds.csv."""
    canvas = Canvas(image)
    paper = paper or (grains.scale if isinstance(grains.scale, Scale) else None)
    if paper is not None:
        paint_scale(canvas, paper)
    for number, grain in enumerate(grains.grains, 1):
        colour = COLOURS[grain.quality]
        canvas.polygon(grain.edge, colour, 1.0)
        if grain.quality != FAILED:
            for ends in _axes(grain):
                canvas.curve(ends[:, 0], ends[:, 1], colour, 0.5)
        canvas.tag(str(number), grain.x_px, grain.y_px, colour, 0.6 * grain.width_px)
    canvas.legend([*_words(grains), *([(scale_words(paper), REGION)] if paper is not None else [])])
    return canvas.pixels


def _words(grains: Grains):
    counts = {q: sum(g.quality == q for g in grains.grains) for q in COLOURS}
    yield ", ".join(f"{n} {q}" for q, n in counts.items()), WHITE
    for row in grains.distribution().itertuples():
        yield f"{row.quantity} {row.mean:.3g} {row.unit}, sd {row.sd:.2g}, {row.min:.3g} to {row.max:.3g}", WHITE


def _axes(grain: Grain) -> list[np.ndarray]:
    """The two corners that are a length apart, and the width across the middle."""
    turn = np.radians(grain.angle_deg)
    along = np.array([np.cos(turn), np.sin(turn)])
    across = np.array([-along[1], along[0]])
    place = grain.edge @ along
    middle = np.array([grain.x_px, grain.y_px])
    return [
        grain.edge[[place.argmin(), place.argmax()]],
        np.stack([middle - across * grain.width_px / 2, middle + across * grain.width_px / 2]),
    ]


def scale_words(scale: Scale) -> str:
    """A scale in words: pixels a millimetre, and the paper's tilt."""
    return f"graph paper: {1 / scale.paper_mm_per_px:.2f} px/mm, tilt {scale.tilt_deg:+.2f}°"


def paint_scale(canvas: Canvas, scale: Scale) -> None:
    """Draw the paper's region and the fitted 10-mm lines within it."""
    height, width = canvas.pixels.shape[:2]
    canvas.polygon(scale.region, REGION, 1.5)
    inside = np.zeros((height, width), np.uint8)
    region = ((np.asarray(scale.region, float) + 0.5) * canvas.scale - 0.5) * 16
    cv2.fillConvexPoly(inside, np.rint(region).astype(np.int32), 1, shift=4)
    rows, columns = np.nonzero(inside)
    u, v = scale.to_mm((columns + 0.5) / canvas.scale - 0.5, (rows + 0.5) / canvas.scale - 0.5)
    half = round(canvas.unit) * scale.paper_mm_per_px / canvas.scale / 2
    on_line = np.minimum(*(np.abs(w - 10 * np.rint(w / 10)) for w in (u, v))) < half
    canvas.pixels[rows[on_line], columns[on_line]] = LINE
