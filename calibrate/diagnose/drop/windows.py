"""Windows of a drop: accelerations along and across a flight's path that act only there, by time, height, speed, bounce."""

from itertools import pairwise

import numpy as np

from calibrate.diagnose.drop.flight import NODES, positions_at_nodes
from calibrate.diagnose.drop.model import pushed
from calibrate.diagnose.locate import Windows
from calibrate.diagnose.problem import Fit

BINS = 5


def windows_of(fit: Fit) -> Windows:
    """Unit accelerations in every bin of every axis."""
    s, axes = fit.problem.model.session, axes_of(fit)
    along = flown(fit)[1]
    along = along / np.maximum(np.linalg.norm(along, axis=-1, keepdims=True), 1e-9)
    across = np.broadcast_to([1.0, 0.0], along.shape)
    pushes, where = [], []
    for axis, values in axes.items():
        for low, high in _edges(values, axis):
            inside = ((values >= low) & (values <= high))[..., None]
            pushes += [inside * along, inside * across]
            where += [(axis, low, high)] * 2
    return Windows(np.array(pushes).reshape(-1, len(s.middle), len(NODES), 2), tuple(where))


def flown(fit: Fit) -> tuple[np.ndarray, np.ndarray]:
    """Places and velocities (F, POINTS, 2) at the flights' nodes."""
    half = fit.problem.model.session.half
    return positions_at_nodes(fit.starts, half, pushed(fit.problem.model, fit.starts, fit.by_name))


def axes_of(fit: Fit) -> dict[str, np.ndarray]:
    """Where each flight's Chebyshev nodes (F, POINTS) lie on each axis."""
    s = fit.problem.model.session
    places, speeds = flown(fit)
    begun = np.array([s.middle[s.recording == r].min() - s.half[s.recording == r].max() for r in s.recording])
    number = np.array([int((s.recording[:f] == s.recording[f]).sum()) for f in range(len(s.middle))])
    floor = np.array([places[s.recording == r, :, 1].min() for r in s.recording])
    return {
        "t_s": s.middle[:, None] + s.half[:, None] * NODES - begun[:, None],
        "z_mm": 1e3 * (places[..., 1] - floor[:, None]),
        "v_m_s": np.linalg.norm(speeds, axis=-1),
        "n_bounce": number[:, None] * np.ones_like(NODES),
    }


def _edges(values: np.ndarray, axis: str) -> list[tuple[float, float]]:
    """Bins of equal width; the bounce count has one a flight."""
    if axis == "n_bounce":
        return [(k - 0.5, k + 0.5) for k in range(int(values.max()) + 1)]
    edges = np.linspace(values.min(), values.max(), BINS + 1)
    return list(pairwise(edges))
