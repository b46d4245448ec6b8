"""What every overlay starts from: the picture as 8-bit RGB at a size to look at, lines,
crosses and a legend that can be read."""

import textwrap

import cv2
import numpy as np
from numpy.typing import ArrayLike

FAR_PX = 1e6  # from the picture, where what is drawn is not seen
LONGEST_PX, SHORTEST_PX = 1600, 800
# the longest side at which overlays/index.html and report.html show a picture
SHOWN_PX = 480
# there: size of the letters, from one line of text to the next
LETTER_PX = 13
LINE_PX = 18
TALL = 1.3  # height over width beyond which the legend stands beside the picture
FONT = cv2.FONT_HERSHEY_SIMPLEX
# older versions of OpenCV have no other letters
ASCII_ONLY = int(cv2.__version__.split(".")[0]) < 5
ASCII = {
    "°": " deg",
    "±": "+/-",
    "–": "-",
    "−": "-",
    "×": "x",
    "√": "sqrt",
    "≤": "<=",
    "μ": "mu",
    "²": "2",
}
GREEN = (0, 200, 60)
RED = (235, 50, 40)
BLUE = (60, 150, 255)
YELLOW = (255, 210, 0)
WHITE = (255, 255, 255)
Colour = tuple[int, int, int]  # red, green, blue


class Canvas:
    """A picture to draw on, in the coordinates (px, y down) of the original."""

    def __init__(self, image: np.ndarray):
        longest = max(image.shape[:2])
        self.scale = (
            min(1.0, LONGEST_PX / longest)
            if longest > SHORTEST_PX
            else SHORTEST_PX / longest
        )
        size = (
            max(1, round(image.shape[1] * self.scale)),
            max(1, round(image.shape[0] * self.scale)),
        )
        interpolation = cv2.INTER_AREA if self.scale < 1 else cv2.INTER_LINEAR
        small = _eight_bits(
            cv2.resize(image, size, interpolation=interpolation)
            if self.scale != 1
            else image
        )
        self.pixels = (
            cv2.cvtColor(small, cv2.COLOR_GRAY2RGB)
            if small.ndim == 2
            else small[..., :3].copy()
        )
        self.unit = max(self.pixels.shape[:2]) / 700
        self.shown = max(self.pixels.shape[:2]) / SHOWN_PX

    def curve(
        self, x: ArrayLike, y: ArrayLike, colour: Colour, width: float = 1.5
    ) -> None:
        """A polyline; NaNs interrupt it. What lies far outside is drawn outside, and no
        number is lost by it."""
        points = np.column_stack([np.asarray(x, float), np.asarray(y, float)])
        keep = np.isfinite(points).all(axis=1)
        # sixteenths of a pixel
        own = 16 * ((np.where(keep[:, None], points, 0.0) + 0.5) * self.scale - 0.5)
        path = np.rint(np.clip(own, -16 * FAR_PX, 16 * FAR_PX)).astype(np.int32)
        thick = max(1, round(width * self.unit))
        for piece in np.split(np.arange(len(points)), np.flatnonzero(~keep)):
            piece = piece[keep[piece]]
            if piece.size > 1:
                pieces = [path[piece]]
                cv2.polylines(self.pixels, pieces, False, colour, thick, cv2.LINE_AA, 4)

    def line(
        self,
        x1: float,
        y1: float,
        x2: float,
        y2: float,
        colour: Colour,
        width: float = 2.0,
    ) -> None:
        self.curve([x1, x2], [y1, y2], colour, width)

    def dashed(
        self,
        x1: float,
        y1: float,
        x2: float,
        y2: float,
        colour: Colour,
        width: float = 1.5,
        dashes: int = 40,
    ) -> None:
        x, y = np.linspace(x1, x2, 3 * dashes), np.linspace(y1, y2, 3 * dashes)
        x[2::3] = np.nan
        self.curve(x, y, colour, width)

    def cross(
        self, x: float, y: float, colour: Colour, size: float = 5.0, width: float = 1.5
    ) -> None:
        r = size * self.unit / self.scale
        self.line(x - r, y, x + r, y, colour, width)
        self.line(x, y - r, x, y + r, colour, width)

    def polygon(self, points: np.ndarray, colour: Colour, width: float = 1.5) -> None:
        """A closed outline through points (n, 2)."""
        known = points[np.isfinite(points).all(axis=1)]
        closed = np.concatenate([known, known[:1]])
        self.curve(closed[:, 0], closed[:, 1], colour, width)

    def ring(
        self,
        x: float,
        y: float,
        colour: Colour,
        radius: float = 6.0,
        width: float = 2.0,
    ) -> None:
        turn = np.linspace(0, 2 * np.pi, 40)
        r = radius * self.unit / self.scale
        self.curve(x + r * np.cos(turn), y + r * np.sin(turn), colour, width)

    def tag(
        self, text: str, x: float, y: float, colour: Colour, most_px: float
    ) -> None:
        """Text centred at x, y, at most so high (px of the original), with a dark rim
        to be read on any ground."""
        size = min(self.shown, most_px * self.scale / LETTER_PX)
        at = (x + 0.5) * self.scale, (y + 0.5) * self.scale + 0.35 * LETTER_PX * size
        for ink, bold in (((0, 0, 0), 3.0), (colour, 1.0)):
            write(self.pixels, text, *at, ink, size, anchor=0.5, bold=bold)

    def legend(self, lines: list[tuple[str, Colour]]) -> None:
        """Text on a dark strip below the picture, beside a tall one, so that nothing
        found is hidden; long lines are wrapped."""
        high, wide = self.pixels.shape[:2]
        tall = high > TALL * wide
        strip_px = round(0.4 * high) if tall else wide
        margin, step = 8 * self.shown, LINE_PX * self.shown
        rows = [
            (part, colour)
            for text, colour in lines
            for part in wrapped(text, strip_px - 2 * margin, self.shown)
        ]
        needed = round(step * len(rows) + margin)
        strip = np.full((high if tall else needed, strip_px, 3), 30, np.uint8)
        for i, (text, colour) in enumerate(rows):
            baseline = (i + 1) * step - 0.2 * LETTER_PX * self.shown
            write(strip, text, margin, baseline, colour, self.shown)
        self.pixels = (
            np.hstack([self.pixels, strip]) if tall else np.vstack([self.pixels, strip])
        )


