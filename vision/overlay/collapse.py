"""A film of a collapse in one picture: where seeds came and went, coloured by when."""

import cv2
import numpy as np

from benchtwin.vision.overlay.canvas import WHITE, Canvas
from benchtwin.vision.pile.collapse import Filmed

DIM = 3  # what did not change is so much darker


def draw_collapse(image: np.ndarray, seen: Filmed, factor: float) -> np.ndarray:
    """Overlay (uint8 RGB): the last frame, dark, with the time of change from blue to
    red, and the times in words."""
    there = np.isfinite(seen.arrived)
    begin, end = np.nanmin(seen.arrived), np.nanmax(seen.arrived)
    share = (np.nan_to_num(seen.arrived, nan=begin) - begin) / max(end - begin, 1e-9)
    coloured = cv2.applyColorMap((255 * share).astype(np.uint8), cv2.COLORMAP_TURBO)
    size = tuple(int(n * factor) for n in reversed(there.shape))
    grey = image if image.ndim == 2 else cv2.cvtColor(image, cv2.COLOR_RGB2GRAY)
    picture = np.repeat(grey[..., None] // DIM, 3, axis=2)
    part = picture[: size[1], : size[0]]
    large = cv2.resize(coloured[..., ::-1], size, interpolation=cv2.INTER_NEAREST)
    mask = cv2.resize(there.astype(np.uint8), size, interpolation=cv2.INTER_NEAREST) > 0
    part[mask] = large[mask]
    canvas = Canvas(picture)
    words = [f"{q.in_words}  {q.quality}" for q in seen.collapse.quantities()]
    when = f"seeds came or went between {begin:.2f} s (blue) and {end:.2f} s (red)"
    canvas.legend([(line, WHITE) for line in (*words, when)])
    return canvas.pixels
