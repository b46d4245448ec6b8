"""What a report draws of drops: where each seed was, and what the baseline and the model leave of it."""

import numpy as np

from calibrate.diagnose.drop.model import predict
from calibrate.diagnose.finding import Curve
from calibrate.diagnose.problem import Fit

AXES = ("place across", "height")


def curves_of(before: Fit, after: Fit) -> tuple[Curve, ...]:
    """Two curves a recording, across and up [mm], over the time [s] since its first row."""
    s = before.problem.model.session
    left = [1e3 * (s.places - predict(of.problem.model, of.starts, of.by_name)[0]) for of in (before, after)]
    time, whose = s.middle[s.flight] + s.tau, s.recording[s.flight]
    out = []
    for r, name in enumerate(s.names):
        rows = np.flatnonzero(whose == r)
        if not len(rows):
            continue  # none of its flights could be used
        rows = rows[np.argsort(time[rows], kind="stable")]
        for axis, quantity in enumerate(AXES):
            part = [values[rows, axis] for values in (1e3 * s.places, *left)]
            out.append(Curve(name, quantity, "mm", "t_s", time[rows] - time[rows].min(), *part))
    return tuple(out)