def write(
    image: np.ndarray,
    text: str,
    x: float,
    y: float,
    colour: Colour,
    shown: float,
    *,
    anchor: float = 0.0,
    bold: float = 1.0,
) -> None:
    """Text on the line y, in letters that are LETTER_PX high where `shown` pixels are
    shown as one; anchor: the share of its width that stands left of x."""
    at = (round(x - anchor * text_width(text, shown)), round(y))
    thickness = max(1, round(0.6 * bold * shown))
    cv2.putText(
        image, plain(text), at, FONT, _size(shown), colour, thickness, cv2.LINE_AA
    )


def text_width(text: str, shown: float) -> int:
    """Pixels that `write` takes for it."""
    return cv2.getTextSize(plain(text), FONT, _size(shown), max(1, round(0.6 * shown)))[
        0
    ][0]


def wrapped(text: str, room_px: float, shown: float) -> list[str]:
    """The text in lines that `write` fits into so many pixels."""
    letters = int(len(text) * room_px / max(text_width(text, shown), 1))
    return textwrap.wrap(text, max(letters, 12), subsequent_indent="  ") or [""]


def _size(shown: float) -> float:
    """OpenCV's scale: 1 has letters of 30 px."""
    return LETTER_PX * shown / 30


def _eight_bits(image: np.ndarray) -> np.ndarray:
    """uint8 for the eye: 16-bit pictures stretched to what they hold (a 12-bit camera
    fills a sixteenth of the range)."""
    if image.dtype == np.uint8:
        return image
    low, high = np.percentile(image[::4, ::4], (0.5, 99.5))
    return np.clip(
        (image.astype(np.float32) - low) / max(high - low, 1) * 255, 0, 255
    ).astype(np.uint8)


def plain(text: str) -> str:
    """The text in letters that this OpenCV has."""
    if not ASCII_ONLY:
        # half a surrogate pair, as in a folder's name that is no text, ends OpenCV
        return text.encode("utf8", "replace").decode()
    for mark, ascii_mark in ASCII.items():
        text = text.replace(mark, ascii_mark)
    return text.encode("ascii", "replace").decode()
