"""Every seed that was found, with outline, number, length and width, drawn over its picture."""

import cv2
import numpy as np

from vision.measurement import DOUBTFUL, FAILED, GOOD
from vision.overlay.scale import canvas_of, paint_scale, to_canvas, write
from vision.paper.scale import Scale
from vision.seeds.grains import Grain, Grains

COLOURS = {GOOD: (60, 255, 60), DOUBTFUL: (255, 190, 0), FAILED: (255, 60, 60)}


def draw_grains(image: np.ndarray, grains: Grains, paper: Scale | None = None) -> np.ndarray:
    """Overlay (uint8 RGB): seeds that count green, doubtful ones amber, what was left out red; numbers as in seeds.csv."""
    canvas, factor = canvas_of(image)
    paper = paper or (grains.scale if isinstance(grains.scale, Scale) else None)
    if paper is not None:
        paint_scale(canvas, factor, paper)
    thick = max(1, round(canvas.shape[1] / 800))
    for number, grain in enumerate(grains.grains, 1):
        colour = COLOURS[grain.quality]
        cv2.polylines(canvas, [to_canvas(grain.edge, factor)], True, colour, thick, cv2.LINE_AA, 4)
        if grain.quality != FAILED:
            for ends in _axes(grain):
                cv2.polylines(canvas, [to_canvas(ends, factor)], False, colour, 1, cv2.LINE_AA, 4)
        x, y = (int(c / 16) for c in to_canvas((grain.x_px, grain.y_px), factor))
        write(canvas, str(number), (max(0, x - 8), y + 5), colour, canvas.shape[1] / 2200)
    return canvas


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
