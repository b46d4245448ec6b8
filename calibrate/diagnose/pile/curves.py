"""What a report draws of heaps: each flank's surface, and what the usual heap and the verdict's model leave of it."""

import numpy as np

from calibrate.diagnose.finding import Curve
from calibrate.diagnose.problem import Fit

SIDES = {-1: "left flank", 1: "right flank"}


def curves_of(before: Fit, after: Fit) -> tuple[Curve, ...]:
    """One curve a flank: height above the plate, from the crest outwards, in mm or, without a scale, in px.

    What is the photo's own (position, size, angle, packing) is taken away from both.
    """
    out = []
    for r, photo in enumerate(before.problem.model.photos):
        left = []
        for of in (before, after):
            left.append(of.problem.model.predict(r, of.starts[r], of.by_name))
        row = 0
        for f in photo.flanks:
            rows = slice(row, row + len(f.u))
            row += len(f.u)
            rest = [f.height * (f.v - of[rows]) for of in left]
            out.append(Curve(photo.recording, f"{SIDES[f.side]}'s height", photo.unit, f"x_{photo.unit}", f.length * f.u,
                             f.height * np.asarray(f.v), *rest))  # fmt: skip
    return tuple(out)
