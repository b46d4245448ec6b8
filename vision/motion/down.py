"""Which way a seed falls in a picture: down, unless the picture lies on its side or the
camera was held askew."""

from dataclasses import replace

import numpy as np

from benchtwin.bench.language import tr
from benchtwin.vision.foreign.unit_inference import LARGEST_MISFIT, parabolas_in
from benchtwin.vision.motion.track import Track
from benchtwin.vision.recording import Recording

LEAST_ROWS = 16
# by which a fall turns from the plumb line before that is said; a camera that is rolled
# by less is fitted, and is what a diagnosis may name (`camera-roll`)
TURNED_DEG, TURNED_SDS = 10.0, 5.0
# to which air that slows what is thrown across a picture turns its fall, against its
# motion; in a picture that is turned it falls along with it
MOST_SLOWED_DEG = 60.0
# windows that agree with the best: relative, of the acceleration's vector
ALIKE = 0.1
LEAST_SHARE = 0.5  # of the worth of all parabolas, that of those which agree


def direction_of_fall(
    time: np.ndarray, x: np.ndarray, y: np.ndarray
) -> tuple[float, float] | None:
    """The direction [deg, clockwise from straight down] in which most of what flies in
    a track accelerates, y up, and its sd; None where nothing does, or not in one."""
    w = parabolas_in(time, x, y)
    sagitta, misfit = np.hypot(w.sx, w.sy), np.hypot(w.mx, w.my)
    w = w.assign(worth=sagitta - misfit / LARGEST_MISFIT)
    # of a parabola's bend, n rows of sd σ over a span of 1: σ √(180/n)
    w = w.assign(sd=np.degrees(misfit * np.sqrt(180 / w.rows) / (4 * sagitta)))
    if (w := w[w.worth > 0]).empty:
        return None
    best = w.loc[w.worth.idxmax()]
    off = np.hypot(w.ax - best.ax, w.ay - best.ay)
    alike = w[off < ALIKE * np.hypot(best.ax, best.ay)]
    if alike.worth.sum() < LEAST_SHARE * w.worth.sum():
        return None
    mean = alike.worth @ alike[["ax", "ay"]]
    return float(np.degrees(np.arctan2(-mean.ax, -mean.ay))), float(alike.sd.min())


def upright(track: Track, recording: Recording) -> tuple[Recording, tuple[str, ...]]:
    """The recording with the direction in which its seed falls as plumb line, where
    none is stated and it is not down; and a note on that, or on what is stated."""
    used, camera = track.used(), recording.camera
    if len(used) < LEAST_ROWS or not np.ptp(used.x):
        return recording, ()
    if (fall := direction_of_fall(used.time, used.x, used.y)) is None:
        return recording, ()
    deg, sd = fall
    off = abs((deg - (camera.plumb_deg or 0.0) + 180) % 360 - 180)
    across = float(used.x[-1] - used.x[0])  # a pull to the left is clockwise
    slowed = abs(deg) < MOST_SLOWED_DEG and deg * across > 0
    if slowed or off < max(TURNED_DEG, TURNED_SDS * sd):
        return recording, ()
    way = tr("clockwise") if deg > 0 else tr("anticlockwise")
    said = tr(
        "the seed falls {:.1f}° {} from straight down in the picture", abs(deg), way
    )
    if camera.plumb_deg is not None:
        return recording, (
            tr("{}; [camera] plumb_deg = {:g} is used", said, camera.plumb_deg),
        )
    turned = camera.model_copy(update={"plumb_deg": round(deg, 1)})
    note = tr("{} (turned, or held askew): heights are read along its fall", said)
    return replace(recording, camera=turned), (note,)
