"""Pictures of seeds: each with outline, number and size over its photo; all outlines of
a lot; its sizes."""

import cv2
import numpy as np

from benchtwin.vision.board.view import BoardView
from benchtwin.vision.measurement import DOUBTFUL, FAILED, GOOD
from benchtwin.vision.overlay.board import REGION, board_words, paint_board
from benchtwin.vision.overlay.canvas import SHOWN_PX, WHITE, Canvas, write
from benchtwin.vision.shape.grains import Grain, Grains
from benchtwin.vision.shape.lot import SIZES, Lot
from benchtwin.vision.shape.outline import from_fourier_terms

COLOURS = {GOOD: (60, 255, 60), DOUBTFUL: (255, 190, 0), FAILED: (255, 60, 60)}
SIDE, HIGH, WIDE, MARGIN, BINS = 900, 420, 520, 60, 15
PAPER = 255
INK = (60, 60, 60)
OUTLINE = (190, 170, 140)
BOLD = (160, 60, 30)
BAR = (200, 160, 110)


def draw_grains(
    image: np.ndarray, grains: Grains, board: BoardView | None = None
) -> np.ndarray:
    """Overlay (uint8 RGB): seeds that count green, doubtful ones amber, what was left
    out red; numbers as in seeds.csv."""
    canvas = Canvas(image)
    board = board or (grains.scale if isinstance(grains.scale, BoardView) else None)
    if board is not None:
        paint_board(canvas, board)
    for number, grain in enumerate(grains.grains, 1):
        colour = COLOURS[grain.quality]
        canvas.polygon(grain.edge, colour, 1.0)
        if grain.quality != FAILED:
            for ends in _axes(grain):
                canvas.curve(ends[:, 0], ends[:, 1], colour, 0.5)
        canvas.tag(str(number), grain.x_px, grain.y_px, colour, 0.6 * grain.width_px)
    scale = [(board_words(board), REGION)] if board is not None else []
    canvas.legend([*_words(grains), *scale])
    return canvas.pixels


def _words(grains: Grains):
    counts = {q: sum(g.quality == q for g in grains.grains) for q in COLOURS}
    yield ", ".join(f"{n} {q}" for q, n in counts.items()), WHITE
    for row in grains.distribution().itertuples():
        yield (
            (
                f"{row.quantity} {row.mean:.3g} {row.unit}, sd {row.sd:.2g},"
                f" {row.min:.3g} to {row.max:.3g}"
            ),
            WHITE,
        )


def _axes(grain: Grain) -> list[np.ndarray]:
    """The two corners that are a length apart, and the width across the middle."""
    turn = np.radians(grain.angle_deg)
    along = np.array([np.cos(turn), np.sin(turn)])
    across = np.array([-along[1], along[0]])
    place = grain.edge @ along
    middle = np.array([grain.x_px, grain.y_px])
    half = across * grain.width_px / 2
    ends = grain.edge[[place.argmin(), place.argmax()]]
    return [ends, np.stack([middle - half, middle + half])]


def draw_outlines(lot: Lot) -> np.ndarray:
    """Every outline about its centroid, its length across the picture; the mean outline
    bold; a bar of 1 mm. uint8 RGB."""
    reach = max(np.abs(s.outline_mm(90)).max() for s in lot.seeds)
    scale = (SIDE / 2 - MARGIN) / reach
    image = np.full((SIDE, SIDE, 3), PAPER, np.uint8)

    def draw(points: np.ndarray, colour: tuple[int, int, int], width: int) -> None:
        at = np.rint(16 * (SIDE / 2 + points * [scale, -scale])).astype(np.int32)
        cv2.polylines(image, [at], True, colour, width, cv2.LINE_AA, 4)

    for seed in lot.seeds:
        draw(seed.outline_mm(180), OUTLINE, 1)
    draw(
        from_fourier_terms(np.mean([s.terms for s in lot.seeds], axis=0), 180), BOLD, 3
    )
    cv2.line(image, (MARGIN, SIDE - 25), (MARGIN + round(scale), SIDE - 25), INK, 3)
    words = f"1 mm; {len(lot.seeds)} seeds, their mean bold"
    write(image, words, MARGIN, SIDE - 38, INK, SIDE / SHOWN_PX)
    return image


def draw_sizes(lot: Lot) -> np.ndarray:
    """A histogram a size that was measured, side by side. uint8 RGB."""
    sizes = lot.sizes_mm()
    panels = [
        _histogram(sizes[np.isfinite(sizes[:, k]), k], name)
        for k, name in enumerate(SIZES)
        if np.isfinite(sizes[:, k]).any()
    ]
    return np.hstack(panels)


def _histogram(values: np.ndarray, name: str) -> np.ndarray:
    image = np.full((HIGH, WIDE, 3), PAPER, np.uint8)
    counts, edges = np.histogram(values, BINS)
    step, unit = (WIDE - 2 * MARGIN) / BINS, (HIGH - 2 * MARGIN) / counts.max()
    for k, count in enumerate(counts):
        x = MARGIN + k * step
        top = round(HIGH - MARGIN - count * unit)
        right = round(x + step) - 1
        cv2.rectangle(image, (round(x), top), (right, HIGH - MARGIN), BAR, -1)
    floor = HIGH - MARGIN
    cv2.line(image, (MARGIN, floor), (WIDE - MARGIN, floor), INK, 1, cv2.LINE_AA)
    shown = 2 * WIDE / SHOWN_PX  # two stand side by side
    for at, value in ((MARGIN, edges[0]), (WIDE - MARGIN, edges[-1])):
        write(image, f"{value:.2f}", at, HIGH - MARGIN + 24, INK, shown, anchor=0.5)
    sd = f" ± {values.std(ddof=1):.2f}" if len(values) > 1 else ""
    words = f"{name}: {values.mean():.2f}{sd} mm, n = {len(values)}"
    write(image, words, MARGIN, 30, INK, shown)
    return image
