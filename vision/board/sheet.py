"""The board to print: a chessboard whose white squares hold markers (ChArUco), by which
every corner of it is known, and a line of known length to check the printer by.

Each size of paper has markers of its own, so that a picture tells which one it
shows."""

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import cv2
import numpy as np
from PIL import Image, ImageDraw, ImageFont

from benchtwin.bench.whole_file import whole
from benchtwin.vision.measurement import require

SQUARES = (7, 9)  # across, upward: 31 markers, 48 inner corners
MARKER_SHARE = 0.75  # of a square
DICTIONARY = cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_4X4_100)
MARKERS = SQUARES[0] * SQUARES[1] // 2
PX_PER_MM = 20
TEXT_MM, TICK_MM, MARGIN_MM = 3.0, 3.0, 6.0


@dataclass(frozen=True)
class Sheet:
    """A board for one size of paper; lengths in mm."""

    name: str
    page_mm: tuple[int, int]  # width, height
    square_mm: int
    line_mm: int  # the line by which the print is checked
    first_marker: int

    @cached_property
    def board(self) -> cv2.aruco.CharucoBoard:
        """As OpenCV knows it."""
        markers = np.arange(self.first_marker, self.first_marker + MARKERS)
        side = float(self.square_mm)
        return cv2.aruco.CharucoBoard(
            SQUARES, side, MARKER_SHARE * side, DICTIONARY, markers
        )

    @property
    def size_mm(self) -> np.ndarray:
        """Width and height of the chessboard."""
        return np.array(SQUARES) * float(self.square_mm)

    def corners_mm(self) -> np.ndarray:
        """Places (48, 2) of the inner corners about the chessboard's middle, x to the
        right, y upward."""
        corners = np.array(self.board.getChessboardCorners())[:, :2]
        return (corners - self.size_mm / 2) * [1, -1]

    def page_mm_about_board(self, beyond_mm: float = 0.0) -> np.ndarray:
        """The page's corners (4, 2) about the chessboard's middle, each moved outward
        by so much; y upward."""
        width, height = self.page_mm
        top = MARGIN_MM + self.size_mm[1] / 2 + beyond_mm
        x, low = width / 2 + beyond_mm, top - height - 2 * beyond_mm
        return np.array([[-x, top], [x, top], [x, low], [-x, low]])


SHEETS = {
    sheet.name: sheet
    for sheet in (
        Sheet("A4", (210, 297), 26, 150, 0),
        Sheet("A5", (148, 210), 18, 100, MARKERS),
        Sheet("A6", (105, 148), 12, 80, 2 * MARKERS),
    )
}


def sheet_of(name: str) -> Sheet:
    """The sheet of that name; MeasurementError where there is none."""
    require(
        name.upper() in SHEETS, f"{name}: a board is printed on {', '.join(SHEETS)}"
    )
    return SHEETS[name.upper()]


def draw_page(sheet: Sheet) -> Image.Image:
    """The page, one bit a pixel, PX_PER_MM pixels a millimetre."""
    width, height = (side * PX_PER_MM for side in sheet.page_mm)
    page = Image.new("1", (width, height), 1)
    across, upward = (int(side * PX_PER_MM) for side in sheet.size_mm)
    left, top = (width - across) // 2, round(MARGIN_MM * PX_PER_MM)
    picture = sheet.board.generateImage((across, upward), marginSize=0)
    page.paste(Image.fromarray(picture).convert("1"), (left, top))
    pen = ImageDraw.Draw(page)
    low = top + upward + round(2 * MARGIN_MM * PX_PER_MM)
    start = (width - sheet.line_mm * PX_PER_MM) // 2
    for mm in range(sheet.line_mm + 1):
        long = TICK_MM * (1 if mm % 10 == 0 else 0.75 if mm % 5 == 0 else 0.5)
        x = start + mm * PX_PER_MM
        pen.line((x, low, x, low - round(long * PX_PER_MM)), fill=0, width=2)
    pen.line((start, low, start + sheet.line_mm * PX_PER_MM, low), fill=0, width=3)
    font = ImageFont.load_default(TEXT_MM * PX_PER_MM)
    words = (
        f"benchtwin {sheet.name}: print at 100 %. This line is {sheet.line_mm} mm long;"
        f"\nif it is not, state its length: [camera] board_line_mm. Glue the sheet"
        "\nto something flat and stand it upright beside what is filmed."
    )
    pen.multiline_text((start, low + 2 * PX_PER_MM), words, fill=0, font=font)
    return page


def write_board(sheet: Sheet, out: Path) -> None:
    """Write the page as a PDF of exactly its size, or as a PNG, by the file's
    ending."""
    ending = out.suffix.lower()
    require(ending in (".pdf", ".png"), f"{out}: a board is written as .pdf or .png")
    resolution = PX_PER_MM * 25.4
    with whole(out) as part:
        if ending == ".pdf":
            draw_page(sheet).save(part, "PDF", resolution=resolution)
        else:
            draw_page(sheet).save(part, "PNG", dpi=(resolution, resolution))
