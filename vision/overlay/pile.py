"""A pile photo with the found surface, base line, window heights, fitted lines and
angles drawn on it."""

import numpy as np

from benchtwin.vision.board.view import BoardView
from benchtwin.vision.measurement import GOOD
from benchtwin.vision.overlay.board import paint_board
from benchtwin.vision.overlay.canvas import BLUE, GREEN, RED, WHITE, YELLOW, Canvas
from benchtwin.vision.pile.repose import Repose


def draw_repose(
    image: np.ndarray, found: Repose, board: BoardView | None = None
) -> np.ndarray:
    """Overlay (uint8 RGB): surface green, base line blue, window dashed yellow, fitted
    lines red; a printed board blue, its corners crossed."""
    canvas = Canvas(image)
    if board is not None:
        paint_board(canvas, board)
    x0, y0, width, height = found.roi
    x = np.arange(found.surface.size)
    canvas.curve(x + x0, found.surface + y0, GREEN, 1.5)
    ends = np.array([0, width - 1])
    canvas.curve(ends + x0, found.base.at(ends) + y0, BLUE, 1.5)
    rise = float(found.base.at(found.crest[0] - x0)) + y0 - found.crest[1]
    dashes = np.linspace(0, width - 1, 120)
    dashes[2::3] = np.nan
    for fraction in found.window:
        rows = found.base.at(dashes) + y0 - fraction * rise
        canvas.curve(dashes + x0, rows, YELLOW, 1.0)
    for slope in found.slopes:
        ends = np.array([slope.line.x_low, slope.line.x_high])
        canvas.curve(ends + x0, slope.line.at(ends) + y0, RED, 2.5)
    if (width, height) != (image.shape[1], image.shape[0]):
        corners = np.array([(0, 0), (1, 0), (1, 1), (0, 1)])
        canvas.polygon([x0, y0] + corners * [width, height], WHITE, 1.0)
    canvas.legend([*_words(found)])
    return canvas.pixels


def _words(found: Repose):
    one_sided = len(found.slopes) == 1  # its only side's angle is the angle
    for q in found.quantities:
        if np.isfinite(q.value) and not (
            one_sided and q.name.endswith(("_left", "_right"))
        ):
            colour = WHITE if q.quality == GOOD else YELLOW
            yield (f"{q.in_words}  {q.quality}", colour)
    yield from ((note, BLUE) for note in found.notes)
    reasons = (part for q in found.quantities for part in q.reason.split("; ") if part)
    yield from ((reason, YELLOW) for reason in dict.fromkeys(reasons))
