"""What every overlay starts from: the picture as 8-bit RGB at a size to look at, lines,
crosses and a legend that can be read."""

import textwrap
from collections.abc import Iterable
from contextlib import suppress
from functools import cache

import cv2
import numpy as np
from numpy.typing import ArrayLike
from PIL import Image, ImageDraw, ImageFont

from benchtwin.bench.language import ENGLISH, spoken

FAR_PX = 1e6  # from the picture, where what is drawn is not seen
LONGEST_PX, SHORTEST_PX = 1600, 800
# the longest side at which overlays/index.html and report.html show a picture
SHOWN_PX = 480
# there: size of the letters, from one line of text to the next
LETTER_PX = 13
LINE_PX = 18
TALL = 1.3  # height over width beyond which the legend stands beside the picture
GREEN = (0, 200, 60)
RED = (235, 50, 40)
BLUE = (60, 150, 255)
YELLOW = (255, 210, 0)
WHITE = (255, 255, 255)
Colour = tuple[int, int, int]  # red, green, blue
FONTS = {  # of systems, by language: those whose letters are none of matplotlib's
    "zh": (
        *("Microsoft YaHei", "PingFang SC", "Noto Sans CJK SC", "Source Han Sans SC"),
        *("WenQuanYi Micro Hei", "WenQuanYi Zen Hei", "SimHei", "SimSun"),
    )
}
IDEOGRAPHS = "\u2e80"  # and what comes behind them in Unicode
NO_FONT = "[no font for this language on this system: see the tables]"


class Canvas:
    """A picture to draw on, in the coordinates (px, y down) of the original."""

    def __init__(self, image: np.ndarray):
        longest = max(image.shape[:2])
        self.scale = float(np.clip(1.0, SHORTEST_PX / longest, LONGEST_PX / longest))
        high, wide = (max(1, round(n * self.scale)) for n in image.shape[:2])
        way = cv2.INTER_AREA if self.scale < 1 else cv2.INTER_LINEAR
        small = _eight_bits(cv2.resize(image, (wide, high), interpolation=way))
        small = np.atleast_3d(small)
        self.pixels = np.repeat(small, 3, 2) if small.shape[2] < 3 else small[..., :3]
        self.pixels = np.ascontiguousarray(self.pixels)
        self.unit = max(high, wide) / 700
        self.shown = max(high, wide) / SHOWN_PX

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

    def cross(
        self, x: float, y: float, colour: Colour, size: float = 5.0, width: float = 1.5
    ) -> None:
        r = size * self.unit / self.scale
        self.curve([x - r, x + r, np.nan, x, x], [y, y, y, y - r, y + r], colour, width)

    def polygon(self, points: np.ndarray, colour: Colour, width: float = 1.5) -> None:
        """A closed outline through points (n, 2)."""
        self.curve(*np.concatenate([points, points[:1]]).T, colour, width)

    def ring(self, x: float, y: float, colour: Colour) -> None:
        turn = np.linspace(0, 2 * np.pi, 40)
        around = np.column_stack([np.cos(turn), np.sin(turn)])
        self.polygon([x, y] + 6 * self.unit / self.scale * around, colour, 2.0)

    def tags(self, texts: Iterable[tuple[str, float, float, Colour, float]]) -> None:
        """Texts centred at x, y, each in a colour and at most so high (px of the
        original), with a dark rim to be read on any ground."""
        placed = []
        for text, x, y, colour, most_px in texts:
            size = min(self.shown, most_px * self.scale / LETTER_PX)
            middle = (x + 0.5) * self.scale, (y + 0.5) * self.scale
            placed.append((middle, text, colour, letters(size)))
        rim = {"stroke_width": max(1, round(self.shown)), "stroke_fill": (0, 0, 0)}
        self.pixels = _with_texts(self.pixels, placed, anchor="mm", **rim)

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
        high_up = step - 0.2 * LETTER_PX * self.shown
        placed = [
            ((margin, i * step + high_up), text, colour, letters(self.shown))
            for i, (text, colour) in enumerate(rows)
        ]
        strip = _with_texts(strip, placed, anchor="ls")
        stacked = np.hstack if tall else np.vstack
        self.pixels = stacked([self.pixels, strip])


@cache
def font_file(language: str) -> str:
    """The file of a font with the letters of a language; "" where there is none."""
    from matplotlib import font_manager, get_data_path  # loads for .2 s

    for family in FONTS.get(language, ()):
        with suppress(ValueError):
            return font_manager.findfont(family, fallback_to_default=False)
    return "" if language in FONTS else f"{get_data_path()}/fonts/ttf/DejaVuSans.ttf"


def letters(shown: float) -> ImageFont.FreeTypeFont:
    """Letters that are LETTER_PX high where `shown` pixels are shown as one."""
    return _letters(font_file(spoken()) or font_file(ENGLISH), shown)


@cache
def _letters(file: str, shown: float) -> ImageFont.FreeTypeFont:
    return ImageFont.truetype(file, max(LETTER_PX * shown, 1.0))


def wrapped(text: str, room_px: float, shown: float) -> list[str]:
    """The text in lines that fit into so many pixels; NO_FONT in the place of one whose
    letters no font here has."""
    text = text.encode("utf8", "replace").decode()  # a folder's name may be no text
    if any(c >= IDEOGRAPHS for c in text) and not font_file(spoken()):
        text = NO_FONT
    count = int(len(text) * room_px / max(letters(shown).getlength(text), 1))
    return textwrap.wrap(text, max(count, 12), subsequent_indent="  ") or [""]


def _with_texts(image: np.ndarray, placed: Iterable[tuple], **how) -> np.ndarray:
    """The picture (uint8 RGB) with texts: place of each, words, colour, letters."""
    drawn = Image.fromarray(image)
    pen = ImageDraw.Draw(drawn)
    for text in placed:
        pen.text(*text, **how)
    return np.array(drawn)


def _eight_bits(image: np.ndarray) -> np.ndarray:
    """uint8 for the eye: 16-bit pictures stretched to what they hold (a 12-bit camera
    fills a sixteenth of the range)."""
    if image.dtype == np.uint8:
        return image
    low, high = np.percentile(image[::4, ::4], (0.5, 99.5))
    return np.clip(
        (image.astype(np.float32) - low) / max(high - low, 1) * 255, 0, 255
    ).astype(np.uint8)
