"""Doubts about a film: whether the camera moved, and whether what was tracked is the
stated seed alone."""

import itertools
import math

import cv2
import numpy as np

from benchtwin.bench.language import tr
from benchtwin.vision.evidence.frames import FrameSource
from benchtwin.vision.motion.scene import grey
from benchtwin.vision.motion.track_seed import TrackedSeed, moving
from benchtwin.vision.recording import Recording

ROWS, COLUMNS = 4, 5  # tiles of the picture, whose shifts are measured
LARGEST_SIDE = 1280  # px of the picture that is compared
# least sd of a tile, grey levels of 255: the shift of a plain wall is unknown
TEXTURED = 3.0
# share of the textured tiles that must shift alike
LEAST_TILES = 4
AGREEING = 0.6
ALIKE_PX = 0.4
LEAST_SHIFT_PX = 0.7
# of an area: a silhouette is no ellipse, and blur and compression reduce it
AREA_MARGIN = 0.30
MOST_HIDDEN = 0.15  # share of the rows in motion that may be hidden or merged
LEAST_ROWS = 8


def camera_moved(source: FrameSource) -> str:
    """When and how far the camera moved, as a doubt; "" where it did not."""
    frames = source.spread()
    grey_frames = [
        grey(f.pixels) for f in frames if f.pixels.shape == frames[0].pixels.shape
    ]
    for k in range(len(grey_frames) - 1):
        shift = common_shift(grey_frames[k], grey_frames[k + 1])
        wider = [
            (k - 1, k + 1),
            (k, k + 2),
        ]  # something close to the lens shifts only one pair of frames
        lasts = any(
            a >= 0
            and b < len(grey_frames)
            and common_shift(grey_frames[a], grey_frames[b])
            for a, b in wider
        )
        if shift is not None and lasts:
            when = tr("between frames {} and {}", frames[k].index, frames[k + 1].index)
            return (
                f"the camera moved {when}: the whole picture shifts by"
                f" {np.hypot(*shift):.1f} px; cut the film there"
            )
    return ""


def common_shift(before: np.ndarray, after: np.ndarray) -> tuple[float, float] | None:
    """Shift (x, y) [px] on which most textured tiles of two grey pictures (h, w) agree;
    None where they do not, or it is small."""
    factor = max(1.0, max(before.shape) / LARGEST_SIDE)
    size = (round(before.shape[1] / factor), round(before.shape[0] / factor))
    one, other = (
        cv2.resize(p, size, interpolation=cv2.INTER_AREA) for p in (before, after)
    )
    bright = 255.0 / max(float(one.max()), 1.0)
    shifts = []
    for top, left in itertools.product(
        np.linspace(0, size[1], ROWS + 1)[:-1],
        np.linspace(0, size[0], COLUMNS + 1)[:-1],
    ):
        window = np.s_[
            int(top) : int(top + size[1] / ROWS),
            int(left) : int(left + size[0] / COLUMNS),
        ]
        a, b = (np.ascontiguousarray(p[window]) for p in (one, other))
        if (
            min(a.shape) >= 16
            and bright * min(float(a.std()), float(b.std())) > TEXTURED
        ):
            shifts.append(
                cv2.phaseCorrelate(
                    a, b, cv2.createHanningWindow(a.shape[::-1], cv2.CV_32F)
                )[0]
            )
    if len(shifts) < LEAST_TILES:
        return None
    found = factor * np.array(shifts)
    middle = np.median(found, axis=0)
    agreeing = (np.linalg.norm(found - middle, axis=1) < ALIKE_PX * factor).mean()
    moved = agreeing >= AGREEING and float(np.hypot(*middle)) > LEAST_SHIFT_PX * factor
    return (float(middle[0]), float(middle[1])) if moved else None


def size_doubt(
    tracked: TrackedSeed, recording: Recording, falling: bool = False
) -> str:
    """Why what was tracked may not be the seed alone; "" where nothing speaks against
    it. Areas are compared with the stated seed where axes and scale are stated, and
    those at rest with those in motion. falling: the seed falls and bounces."""
    track, area = tracked.track, tracked.areas
    in_motion = moving(track.x, track.y)
    if in_motion.sum() < LEAST_ROWS:
        return ""
    hidden = float(track.outlier[in_motion].mean())
    # places of a fall are compared with parabolas
    if hidden > MOST_HIDDEN and not falling:
        return tr(
            "the seed is partly hidden or merged with something in {:.0f} % of the"
            " frames in which it moves",
            100 * hidden,
        )
    clear = ~track.outlier & np.isfinite(area)  # a place set by hand has no silhouette
    if not (in_motion & clear).any():
        return ""
    typical = float(np.median(area[in_motion & clear]))
    least, most = stated_area_px(recording)
    if not least * (1 - AREA_MARGIN) < typical < most * (1 + AREA_MARGIN):
        side = (
            tr("at most {:.3g}", most)
            if typical > most
            else tr("at least {:.3g}", least)
        )
        return tr(
            "what moves covers {:.3g} px, the stated seed {}: a part of it, or more"
            " than it, was tracked",
            typical,
            side,
        )
    last = np.flatnonzero(in_motion)[-1]
    resting = ~in_motion & clear & (np.arange(len(area)) > last)
    # an oblong seed may show another side at rest
    turns = most / least if least > 0 else math.inf
    if resting.sum() >= LEAST_ROWS and not falling:
        ratio = float(np.median(area[resting])) / typical
        if not 1 / (turns * (1 + AREA_MARGIN)) < ratio < turns * (1 + AREA_MARGIN):
            return tr(
                "at rest what is tracked covers {:.2f} × what it covers in motion: it"
                " is not the seed alone",
                ratio,
            )
    return ""


def stated_area_px(recording: Recording) -> tuple[float, float]:
    """Least and greatest silhouette [px²] of the stated seed in any orientation; 0 and
    infinity where it is not stated."""
    scale, seed = recording.camera.mm_per_px, recording.seed
    axes = sorted(seed.sizes_mm)
    if not scale or len(axes) < 2 or seed.count not in (None, 1):
        return 0.0, math.inf
    least = math.pi / 4 * axes[0] * axes[1] / scale**2 if len(axes) == 3 else 0.0
    return least, math.pi / 4 * axes[-1] * axes[-2] / scale**2
