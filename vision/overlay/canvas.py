"""What every overlay starts from: the picture as 8-bit RGB at a size to look at, lines, crosses and a legend that can be read."""

import cv2
import numpy as np

LONGEST_PX, SHORTEST_PX = 1600, 800
GREEN, RED, BLUE, YELLOW, WHITE = (0, 200, 60), (235, 50, 40), (60, 150, 255), (255, 210, 0), (255, 255, 255)


class Canvas:
    """A picture to draw on, in the coordinates (px, y down) of the original."""

    def __init__(self, image: np.ndarray):
        scale = 255.0 / np.iinfo(image.dtype).max if np.issubdtype(image.dtype, np.integer) else 1.0
        longest = max(image.shape[:2])
        self.scale = min(1.0, LONGEST_PX / longest) if longest > SHORTEST_PX else SHORTEST_PX / longest
        size = (max(1, round(image.shape[1] * self.scale)), max(1, round(image.shape[0] * self.scale)))
        how = cv2.INTER_AREA if self.scale < 1 else cv2.INTER_LINEAR
        small = cv2.resize(image, size, interpolation=how) if self.scale != 1 else image
        small = np.clip(small * scale, 0, 255).astype(np.uint8) if small.dtype != np.uint8 else small
        self.pixels = cv2.cvtColor(small, cv2.COLOR_GRAY2RGB) if small.ndim == 2 else small[..., :3].copy()
        self.unit = max(1.0, max(self.pixels.shape[:2]) / 900)

    def _at(self, x, y) -> tuple[int, int]:
        return round(((x + 0.5) * self.scale - 0.5) * 16), round(((y + 0.5) * self.scale - 0.5) * 16)

    def line(self, x1, y1, x2, y2, colour, width: float = 2.0) -> None:
        cv2.line(self.pixels, self._at(x1, y1), self._at(x2, y2), colour, max(1, round(width * self.unit)), cv2.LINE_AA, 4)

    def dashed(self, x1, y1, x2, y2, colour, width: float = 1.5, dashes: int = 40) -> None:
        at = np.linspace(0, 1, 2 * dashes)
        for a, b in zip(at[::2], at[1::2]):
            self.line(x1 + a * (x2 - x1), y1 + a * (y2 - y1), x1 + b * (x2 - x1), y1 + b * (y2 - y1), colour, width)

    def curve(self, x, y, colour, width: float = 1.5) -> None:
        """A polyline; NaNs interrupt it."""
        keep = np.isfinite(x) & np.isfinite(y)
        points = np.stack([(np.asarray(x) + 0.5) * self.scale - 0.5, (np.asarray(y) + 0.5) * self.scale - 0.5], axis=1)
        for piece in np.split(np.arange(len(points)), np.flatnonzero(~keep)):
            piece = piece[keep[piece]]
            if piece.size > 1:
                path = np.rint(points[piece] * 16).astype(np.int32)
                cv2.polylines(self.pixels, [path], False, colour, max(1, round(width * self.unit)), cv2.LINE_AA, 4)

    def cross(self, x, y, colour, size: float = 5.0, width: float = 1.5) -> None:
        r = size * self.unit / self.scale
        self.line(x - r, y, x + r, y, colour, width)
        self.line(x, y - r, x, y + r, colour, width)

    def legend(self, lines: list[tuple[str, tuple[int, int, int]]]) -> None:
        """Text on a dark strip below the picture, so that nothing found is hidden; long lines are wrapped."""
        font, size, thick = cv2.FONT_HERSHEY_SIMPLEX, 0.5 * self.unit, max(1, round(self.unit))
        room = max(20, int(self.pixels.shape[1] / (9.5 * self.unit)))
        rows = [(part, colour) for text, colour in lines for part in _wrapped(_plain(text), room)]
        step = round(20 * self.unit)
        strip = np.full((step * len(rows) + round(10 * self.unit), self.pixels.shape[1], 3), 30, np.uint8)
        for i, (text, colour) in enumerate(rows):
            place = (round(10 * self.unit), round((i + 1) * step - 4 * self.unit))
            cv2.putText(strip, text, place, font, size, colour, thick, cv2.LINE_AA)
        self.pixels = np.vstack([self.pixels, strip])


def _wrapped(text: str, room: int) -> list[str]:
    import textwrap

    return textwrap.wrap(text, room, subsequent_indent="   ") or [""]


def _plain(text: str) -> str:
    """OpenCV's letters are ASCII only."""
    for mark, plain in (("°", " deg"), ("±", "+/-"), ("–", "-"), ("−", "-"), ("×", "x"), ("√", "sqrt"), ("≤", "<="), ("μ", "mu")):
        text = text.replace(mark, plain)
    return text.encode("ascii", "replace").decode()
