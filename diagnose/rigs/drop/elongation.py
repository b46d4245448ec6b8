"""Test whether contacts lie further from the centre than the stated sizes allow."""

import math
from dataclasses import dataclass

import numpy as np
from scipy import stats

from diagnose.effects.drop.shape_conversion import REACH, ROUGH
from diagnose.rigs.drop.impact_quantities import ImpactQuantities
from diagnose.rigs.drop.impacts import Impacts

CAP = 4.0  # sds at which one impact's offset is clipped
KICK_PER_ELONGATION, KICK_ROUGH = 0.7, 0.05  # sd of Δv_x/Δv_n where no spin is seen; 3-D ellipsoids have .55 of (a − c)/(a + c)


@dataclass(frozen=True)
class ElongationTest:
    """p: that chance puts contacts so far from the centre; elongation: as the contacts show it."""

    p: float
    elongation: float


def elongation_test(impacts: Impacts, seen: ImpactQuantities, elongation: float) -> ElongationTest:
    """From offsets where the spin is seen, else from kicks; p = 1 below 3 impacts."""
    radius, reach = impacts.seeds.radius[impacts.recording], impacts.seeds.reach[impacts.recording]
    known = np.isfinite(seen.offset) & np.isfinite(radius)
    if known.sum() >= 3:
        part = (seen.offset / np.hypot(REACH * reach + ROUGH * radius, seen.offset_sd))[known]
        part, freedom = part - np.median(part), int(known.sum()) - 1
    else:
        kicks = seen.kick[np.isfinite(seen.kick)]
        if len(kicks) < 3 or not np.isfinite(radius).all():
            return ElongationTest(1.0, elongation)
        part, freedom = (kicks - np.median(kicks)) / (KICK_PER_ELONGATION * elongation + KICK_ROUGH), len(kicks) - 1
    ratio = float((np.minimum(np.abs(part), CAP) ** 2).sum()) / freedom
    return ElongationTest(float(stats.chi2.sf(freedom * ratio, freedom)), elongation * math.sqrt(max(ratio, 1.0)))
