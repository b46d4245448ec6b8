"""What every overlay starts from: the picture as 8-bit RGB at a size to look at, lines, crosses and a legend that can be read."""

import cv2
import numpy as np

LONGEST_PX, SHORTEST_PX = 1600, 800
FONT = cv2.FONT_HERSHEY_SIMPLEX
ASCII = {"°": " deg", "±": "+/-", "–": "-", "−": "-", "×": "x", "√": "sqrt", "≤": "<=", "μ": "mu", "²": "2"}
GREEN, RED, BLUE, YELLOW, WHITE = (0, 200, 60), (235, 50, 40), (60, 150, 255), (255, 210, 0), (255, 255, 255)
Colour = tuple[int, int, int]  # red, green, blue


class Canvas:
    """A picture to draw on, in the coordinates (px, y down) of the original."""

    def __init__(self, image: np.ndarray):
        longest = max(image.shape[:2])
        self.scale = min(1.0, LONGEST_PX / longest) if longest > SHORTEST_PX else SHORTEST_PX / longest
        size = (max(1, round(image.shape[1] * self.scale)), max(1, round(image.shape[0] * self.scale)))
        how = cv2.INTER_AREA if self.scale < 1 else cv2.INTER_LINEAR
        small = _eight_bits(cv2.resize(image, size, interpolation=how) if self.scale != 1 else image)
        self.pixels = cv2.cvtColor(small, cv2.COLOR_GRAY2RGB) if small.ndim == 2 else small[..., :3].copy()
        self.unit = max(1.0, max(self.pixels.shape[:2]) / 900)

    def _at(self, x, y) -> tuple[int, int]:
        return round(((x + 0.5) * self.scale - 0.5) * 16), round(((y + 0.5) * self.scale - 0.5) * 16)

    def line(self, x1: float, y1: float, x2: float, y2: float, colour: Colour, width: float = 2.0) -> None:
        cv2.line(self.pixels, self._at(x1, y1), self._at(x2, y2), colour, max(1, round(width * self.unit)), cv2.LINE_AA, 4)

    def dashed(
        self, x1: float, y1: float, x2: float, y2: float, colour: Colour, width: float = 1.5, dashes: int = 40
    ) -> None:
        at = np.linspace(0, 1, 2 * dashes)
        for a, b in zip(at[::2], at[1::2]):
            self.line(x1 + a * (x2 - x1), y1 + a * (y2 - y1), x1 + b * (x2 - x1), y1 + b * (y2 - y1), colour, width)

    def curve(self, x: np.ndarray, y: np.ndarray, colour: Colour, width: float = 1.5) -> None:
        """A polyline; NaNs interrupt it."""
        keep = np.isfinite(x) & np.isfinite(y)
        points = np.stack([(np.asarray(x) + 0.5) * self.scale - 0.5, (np.asarray(y) + 0.5) * self.scale - 0.5], axis=1)
        for piece in np.split(np.arange(len(points)), np.flatnonzero(~keep)):
            piece = piece[keep[piece]]
            if piece.size > 1:
                path = np.rint(points[piece] * 16).astype(np.int32)
                cv2.polylines(self.pixels, [path], False, colour, max(1, round(width * self.unit)), cv2.LINE_AA, 4)

    def cross(self, x: float, y: float, colour: Colour, size: float = 5.0, width: float = 1.5) -> None:
        r = size * self.unit / self.scale
        self.line(x - r, y, x + r, y, colour, width)
        self.line(x, y - r, x, y + r, colour, width)

    def polygon(self, points: np.ndarray, colour: Colour, width: float = 1.5) -> None:
        """A closed outline through points (n, 2)."""
        path = np.rint(((np.asarray(points, float) + 0.5) * self.scale - 0.5) * 16).astype(np.int32)
        cv2.polylines(self.pixels, [path], True, colour, max(1, round(width * self.unit)), cv2.LINE_AA, 4)

    def ring(self, x: float, y: float, colour: Colour, radius: float = 6.0, width: float = 2.0) -> None:
        cv2.circle(self.pixels, self._at(x, y), round(radius * self.unit * 16), colour, round(width * self.unit), cv2.LINE_AA, 4)

    def tag(self, text: str, x: float, y: float, colour: Colour, size: float = 0.45) -> None:
        """Text centred at x, y, with a dark rim so that it can be read on any ground."""
        size *= self.unit
        (wide, high), _ = cv2.getTextSize(text, FONT, size, 1)
        at = (round((x + 0.5) * self.scale - wide / 2), round((y + 0.5) * self.scale + high / 2))
        for ink, thick in (((0, 0, 0), 3.0), (colour, 1.0)):
            cv2.putText(self.pixels, plain(text), at, FONT, size, ink, max(1, round(thick * self.unit)), cv2.LINE_AA)

    def legend(self, lines: list[tuple[str, Colour]]) -> None:
        """Text on a dark strip below the picture, so that nothing found is hidden; long lines are wrapped."""
        size, thick = 0.5 * self.unit, max(1, round(self.unit))
        room = max(20, int(self.pixels.shape[1] / (9.5 * self.unit)))
        rows = [(part, colour) for text, colour in lines for part in _wrapped(plain(text), room)]
        step = round(20 * self.unit)
        strip = np.full((step * len(rows) + round(10 * self.unit), self.pixels.shape[1], 3), 30, np.uint8)
        for i, (text, colour) in enumerate(rows):
            place = (round(10 * self.unit), round((i + 1) * step - 4 * self.unit))
            cv2.putText(strip, text, place, FONT, size, colour, thick, cv2.LINE_AA)
        self.pixels = np.vstack([self.pixels, strip])


def _eight_bits(image: np.ndarray) -> np.ndarray:
    """uint8 for the eye: 16-bit pictures stretched to what they hold (a 12-bit camera fills a sixteenth of the range)."""
    if image.dtype == np.uint8:
        return image
    low, high = np.percentile(image[::4, ::4], (0.5, 99.5))
    return np.clip((image.astype(np.float32) - low) / max(high - low, 1) * 255, 0, 255).astype(np.uint8)


def _wrapped(text: str, room: int) -> list[str]:
    import textwrap

    return textwrap.wrap(text, room, subsequent_indent="   ") or [""]


def plain(text: str) -> str:
    """OpenCV's letters are ASCII only."""
    for mark, ascii_mark in ASCII.items():
        text = text.replace(mark, ascii_mark)
    return text.encode("ascii", "replace").decode()
