"""What a report draws of rolls: travel as read, and what baseline and model leave of it."""

import numpy as np

from diagnose.engine.problem import Fit
from diagnose.finding import Curve
from diagnose.rigs.roll.model import moved


def curves_of(base: Fit, model: Fit | None) -> tuple[Curve, ...]:
    """One a run, over the time since its release."""
    out = []
    for r, run in enumerate(base.problem.model.runs):
        along = run.time_s - base.starts[r][0]
        left = 1e3 * (run.x - _read(base, r))
        better = left if model is None else 1e3 * (run.x - _read(model, r))
        out.append(Curve(run.recording, "travel", "mm", "t_s", along, 1e3 * (run.x - base.starts[r][1]), left, better))
    return tuple(out)


def _read(at: Fit, r: int) -> np.ndarray:
    return moved(at.problem.model, r, at.starts[r], at.by_name)[0]
