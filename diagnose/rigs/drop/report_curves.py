"""Curves of drops for the report: places, and residuals of the baseline and of the model."""

import numpy as np

from diagnose.engine.problem import Fit
from diagnose.finding import Curve
from diagnose.rigs.drop import impact_problem
from diagnose.rigs.drop.flight_model import predict

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


def impact_curves(before: Fit, after: Fit) -> tuple[Curve, ...]:
    """Restitution and sideways kick over impact speed, for each recording."""
    models = [of.problem.model.impacts_at(of.starts, of.values) for of in (before, after)]
    model, left = models[0], []
    for of, struck in zip((before, after), models, strict=True):
        at = {n: of.by_name[n] for n in of.problem.model.own_names}
        left.append(struck.y - impact_problem.predict(struck, at))
    out = []
    for r, recording in enumerate(model.impacts.names):
        for rows, first, quantity in ((model.e_rows, 0, "restitution"), (model.kick_rows, len(model.e_rows), "sideways kick")):
            own = np.flatnonzero(model.impacts.recording[rows] == r)
            if len(own):
                own = own[np.argsort(model.bounces.speed[rows[own]])]
                parts = [values[first + own] for values in (model.y, *left)]
                out.append(Curve(recording, quantity, "1", "v_m_s", model.bounces.speed[rows[own]], *parts))
    return tuple(out)
