"""A printed board over its photo: its sheet, and the corners that were read."""

from benchtwin.bench.numbers import plus_minus
from benchtwin.vision.board.view import BoardView
from benchtwin.vision.overlay.canvas import Canvas

REGION, CORNER = (0, 120, 255), (0, 200, 255)


def board_words(board: BoardView) -> str:
    """The board in words: scale, and how the camera is held beside it."""
    scale, _ = board.mm_per_px()
    angles = board.attitude_deg()
    return (
        f"board {board.sheet_name}: {1 / scale:.2f} px/mm, camera looking down by"
        f" {plus_minus(*angles['pitch'], 'deg')}, gravity"
        f" {angles['plumb'][0]:+.2f}° from straight down"
    )


def paint_board(canvas: Canvas, board: BoardView) -> None:
    """Draw the sheet's outline and a cross on each corner that was read."""
    canvas.polygon(board.page_px(), REGION, 1.5)
    for x, y in board.corners.picture_px:
        canvas.cross(x, y, CORNER, 2.0, 1.0)
