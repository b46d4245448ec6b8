"""Checks the size of the tracked silhouettes against the stated seed, and their constancy."""

import math

import numpy as np

from vision.motion.track_seed import TrackedSeed
from vision.recording import Recording

MARGIN = 0.30  # of an area: a silhouette is no ellipse, and blur and compression reduce it
MOST_OUTLIERS = 0.15  # share of the rows in motion that may be hidden or merged
RESTING_PX = 0.3  # a smaller step from frame to frame is rest
LEAST_ROWS = 8


def size_doubt(tracked: TrackedSeed, recording: Recording) -> str:
    """Why what was tracked may not be the seed alone; "" where nothing speaks against it.

    Areas are compared with the stated seed where axes and scale are stated, and those at rest with those in motion.
    """
    track, area = tracked.track, tracked.areas
    moving = np.hypot(np.gradient(track.x), np.gradient(track.y)) > RESTING_PX
    if moving.sum() < LEAST_ROWS:
        return ""
    hidden = float(track.outlier[moving].mean())
    if hidden > MOST_OUTLIERS and recording.rig == "roll":  # a drop's places are compared with parabolas
        return f"the seed is partly hidden or merged with something in {100 * hidden:.0f} % of the frames in which it moves"
    seen = float(np.median(area[moving & ~track.outlier]))
    least, most = stated_area_px(recording)
    if not least * (1 - MARGIN) < seen < most * (1 + MARGIN):
        side = f"at most {most:.3g}" if seen > most else f"at least {least:.3g}"
        return f"what moves covers {seen:.3g} px, the stated seed {side}: a part of it, or more than it, was tracked"
    resting = ~moving & ~track.outlier & (np.arange(len(area)) > np.flatnonzero(moving)[-1])
    turns = most / least if least > 0 else math.inf  # an oblong seed may show another side at rest
    if resting.sum() >= LEAST_ROWS and recording.rig == "roll":
        ratio = float(np.median(area[resting])) / seen
        if not 1 / (turns * (1 + MARGIN)) < ratio < turns * (1 + MARGIN):
            return f"at rest what is tracked covers {ratio:.2f} × what it covers in motion: it is not the seed alone"
    return ""


def stated_area_px(recording: Recording) -> tuple[float, float]:
    """Least and greatest silhouette [px²] of the stated seed in any orientation; 0 and infinity where it is not stated."""
    scale, seed = recording.camera.mm_per_px, recording.seed
    axes = sorted(a for a in (seed.length_mm, seed.width_mm, seed.thickness_mm) if a)
    if not scale or len(axes) < 2 or seed.count not in (None, 1):
        return 0.0, math.inf
    least = math.pi / 4 * axes[0] * axes[1] / scale**2 if len(axes) == 3 else 0.0
    return least, math.pi / 4 * axes[-1] * axes[-2] / scale**2
