"""Unlisted physics of slides: pushes along the plate by time, way or speed; a power
law."""

from itertools import pairwise

import numpy as np
from benchtwin.bench.constants import G_M_S2
from benchtwin.infer.linear import beside_globals, fall_of_chi2
from benchtwin.infer.problem import Fit
from benchtwin.infer.unlisted import Bin, Windows
from benchtwin.rigs.slide.model import run_motion
from benchtwin.rigs.slide.problem import travelled_mm

BINS = 8
POWERS = np.arange(0.25, 4.01, 0.25)
WORDS = {"x_mm": "the way slid", "v_m_s": "speed", "t_s": "the time since the onset"}
SIMPLE = (1.0, 2.0, 0.5, 1.5, 3.0)  # the simplest first
FALL_95 = 3.84  # of χ², within which a power does as well as the best
LEAST_FALL = 12.0  # of χ², for a law to be reported


def windows_of(fit: Fit) -> Windows:
    """1 m/s² in every bin of every axis; none where there are only readings."""
    runs = fit.problem.model.session.runs
    if not runs:
        return Windows(None, ())
    axes, since = _axes(fit)
    bins: list[Bin] = []
    columns: list[list[np.ndarray]] = [[] for _ in runs]
    for axis, values in axes.items():
        for low, high in pairwise(
            np.linspace(0.0, max(float(v.max()) for v in values), BINS + 1)
        ):
            bins.append(Bin(axis, float(low), float(high), "push", "sliding"))
            for r in range(len(runs)):
                push = (values[r] >= low) & (values[r] <= high) & (since[r] > 0)
                columns[r].append(push.astype(float))
    return Windows(_travelled(fit, columns), tuple(bins))


def _axes(fit: Fit) -> tuple[dict[str, list[np.ndarray]], list[np.ndarray]]:
    """Where each run's rows lie on each axis, and the time since the onset."""
    model = fit.problem.model
    runs = model.session.runs
    flown = [run_motion(model, r, fit.starts[r], fit.by_name) for r in range(len(runs))]
    since = [
        run.time - run.time[0]
        if run.in_motion
        else run.time - run.tilt.origin - fit.starts[r, 1]
        for r, run in enumerate(runs)
    ]
    axes = {
        "t_s": [np.clip(s, 0, None) for s in since],
        "x_mm": [1e3 * x for x, _, _ in flown],
        "v_m_s": [np.abs(v) for _, v, _ in flown],
    }
    return axes, since


def _travelled(fit: Fit, pushes: list[list[np.ndarray]]) -> list[np.ndarray]:
    """Travel (n_r, K) [mm] that accelerations (n,) add; 0 on friction rows and
    readings."""
    session = fit.problem.model.session
    out = []
    for run, push in zip(session.runs, pushes, strict=True):
        out.append(
            np.column_stack([np.append(travelled_mm(run.time, p), 0.0) for p in push])
        )
    return out + [
        np.zeros((len(read.angles), out[0].shape[1])) for read in session.reads
    ]


def law_of(fit: Fit) -> str | None:
    """Δμ = A s^p, s way, speed or time; the simplest power that does as well as the
    best."""
    if not fit.problem.model.session.runs:
        return None
    axes, since = _axes(fit)
    keys = [(axis, float(p)) for axis in WORDS for p in POWERS]
    pushes = []
    for r, run in enumerate(fit.problem.model.session.runs):
        cosine = G_M_S2 * np.cos(run.tilt.coefficients[0]) * (since[r] > 0)
        most = {a: max(v.max() for v in axes[a]) for a, _ in keys}
        pushes.append([-cosine * (axes[a][r] / most[a]) ** p for a, p in keys])
    reduced = fit.problem.reduce(fit.starts, fit.values, _travelled(fit, pushes))[0]
    columns, project, b = beside_globals(reduced, fit.prior_sd)
    signs = np.sign(columns.T @ project(b))
    falls = np.array(
        [fall_of_chi2(columns[:, [k]], project, b)[0] for k in range(len(keys))]
    )
    best = int(np.argmax(falls))
    if falls[best] < LEAST_FALL:
        return None
    axis = keys[best][0]
    inside = [
        p
        for (a, p), fall in zip(keys, falls, strict=True)
        if a == axis and fall > falls[best] - FALL_95
    ]
    power = next((p for p in SIMPLE if min(inside) <= p <= max(inside)), keys[best][1])
    others = {
        a
        for (a, _), fall in zip(keys, falls, strict=True)
        if a != axis and fall > falls[best] - FALL_95
    }
    if others:
        also = f"; {' or '.join(WORDS[a] for a in sorted(others))} would do as well"
    else:
        also = ""
    grows = "grows" if signs[best] > 0 else "falls"
    return (
        f"a friction that {grows} with {WORDS[axis]} to the power {power:g}"
        f" ({min(inside):g} to {max(inside):g}), while sliding{also}"
    )
