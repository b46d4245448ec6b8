"""Windows of a heap: a surface higher or lower in one stretch of the flanks only, by place."""

import numpy as np

from calibrate.diagnose.locate import Windows
from calibrate.diagnose.problem import Fit

WIDTH = 0.2


def windows_of(fit: Fit) -> Windows:
    """Hats of `WIDTH` of the flank's way, half over each other; places from the crest outwards, in the photos' unit."""
    photos = fit.problem.model.photos
    flanks = [f for p in photos for f in p.flanks]
    one_unit = len({p.unit for p in photos}) == 1 and photos[0].unit == "mm"
    length = float(np.mean([f.length for f in flanks])) if one_unit else 1.0
    axis = "x_mm" if one_unit else "x_share"
    middles = np.arange(WIDTH / 2, max(f.u[-1] for f in flanks), WIDTH / 2)
    extra = []
    for r, p in enumerate(photos):
        columns = np.zeros((len(fit.problem.model.base[r]), len(middles)))
        row = 0
        for f in p.flanks:
            columns[row : row + len(f.u)] = np.maximum(1 - np.abs(f.u[:, None] - middles) / (WIDTH / 2), 0)
            row += len(f.u)
        extra.append(columns)
    return Windows(extra, tuple((axis, float(length * (m - WIDTH / 2)), float(length * (m + WIDTH / 2))) for m in middles))
