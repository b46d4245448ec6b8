"""Every seed that was found, with outline, number, length and width, drawn over its picture."""

import numpy as np

from vision.measurement import DOUBTFUL, FAILED, GOOD
from vision.overlay.canvas import WHITE, Canvas
from vision.overlay.scale import REGION, paint_scale, scale_words
from vision.paper.scale import Scale
from vision.shape.grains import Grain, Grains

COLOURS = {GOOD: (60, 255, 60), DOUBTFUL: (255, 190, 0), FAILED: (255, 60, 60)}


def draw_grains(image: np.ndarray, grains: Grains, paper: Scale | None = None) -> np.ndarray:
    """Overlay (uint8 RGB): seeds that count green, doubtful ones amber, what was left out red; numbers as in seeds.csv."""
    canvas = Canvas(image)
    paper = paper or (grains.scale if isinstance(grains.scale, Scale) else None)
    if paper is not None:
        paint_scale(canvas, paper)
    for number, grain in enumerate(grains.grains, 1):
        colour = COLOURS[grain.quality]
        canvas.polygon(grain.edge, colour, 1.0)
        if grain.quality != FAILED:
            for ends in _axes(grain):
                canvas.curve(ends[:, 0], ends[:, 1], colour, 0.5)
        canvas.tag(str(number), grain.x_px, grain.y_px, colour, 0.6 * grain.width_px)
    canvas.legend([*_words(grains), *([(scale_words(paper), REGION)] if paper is not None else [])])
    return canvas.pixels


def _words(grains: Grains):
    counts = {q: sum(g.quality == q for g in grains.grains) for q in COLOURS}
    yield ", ".join(f"{n} {q}" for q, n in counts.items()), WHITE
    for row in grains.distribution().itertuples():
        yield f"{row.quantity} {row.mean:.3g} {row.unit}, sd {row.sd:.2g}, {row.min:.3g} to {row.max:.3g}", WHITE


def _axes(grain: Grain) -> list[np.ndarray]:
    """The two corners that are a length apart, and the width across the middle."""
    turn = np.radians(grain.angle_deg)
    along = np.array([np.cos(turn), np.sin(turn)])
    across = np.array([-along[1], along[0]])
    place = grain.edge @ along
    middle = np.array([grain.x_px, grain.y_px])
    return [
        grain.edge[[place.argmin(), place.argmax()]],
        np.stack([middle - across * grain.width_px / 2, middle + across * grain.width_px / 2]),
    ]
