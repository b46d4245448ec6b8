"""Windows of a slide: accelerations that act only there, by time since the onset, by way and by speed."""

from itertools import pairwise

import numpy as np

from calibrate.diagnose.locate import Windows
from calibrate.diagnose.problem import Fit
from calibrate.diagnose.slide.model import moved

BINS = 5


def windows_of(fit: Fit) -> Windows:
    """1 m/s² in every bin of every axis; none where there are only readings."""
    model = fit.problem.model
    runs = model.session.runs
    if not runs:
        return Windows(None, ())
    flown = [moved(model, r, fit.starts[r], fit.by_name) for r in range(len(runs))]
    since = [run.time - run.time[np.argmax(x > 0)] for run, (x, _, _) in zip(runs, flown, strict=True)]
    axes = {
        "t_s": since, "x_mm": [1e3 * x for x, _, _ in flown], "v_m_s": [v for _, v, _ in flown],
    }  # fmt: skip
    where: list[tuple[str, float, float]] = []
    columns: list[list[np.ndarray]] = [[] for _ in runs]
    for axis, values in axes.items():
        edges = np.linspace(0.0, max(float(v.max()) for v in values), BINS + 1)
        for low, high in pairwise(edges):
            where.append((axis, float(low), float(high)))
            for r, run in enumerate(runs):
                push = (values[r] >= low) & (values[r] <= high) & (since[r] > 0)
                columns[r].append(np.append(pushed(run.time, push.astype(float)), 0.0))
    extra = [np.column_stack(c) for c in columns] + [np.zeros((len(k.angles), len(where))) for k in model.session.reads]
    return Windows(extra, tuple(where))


def pushed(time: np.ndarray, push: np.ndarray) -> np.ndarray:
    """Travel (n,) [mm] that an acceleration `push` (n,) [m/s²] adds: its double integral, linear between rows."""
    h = np.diff(time)
    speed = np.concatenate([[0.0], np.cumsum(h * (push[1:] + push[:-1]) / 2)])
    return 1e3 * np.concatenate([[0.0], np.cumsum(h * speed[:-1] + h**2 * (2 * push[:-1] + push[1:]) / 6)])
