"""Pictures of seeds: each with outline, number and size over its photo; all outlines of
a lot; its sizes."""

from typing import Any

import numpy as np

from benchtwin.vision.board.view import BoardView
from benchtwin.vision.measurement import DOUBTFUL, FAILED, GOOD
from benchtwin.vision.overlay.board import REGION, board_words, paint_board
from benchtwin.vision.overlay.canvas import WHITE, Canvas
from benchtwin.vision.overlay.plot import as_pixels, new_figure
from benchtwin.vision.shape.grains import Grains
from benchtwin.vision.shape.lot import SIZES, Lot
from benchtwin.vision.shape.outline import from_fourier_terms

COLOURS = {GOOD: (60, 255, 60), DOUBTFUL: (255, 190, 0), FAILED: (255, 60, 60)}
SIDE, HIGH, WIDE, BINS = 900, 420, 520, 15
POINTS = 180  # of an outline as it is drawn
OUTLINE, BOLD, BAR = "#beaa8c", "#a03c1e", "#c8a06e"


def draw_grains(
    image: np.ndarray, grains: Grains, board: BoardView | None = None
) -> np.ndarray:
    """Overlay (uint8 RGB): seeds that count green, doubtful ones amber, what was left
    out red; numbers as in seeds.csv."""
    canvas = Canvas(image)
    board = board or (grains.scale if isinstance(grains.scale, BoardView) else None)
    if board is not None:
        paint_board(canvas, board)
    for grain in grains.grains:
        colour = COLOURS[grain.quality]
        canvas.polygon(grain.edge, colour, 1.0)
        if grain.quality != FAILED:
            for ends in _axes(grain):
                canvas.curve(*ends.T, colour, 0.5)
    canvas.tags(
        (str(number), g.x_px, g.y_px, COLOURS[g.quality], 0.6 * g.width_px)
        for number, g in enumerate(grains.grains, 1)
    )
    scale = [(board_words(board), REGION)] if board is not None else []
    canvas.legend([*_words(grains), *scale])
    return canvas.pixels


def _words(grains: Grains):
    counts = {q: (grains.things.quality == q).sum() for q in COLOURS}
    yield ", ".join(f"{n} {q}" for q, n in counts.items()), WHITE
    for row in grains.distribution().itertuples():
        yield (
            (
                f"{row.quantity} {row.mean:.3g} {row.unit}, sd {row.sd:.2g},"
                f" {row.min:.3g} to {row.max:.3g}"
            ),
            WHITE,
        )


def _axes(grain: Any) -> list[np.ndarray]:
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
    bold. uint8 RGB."""
    figure = new_figure((SIDE, SIDE))
    axes = figure.subplots()
    mean = from_fourier_terms(np.mean([s.terms for s in lot.seeds], axis=0), POINTS)
    for seed in lot.seeds:
        axes.fill(*seed.outline_mm(POINTS).T, edgecolor=OUTLINE, fill=False)
    axes.fill(*mean.T, edgecolor=BOLD, linewidth=2, fill=False)
    axes.set(xlabel="mm", ylabel="mm", aspect="equal")
    axes.set_title(f"{len(lot.seeds)} seeds, their mean bold")
    return as_pixels(figure)


def draw_sizes(lot: Lot) -> np.ndarray:
    """A histogram a size that was measured, side by side. uint8 RGB."""
    sizes = lot.sizes_mm()
    shown = [k for k in range(len(SIZES)) if np.isfinite(sizes[:, k]).any()]
    figure = new_figure((WIDE * len(shown), HIGH))
    for axes, k in zip(figure.subplots(1, len(shown), squeeze=False)[0], shown):
        values = sizes[np.isfinite(sizes[:, k]), k]
        axes.hist(values, BINS, color=BAR, edgecolor="white")
        sd = f" ± {values.std(ddof=1):.2f}" if len(values) > 1 else ""
        axes.set(xlabel="mm", yticks=())
        axes.set_title(f"{SIZES[k]}: {values.mean():.2f}{sd} mm, n = {len(values)}")
    return as_pixels(figure)
