"""y against x as a picture, for tracks and times that come without one: points, fitted
curves, marks."""

import warnings
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from benchtwin.vision.measurement import Quantity
from benchtwin.vision.motion.track import Track
from benchtwin.vision.overlay.canvas import LETTER_PX, SHOWN_PX

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Curve = tuple[np.ndarray, np.ndarray]
SAID = 2  # quantities in a caption
CURVE, MARK, POINT, BAD = "#dc7800", "#ff00ff", "#5a8cc8", "#ff0000"


def new_figure(size: tuple[int, int]) -> "Figure":
    """An empty figure of width and height [px], whose letters are LETTER_PX high where
    its longer side is shown with SHOWN_PX."""
    from matplotlib.figure import Figure  # loads for .4 s

    dpi = 72 * max(size) / SHOWN_PX  # a point as shown is a pixel
    wide, high = size
    return Figure((wide / dpi, high / dpi), dpi=dpi, layout="constrained")


def as_pixels(figure: "Figure") -> np.ndarray:
    """The figure as uint8 RGB; words are shown as they are, without formulas."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.text import Text

    for text in figure.findobj(Text):
        words = text.get_text().encode("utf8", "replace").decode()
        text.set(fontsize=LETTER_PX, parse_math=False, text=words)
    canvas = FigureCanvasAgg(figure)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # letters that the font has not
        canvas.draw()
    return np.asarray(canvas.buffer_rgba())[..., :3].copy()


def plot(
    x: ArrayLike,
    y: ArrayLike,
    outlier: ArrayLike,
    *,
    labels: tuple[str, str],
    curves: Sequence[tuple[ArrayLike, ArrayLike]] = (),
    marks: Sequence[tuple[float, float]] = (),
    caption: str = "",
    size: tuple[int, int] = (960, 620),
) -> np.ndarray:
    """y against x as a picture: points, fitted curves (x, y), marked points. Outliers
    are seen where they lie near the others."""
    x, y, bad = np.asarray(x, float), np.asarray(y, float), np.asarray(outlier, bool)
    bad = bad if not bad.all() else ~bad
    figure = new_figure(size)
    axes = figure.subplots()
    axes.plot(x[~bad], y[~bad], "o", color=POINT, markersize=4)
    axes.set_ylim(axes.get_ylim())  # and no more by what is drawn later
    for u, v in curves:
        axes.plot(u, v, color=CURVE, linewidth=1)
    axes.set_xlim(axes.get_xlim())
    axes.plot(x[bad], y[bad], "o", color=BAD, markersize=4)
    for at in marks:
        axes.plot(*at, "o", color=MARK, markersize=10, fillstyle="none")
    axes.grid(color="#e1e1e1")
    axes.set(xlabel=labels[0], ylabel=labels[1])
    figure.suptitle(caption, x=0.01, horizontalalignment="left", wrap=True)
    return as_pixels(figure)


def caption(quantities: Sequence[Quantity]) -> str:
    """The first quantities in words."""
    known = [q for q in quantities if np.isfinite(q.value)]
    said = "; ".join(q.in_words for q in known[:SAID])
    return said or "nothing could be measured"


def plot_travel(
    track: Track,
    fitted: Curve | None,
    at: float | None,
    quantities: Sequence[Quantity],
    place: float | None = None,
) -> np.ndarray:
    """A track's x against time with the fitted curve (time, x), marked at a time and
    at a place."""
    marks = []
    if fitted is not None and at is not None:
        marks.append((at, float(np.interp(at, *fitted))))
    if fitted is not None and place is not None:
        marks.append((float(fitted[0][np.argmin(np.abs(fitted[1] - place))]), place))
    return plot(
        track.time,
        track.x,
        track.outlier,
        labels=(f"t [{track.time_unit}]", f"travel [{track.unit}]"),
        curves=[] if fitted is None else [fitted],
        marks=marks,
        caption=caption(quantities),
    )
