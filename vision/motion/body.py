"""The seed is a body of known and constant size: what was followed is doubted where it cannot be that body."""

import math

import numpy as np

from vision.motion.follow import Followed
from vision.recording import Recording

MARGIN = 0.30  # of an area: a silhouette is no ellipse, blur and compression take from its rim
MOST_ODD = 0.15  # share of the rows in motion that may be hidden or merged
STILL_PX = 0.3  # a step of less in a frame is rest
LEAST_ROWS = 8


def body_doubt(followed: Followed, recording: Recording) -> str:
    """Why what was followed may not be the seed alone, in words; "" where nothing says so.

    Seen areas are held against the stated seed where its axes and the scale are stated, against each other where they are not.
    """
    track, area = followed.track, followed.areas
    moving = np.hypot(np.gradient(track.x), np.gradient(track.y)) > STILL_PX
    if moving.sum() < LEAST_ROWS:
        return ""
    odd = float(track.outlier[moving].mean())
    if odd > MOST_ODD and recording.rig == "roll":  # a drop's places are held against parabolas
        return f"the seed is partly hidden or merged with something in {100 * odd:.0f} % of the frames in which it moves"
    seen = float(np.median(area[moving & ~track.outlier]))
    least, most = stated_area_px(recording)
    if not least * (1 - MARGIN) < seen < most * (1 + MARGIN):
        side = f"at most {most:.3g}" if seen > most else f"at least {least:.3g}"
        return f"what moves covers {seen:.3g} px, the stated seed {side}: a part of it, or more than it, was followed"
    resting = ~moving & ~track.outlier & (np.arange(len(area)) > np.flatnonzero(moving)[-1])
    turns = most / least if least > 0 else math.inf  # an oblong seed shows another side at rest
    if resting.sum() >= LEAST_ROWS and recording.rig == "roll":
        ratio = float(np.median(area[resting])) / seen
        if not 1 / (turns * (1 + MARGIN)) < ratio < turns * (1 + MARGIN):
            return f"at rest what is followed covers {ratio:.2f} × what it covers in motion: it is not the seed alone"
    return ""


def stated_area_px(recording: Recording) -> tuple[float, float]:
    """Least and greatest silhouette [px²] of the stated seed, over all ways it can lie; 0 and infinity where nobody said."""
    scale, seed = recording.camera.mm_per_px, recording.seed
    axes = sorted(a for a in (seed.length_mm, seed.width_mm, seed.thickness_mm) if a)
    if not scale or len(axes) < 2 or seed.count not in (None, 1):
        return 0.0, math.inf
    least = math.pi / 4 * axes[0] * axes[1] / scale**2 if len(axes) == 3 else 0.0
    return least, math.pi / 4 * axes[-1] * axes[-2] / scale**2
