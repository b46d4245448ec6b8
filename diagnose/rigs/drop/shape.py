"""Is a seed much less round than stated? Its contacts lie further beside the centre than the stated axes reach."""

import math
from dataclasses import dataclass

import numpy as np
from scipy import stats

from diagnose.effects.drop.shape_conversion import REACH, ROUGH
from diagnose.rigs.drop.bounce import Bounces
from diagnose.rigs.drop.impacts import Impacts

CAP = 4.0  # sd beyond which one impact counts for no more: a seed that rocks touches twice
KICK_PER_ELONGATION, KICK_ROUGH = 0.7, 0.05  # sd of Δv_x/Δv_n where no spin is seen; 3-D ellipsoids have .55 of (a − c)/(a + c)


@dataclass(frozen=True)
class Shape:
    """p: of contacts as far beside the centre by chance; elongation as the contacts have it."""

    p: float
    elongation: float


def shape_of(impacts: Impacts, seen: Bounces, elongation: float) -> Shape:
    """From b where the spin is seen, else from the scatter of the kicks; p = 1 with fewer than three impacts."""
    radius, reach = impacts.seeds.radius[impacts.recording], impacts.seeds.reach[impacts.recording]
    known = np.isfinite(seen.offset) & np.isfinite(radius)
    if known.sum() >= 3:
        part = (seen.offset / np.hypot(REACH * reach + ROUGH * radius, seen.offset_sd))[known]
        part, freedom = part - np.median(part), int(known.sum()) - 1
    else:
        kicks = seen.kick[np.isfinite(seen.kick)]
        if len(kicks) < 3 or not np.isfinite(radius).all():
            return Shape(1.0, elongation)
        part, freedom = (kicks - np.median(kicks)) / (KICK_PER_ELONGATION * elongation + KICK_ROUGH), len(kicks) - 1
    ratio = float((np.minimum(np.abs(part), CAP) ** 2).sum()) / freedom
    return Shape(float(stats.chi2.sf(freedom * ratio, freedom)), elongation * math.sqrt(max(ratio, 1.0)))
