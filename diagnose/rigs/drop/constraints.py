"""Rows of prior knowledge: joined contacts, stated falls, speeds along the line of sight."""

import math

import numpy as np

from diagnose.air import G_M_S2
from diagnose.rigs.drop.flight_model import Model, rate_of
from diagnose.rigs.drop.nuisances import DEPTH_SD_M

ASIDE_SD = math.sqrt(2)  # of v_y² over its mean, v_y being normal


def pushed_sides(model: Model, sds: np.ndarray, push: np.ndarray) -> np.ndarray:
    """Change of the side conditions (J + R,) by an acceleration, falls neglected."""
    count, touch = len(model.session.joint), touching(model, push)
    return np.concatenate([(touch[count:] - touch[:count]) / sds, np.zeros(len(model.session.names))])


def touching(model: Model, push: np.ndarray) -> np.ndarray:
    """(2 J,) [m]: displacement across of seeds at their contacts by an acceleration."""
    return np.einsum("np,np->n", model.contacts.shift, push[model.contacts.flight, :, 0])


def side_rows(model: Model, starts: np.ndarray, at: dict, sds: np.ndarray, side_columns: np.ndarray, side, spun: np.ndarray):
    """(recording, {flight: entries of x, z, v_x, v_z, spin}, globals, right) of contacts, falls."""
    s = model.session
    count, rows = len(s.joint), []
    for j, (before, after) in enumerate(s.joint):
        sd = sds[j]
        taus = model.contacts.tau[[j, count + j]]
        entries = {
            before: np.array([-1, 0, -taus[0], 0, -spun[j]]) / sd,
            after: np.array([1, 0, taus[1], 0, spun[count + j]]) / sd,
        }
        rows.append((s.recording[before], entries, side_columns[j], -side[j]))
    for r in np.flatnonzero(np.isfinite(s.release)):
        flight = int(np.flatnonzero(s.recording == r)[0])
        touched = np.flatnonzero(s.joint[:, 0] == flight)
        if not len(touched):  # its first contact was left out
            continue
        j = int(touched[0])
        slope = (starts[flight, 3] * rate_of(at) ** 2 / G_M_S2 - model.contacts.tau[j]) / s.release_sd[r]  # air neglected
        rows.append((r, {flight: np.array([0, 0, 0, slope, 0])}, side_columns[count + r], -side[count + r]))
    return rows


def unseen_rows(model: Model, starts: np.ndarray, r: int):
    """Rows for motion along the line of sight: v_y² of usual size, y continuous at contacts."""
    s, flights = model.session, np.flatnonzero(model.session.recording == r)
    for f in flights:
        sd = ASIDE_SD * model.aside_square[f]
        yield ((f, 4),), 1 / sd, (model.aside_square[f] - starts[f, 4]) / sd
    joints = {int(after): j for j, (_, after) in enumerate(s.joint)}
    for f in flights:
        sd = math.sqrt(model.aside_square[f])
        yield ((f, 6),), 1 / sd, -starts[f, 6] / sd
        j = joints.get(int(f))
        if j is None:
            sd = DEPTH_SD_M if f == flights[0] else s.half[flights].sum() * sd  # after unseen flights
            yield ((f, 5),), 1 / sd, -starts[f, 5] / sd
            continue
        before, taus = s.joint[j, 0], model.contacts.tau[[j, len(s.joint) + j]]
        apart = starts[f, 5] + taus[1] * starts[f, 6] - starts[before, 5] - taus[0] * starts[before, 6]
        entries = np.array([1, taus[1], -1, -taus[0]]) / s.rocking_m
        yield ((f, 5), (f, 6), (before, 5), (before, 6)), entries, -apart / s.rocking_m
