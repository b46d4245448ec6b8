"""Priors of the usual heap, from simulated ones (benchmarks/pile_emulator.py),
widened."""

import numpy as np

from benchtwin.rigs.pile.effects.shapes import crest, middle, toe

CREST_MEAN, CREST_SD, CREST_WIDTH = -0.04, 0.03, 0.12
TOE_MEAN, TOE_SD, TOE_WIDTH = 0.05, 0.03, 0.1
TOE_IN_SEEDS = 0.6  # height of the toe over a seed's length
# further sd at crest and toe: a share of a seed's length; where seed or scale is not
# stated
SD_IN_SEEDS = 0.25
SD_UNKNOWN = 0.01
# sd along the flank, and a share of a seed's length more where that is known
FLANK_SD = 0.005
FLANK_IN_SEEDS = 0.05
# how far up an apron reaches, over the flank's way; of its height at the toe
TAILS = (0.07, 0.15, 0.3)
TAIL_SD = 0.03
BUMPS, BUMP_WIDTH = np.arange(-0.05, 1.46, 0.1), 0.1
COLUMNS = len(BUMPS) + len(TAILS)
PARTS = {
    "crest": crest,
    "toe": toe,
    "middle": middle,
}  # of a surface, what packings vary
PACKING_SD = {
    "crest": 0.02,
    "toe": 0.025,
    "middle": 0.01,
    "angle": 1.0,
}  # of one flank, before repeats say more; angle [deg]
PRIORS = {
    "repose": 20.0,  # deg: flat, since it is measured
    "lopsided": 0.4,  # deg: left and right flank of all heaps differ
    "settling": 0.1,  # deg: all heaps settle between photos
}
# Usual change for e times of a stated quantity: crest, toe [height], angle [deg]. That
# a heap is the flatter the faster its gate (18.4°, 12.3°, 10.4° at 10, 25, 50 mm/s) is
# what a gate's effect says, and no usual state.
NATURAL = {
    "gate_speed_mm_s": (0.01, 0.01, 0.5),
    "seed_mm": (0.02, 0.03, 1.5),
    "width_mm": (0.01, 0.01, 1.0),
    "photo_s": (0.005, 0.005, 0.3),
    "rig_mm": (0.02, 0.03, 1.5),  # as the seeds': how many seeds a heap is high
}


def straight(u: np.ndarray) -> np.ndarray:
    """The flank's line down to the plate, and the plate."""
    return np.maximum(1 - u, 0.0)


def mean(u: np.ndarray, seeds_high: float) -> np.ndarray:
    """Usual departure from the straight flank; seeds_high: height over a seed's length,
    or NaN."""
    height = TOE_IN_SEEDS / seeds_high if np.isfinite(seeds_high) else TOE_MEAN
    return CREST_MEAN * np.exp(-0.5 * (u / CREST_WIDTH) ** 2) + min(
        height, 0.2
    ) * np.exp(-np.abs(u - 1) / TOE_WIDTH)


def spread(u: np.ndarray, seeds_high: float) -> np.ndarray:
    """sd of a material's own departure from `mean`."""
    known = np.isfinite(seeds_high)
    more = min(SD_IN_SEEDS / seeds_high, 0.1) if known else SD_UNKNOWN
    flank = FLANK_SD + (FLANK_IN_SEEDS / seeds_high if known else 0.0)
    crest = (CREST_SD + more) * np.exp(-0.5 * (u / CREST_WIDTH) ** 2)
    return flank + crest + (TOE_SD + more) * np.exp(-np.abs(u - 1) / TOE_WIDTH)


def bumps(u: np.ndarray, seeds_high: float) -> np.ndarray:
    """Smooth columns (n, COLUMNS) whose sum has sd `spread`, and aprons at the toe."""
    shape = np.exp(-0.5 * ((u[:, None] - BUMPS) / BUMP_WIDTH) ** 2)
    smooth = (
        spread(u, seeds_high)[:, None]
        * shape
        / np.sqrt((shape**2).sum(1, keepdims=True))
    )
    return np.column_stack(
        [smooth, TAIL_SD * np.exp(-np.abs(u[:, None] - 1) / np.array(TAILS))]
    )
