"""Priors of the usual heap.

One that leans on a wall is as simulated ones are (benchmarks/pile_emulator.py). One
with a free crest has stated numbers, from a few simulated heaps of soybeans of five
spheres under a lifted cylinder, widened: single spheres leave a layer there."""

from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np
import pandas as pd
from scipy.interpolate import CubicSpline

from benchtwin.rigs.pile.effects.shapes import crest, middle, toe

TABLE = Path(__file__).with_name("usual_heaps.csv")
# of the table's sds: real walls, gates and seeds differ by more than drawn ones
DOUBT = 1.5
# seeds per height of a heap whose seed or scale is not stated: mean and sd
PER_HEIGHT, PER_HEIGHT_SD = 0.1, 0.05
# smooth departures of any shape beside the others, which no drawn heap had: their sd,
# and as a share of the others' sd
BUMPS, BUMP_WIDTH = np.arange(-0.05, 1.46, 0.1), 0.1
BUMP_SD, BUMP_SHARE = 0.01, 0.2
# a free crest: mean, sd, width; the toe's height over a seed's length; sd along it
AT = np.arange(0.0, 1.41, 0.025)  # of the flank's way
CREST_MEAN, CREST_SD, CREST_WIDTH = -0.04, 0.055, 0.12
TOE_IN_SEEDS, TOE_SD, TOE_WIDTH = 0.6, 0.055, 0.1
FLANK_SD = 0.01
# how far up an apron reaches, over the flank's way; of its height at the toe
TAILS = (0.07, 0.15, 0.3)
TAIL_SD = 0.03
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


@dataclass(frozen=True, eq=False)
class Usual:
    """Departure from the straight flank at places `at` (m,): a mean, which goes with
    seeds per height and with the angle, and components (m, k), each times its sd."""

    at: np.ndarray
    flat: np.ndarray
    per_seed: np.ndarray
    per_deg: np.ndarray
    components: np.ndarray

    def mean(self, u: np.ndarray, seeds_high: float, angle_deg: float) -> np.ndarray:
        """(n,) at u; seeds_high: height over a seed's length, or NaN."""
        per_height = 1 / seeds_high if np.isfinite(seeds_high) else PER_HEIGHT
        whole = self.flat + per_height * self.per_seed + angle_deg * self.per_deg
        return self._curve(whole, u)

    def steeper(self, u: np.ndarray) -> np.ndarray:
        """How the mean (n,) changes with the angle [1/deg]."""
        return self._curve(self.per_deg, u)

    def columns(self, u: np.ndarray, seeds_high: float) -> np.ndarray:
        """(n, k) whose sum, each times a standard normal number, is how usual heaps
        depart from `mean`."""
        doubt = 0.0 if np.isfinite(seeds_high) else PER_HEIGHT_SD
        at = np.column_stack([self.components, doubt * self.per_seed])
        own = self._curve(at, u)
        any_shape = BUMP_SD + BUMP_SHARE * np.linalg.norm(own, axis=1)
        aprons = TAIL_SD * np.exp(-np.abs(u[:, None] - 1) / np.array(TAILS))
        return np.column_stack([own, _smooth(u, any_shape), aprons])

    def _curve(self, values: np.ndarray, u: np.ndarray) -> np.ndarray:
        """Values (m, …) at `at`, as a smooth curve at u (n, …)."""
        return CubicSpline(self.at, values)(np.clip(u, self.at[0], self.at[-1]))

    def spread(self, u: np.ndarray, seeds_high: float) -> np.ndarray:
        """sd (n,) of that."""
        return np.linalg.norm(self.columns(u, seeds_high), axis=1)


def at_a_wall(table: pd.DataFrame) -> Usual:
    """Heaps with one flank, as the table's are."""
    columns = (table[n].to_numpy() for n in ("u", "flat", "per_seed", "per_deg"))
    return Usual(*columns, DOUBT * table.filter(like="mode_").to_numpy())


@cache
def usual(flanks: int) -> Usual:
    """Heaps with one flank, at a wall, or two."""
    if flanks == 1:
        return at_a_wall(pd.read_csv(TABLE))
    crests = np.exp(-0.5 * (AT / CREST_WIDTH) ** 2)
    toes = np.exp(-np.abs(AT - 1) / TOE_WIDTH)
    sd = FLANK_SD + CREST_SD * crests + TOE_SD * toes
    means = CREST_MEAN * crests, TOE_IN_SEEDS * toes, 0.0 * AT
    return Usual(AT, *means, _smooth(AT, sd))


def _smooth(u: np.ndarray, sd: np.ndarray) -> np.ndarray:
    """Bumps (n, k) whose sum has this sd (n,)."""
    shape = np.exp(-0.5 * ((u[:, None] - BUMPS) / BUMP_WIDTH) ** 2)
    return sd[:, None] * shape / np.linalg.norm(shape, axis=1)[:, None]
