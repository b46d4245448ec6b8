"""The graph paper that was found, drawn over its picture."""

import cv2
import numpy as np

from vision.overlay.canvas import Canvas
from vision.paper.scale import Scale

REGION, LINE = (0, 120, 255), (0, 200, 255)


def draw_scale(image: np.ndarray, scale: Scale) -> np.ndarray:
    """Overlay (uint8 RGB): the paper's region, its 10-mm lines as fitted, the scale in words."""
    canvas = Canvas(image)
    paint_scale(canvas, scale)
    canvas.legend([(scale_words(scale), REGION)])
    return canvas.pixels


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
