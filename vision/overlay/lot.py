"""Pictures of a lot: all outlines laid over each other, and how its sizes are distributed."""

import cv2
import numpy as np

from vision.overlay.canvas import SHOWN_PX, write
from vision.shape.lot import SIZES, Lot
from vision.shape.outline import from_fourier_terms

SIDE, HIGH, WIDE, MARGIN, BINS = 900, 420, 520, 60, 15
PAPER, INK, LINE, BOLD, BAR = 255, (60, 60, 60), (190, 170, 140), (160, 60, 30), (200, 160, 110)


def draw_outlines(lot: Lot) -> np.ndarray:
    """Every outline about its centroid, its length across the picture; the mean outline bold; a bar of 1 mm. uint8 RGB."""
    reach = max(np.abs(s.outline_mm(90)).max() for s in lot.seeds)
    scale = (SIDE / 2 - MARGIN) / reach
    image = np.full((SIDE, SIDE, 3), PAPER, np.uint8)

    def draw(points: np.ndarray, colour: tuple[int, int, int], width: int) -> None:
        at = np.rint(16 * (SIDE / 2 + points * [scale, -scale])).astype(np.int32)
        cv2.polylines(image, [at], True, colour, width, cv2.LINE_AA, 4)

    for seed in lot.seeds:
        draw(seed.outline_mm(180), LINE, 1)
    draw(from_fourier_terms(np.mean([s.terms for s in lot.seeds], axis=0), 180), BOLD, 3)
    cv2.line(image, (MARGIN, SIDE - 25), (MARGIN + round(scale), SIDE - 25), INK, 3)
    write(image, f"1 mm; {len(lot.seeds)} seeds, their mean bold", MARGIN, SIDE - 38, INK, SIDE / SHOWN_PX)
    return image


def draw_sizes(lot: Lot) -> np.ndarray:
    """A histogram a size that was measured, side by side. uint8 RGB."""
    sizes = lot.sizes_mm()
    panels = [_histogram(sizes[np.isfinite(sizes[:, k]), k], name) for k, name in enumerate(SIZES) if np.isfinite(sizes[:, k]).any()]
    return np.hstack(panels)


def _histogram(values: np.ndarray, name: str) -> np.ndarray:
    image = np.full((HIGH, WIDE, 3), PAPER, np.uint8)
    counts, edges = np.histogram(values, BINS)
    step, unit = (WIDE - 2 * MARGIN) / BINS, (HIGH - 2 * MARGIN) / counts.max()
    for k, count in enumerate(counts):
        x = MARGIN + k * step
        cv2.rectangle(image, (round(x), round(HIGH - MARGIN - count * unit)), (round(x + step) - 1, HIGH - MARGIN), BAR, -1)
    cv2.line(image, (MARGIN, HIGH - MARGIN), (WIDE - MARGIN, HIGH - MARGIN), INK, 1, cv2.LINE_AA)
    shown = 2 * WIDE / SHOWN_PX  # two stand side by side
    for at, value in ((MARGIN, edges[0]), (WIDE - MARGIN, edges[-1])):
        write(image, f"{value:.2f}", at, HIGH - MARGIN + 24, INK, shown, anchor=0.5)
    sd = f" ± {values.std(ddof=1):.2f}" if len(values) > 1 else ""
    write(image, f"{name}: {values.mean():.2f}{sd} mm, n = {len(values)}", MARGIN, 30, INK, shown)
    return image
