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
    last = x0 + width - 1
    canvas.line(
        x0, found.base.at(0) + y0, last, found.base.at(width - 1) + y0, BLUE, 1.5
    )
    rise = float(found.base.at(found.crest[0] - x0)) + y0 - found.crest[1]
    for fraction in found.window:
        shift = y0 - fraction * rise
        canvas.dashed(
            x0,
            found.base.at(0) + shift,
            x0 + width - 1,
            found.base.at(width - 1) + shift,
            YELLOW,
            1.0,
        )
    for slope in found.slopes:
        line = slope.line
        canvas.line(
            line.x_low + x0,
            line.at(line.x_low) + y0,
            line.x_high + x0,
            line.at(line.x_high) + y0,
            RED,
            2.5,
        )
    if (found.roi[2], found.roi[3]) != (image.shape[1], image.shape[0]):
        for a, b, c, d in ((0, 0, 1, 0), (1, 0, 1, 1), (1, 1, 0, 1), (0, 1, 0, 0)):
            canvas.line(
                x0 + a * width,
                y0 + b * height,
                x0 + c * width,
                y0 + d * height,
                WHITE,
                1.0,
            )
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
