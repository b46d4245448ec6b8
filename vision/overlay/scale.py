"""The graph paper that was found, drawn over its picture."""

import cv2
import numpy as np

from vision.paper.scale import Scale

WIDEST_PX = 1600
REGION, LINE = (0, 120, 255), (0, 200, 255)


def draw_scale(image: np.ndarray, scale: Scale) -> np.ndarray:
    """Overlay (uint8 RGB, at most 1600 px wide): the paper's region, its 10-mm lines as fitted, the scale in words."""
    canvas, factor = canvas_of(image)
    paint_scale(canvas, factor, scale)
    return canvas


def canvas_of(image: np.ndarray) -> tuple[np.ndarray, float]:
    """A picture as uint8 RGB of at most 1600 px width and height × 1.5, and its reduction (canvas px per picture px)."""
    factor = min(1.0, WIDEST_PX / image.shape[1], 1.5 * WIDEST_PX / image.shape[0])
    if image.dtype == np.uint16:
        image = (image >> 8).astype(np.uint8)
    if image.ndim == 3 and image.shape[2] == 1:
        image = image[..., 0]
    rgb = cv2.cvtColor(image, cv2.COLOR_GRAY2RGB) if image.ndim == 2 else image.copy()
    if factor < 1:
        rgb = cv2.resize(rgb, None, fx=factor, fy=factor, interpolation=cv2.INTER_AREA)
    return rgb, factor


def to_canvas(points: np.ndarray, factor: float) -> np.ndarray:
    """Picture px to canvas px, in sixteenths for OpenCV's `shift=4`."""
    return np.rint(((np.asarray(points, float) + 0.5) * factor - 0.5) * 16).astype(np.int32)


def paint_scale(canvas: np.ndarray, factor: float, scale: Scale) -> None:
    """Draw region, fitted 10-mm lines within it, and the scale, onto `canvas`."""
    height, width = canvas.shape[:2]
    thick = max(1, round(width / 700))
    polygon = to_canvas(scale.region, factor)
    cv2.polylines(canvas, [polygon], True, REGION, thick, cv2.LINE_AA, 4)
    y, x = np.mgrid[0:height, 0:width].astype(np.float32)
    inside = cv2.fillConvexPoly(np.zeros((height, width), np.uint8), polygon, 1, shift=4) > 0
    u, v = scale.to_mm((x[inside] + 0.5) / factor - 0.5, (y[inside] + 0.5) / factor - 0.5)
    half = thick * scale.paper_mm_per_px / factor / 2
    on_line = np.minimum(*(np.abs(w - 10 * np.rint(w / 10)) for w in (u, v))) < half
    canvas[np.nonzero(inside)[0][on_line], np.nonzero(inside)[1][on_line]] = LINE
    text = f"{1 / scale.paper_mm_per_px:.2f} px/mm  tilt {scale.tilt_deg:+.2f} deg"
    place = np.clip(polygon[polygon[:, 1].argmin()] // 16 + (4, -6), (4, 24), (width - 260, height - 10))
    write(canvas, text, tuple(int(p) for p in place), REGION, width / 1600)


def write(canvas: np.ndarray, text: str, place: tuple[int, int], colour, size: float) -> None:
    """Text with a dark rim, readable on any ground."""
    size = max(0.4, size)
    cv2.putText(canvas, text, place, cv2.FONT_HERSHEY_SIMPLEX, size, (0, 0, 0), max(2, round(4 * size)), cv2.LINE_AA)
    cv2.putText(canvas, text, place, cv2.FONT_HERSHEY_SIMPLEX, size, colour, max(1, round(1.5 * size)), cv2.LINE_AA)
