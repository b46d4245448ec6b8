"""What was followed, drawn: crosses on the seed in its own picture, fitted flights, plate; and plots for bare tracks."""

import cv2
import numpy as np

WIDEST = 1600  # px of an overlay
CROSS, BAD, CURVE, MARK, LINE = (0, 200, 255), (255, 60, 60), (255, 220, 0), (255, 0, 255), (0, 230, 90)
INK, GRID = (40, 40, 40), (225, 225, 225)
MOST_CROSSES = 160


def on_picture(pixels: np.ndarray, x, y, outlier, *, curves=(), marks=(), lines=(), caption: str = "") -> np.ndarray:
    """uint8 RGB. x, y: columns and rows [px] of the seed; curves: (columns, rows) polylines; marks: (column, row) points;
    lines: ((column, row), (column, row)) segments."""
    image, zoom = canvas(pixels)

    def place(column, row):
        return round((float(column) + 0.5) * zoom * 16 - 8), round((float(row) + 0.5) * zoom * 16 - 8)

    for start, end in lines:
        cv2.line(image, place(*start), place(*end), LINE, 1, cv2.LINE_AA, 4)
    for columns, rows in curves:
        points = np.array([place(c, r) for c, r in zip(columns, rows)], dtype=np.int32)
        cv2.polylines(image, [points], False, CURVE, 1, cv2.LINE_AA, 4)
    for i in _spread(np.asarray(x), np.asarray(y), np.asarray(outlier)):
        cv2.drawMarker(image, _whole(place(x[i], y[i])), BAD if outlier[i] else CROSS, cv2.MARKER_CROSS, 9, 1, cv2.LINE_AA)
    for column, row in marks:
        cv2.circle(image, place(column, row), 7 * 16, MARK, 2, cv2.LINE_AA, 4)
    return _captioned(image, caption)


def canvas(pixels: np.ndarray) -> tuple[np.ndarray, float]:
    """An 8-bit RGB copy of a frame, at most WIDEST wide (small ones enlarged 2 ×), and its zoom."""
    grey = pixels
    if grey.dtype != np.uint8:
        low, high = np.percentile(grey[::4, ::4], (0.5, 99.5))
        grey = np.clip((grey.astype(np.float32) - low) / max(high - low, 1) * 255, 0, 255).astype(np.uint8)
    image = np.repeat(grey[..., None], 3, axis=2) if grey.ndim == 2 else grey.copy()
    zoom = min(WIDEST / image.shape[1], 2.0 if image.shape[1] < 700 else 1.0)
    size = (round(image.shape[1] * zoom), round(image.shape[0] * zoom))
    return np.ascontiguousarray(cv2.resize(image, size, interpolation=cv2.INTER_AREA if zoom < 1 else cv2.INTER_LINEAR)), zoom


def plot(x, y, outlier, *, labels: tuple[str, str], curves=(), marks=(), caption: str = "", size=(1200, 700)) -> np.ndarray:
    """y against x as a picture: points, fitted curves (x, y), marked points. Drawn with OpenCV only."""
    wide, high = size
    left, right, top, bottom = 90, 20, 46, 60
    image = np.full((high, wide, 3), 255, np.uint8)
    x, y, outlier = np.asarray(x, float), np.asarray(y, float), np.asarray(outlier, bool)
    good = ~outlier if (~outlier).any() else np.ones(len(x), bool)
    (x0, x1), (y0, y1) = _range(x[good]), _range(y[good])

    def place(u, v):
        column = left + (np.asarray(u, float) - x0) / (x1 - x0) * (wide - left - right)
        row = high - bottom - (np.asarray(v, float) - y0) / (y1 - y0) * (high - top - bottom)
        return np.column_stack([np.clip(column, -4000, 8000), np.clip(row, -4000, 8000)])

    for value in ticks(x0, x1):
        at = round(float(place(value, y0)[0, 0]))
        cv2.line(image, (at, top), (at, high - bottom), GRID, 1)
        _text(image, f"{value:.6g}", (at - 18, high - bottom + 20))
    for value in ticks(y0, y1):
        at = round(float(place(x0, value)[0, 1]))
        cv2.line(image, (left, at), (wide - right, at), GRID, 1)
        _text(image, f"{value:.6g}", (14, at + 4))
    for i, (column, row) in enumerate(place(x, y)):
        centre = (round(column * 16), round(row * 16))
        if 0 <= column <= wide and 0 <= row <= high:
            cv2.circle(image, centre, 40, (255, 0, 0) if outlier[i] else (90, 140, 200), -1, cv2.LINE_AA, 4)
    for u, v in curves:
        cv2.polylines(image, [np.round(place(u, v) * 16).astype(np.int32)], False, (220, 120, 0), 2, cv2.LINE_AA, 4)
    for u, v in marks:
        column, row = place(u, v)[0]
        cv2.circle(image, (round(column * 16), round(row * 16)), 7 * 16, MARK, 2, cv2.LINE_AA, 4)
    cv2.rectangle(image, (left, top), (wide - right, high - bottom), INK, 1)
    _text(image, labels[0], (wide // 2 - 40, high - 14))
    _text(image, labels[1], (14, top - 10))
    return _captioned(image, caption, ink=INK)


def ticks(low: float, high: float) -> np.ndarray:
    """Round values between low and high, about six."""
    rough = (high - low) / 6
    power = 10 ** np.floor(np.log10(rough))
    step = min((s * power for s in (1, 2, 5, 10) if s * power >= rough), default=10 * power)
    return np.arange(np.ceil(low / step), np.floor(high / step) + 0.5) * step + 0.0


def _spread(x: np.ndarray, y: np.ndarray, outlier: np.ndarray) -> np.ndarray:
    """Rows to draw a cross for: MOST_CROSSES at most, evenly along the way; rests count once."""
    if len(x) <= MOST_CROSSES:
        return np.arange(len(x))
    way = np.concatenate([[0.0], np.cumsum(np.hypot(np.diff(x), np.diff(y)))])
    return np.unique(np.searchsorted(way, np.linspace(0, way[-1], MOST_CROSSES)).clip(0, len(x) - 1))


def _whole(place: tuple[int, int]) -> tuple[int, int]:
    return round(place[0] / 16), round(place[1] / 16)


def _range(values: np.ndarray) -> tuple[float, float]:
    low, high = float(values.min()), float(values.max())
    pad = 0.04 * (high - low) or 1.0
    return low - pad, high + pad


def _text(image: np.ndarray, text: str, at: tuple[int, int]) -> None:
    cv2.putText(image, text, at, cv2.FONT_HERSHEY_SIMPLEX, 0.45, INK, 1, cv2.LINE_AA)


def _captioned(image: np.ndarray, caption: str, ink=(255, 255, 255)) -> np.ndarray:
    """OpenCV's fonts know ASCII only; on a picture the text stands on a darkened strip."""
    plain = caption
    for mark, ascii_mark in (("±", "+/-"), ("°", " deg"), ("²", "2"), ("μ", "mu"), ("×", "x")):
        plain = plain.replace(mark, ascii_mark)
    plain = plain.encode("ascii", "replace").decode()
    if plain and ink != INK:
        image[:34] = (image[:34] * 0.3).astype(np.uint8)
    if plain:
        cv2.putText(image, plain, (10, 23), cv2.FONT_HERSHEY_SIMPLEX, 0.55, ink, 1, cv2.LINE_AA)
    return image
