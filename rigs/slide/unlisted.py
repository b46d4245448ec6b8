"""Unlisted physics of slides: pushes along the plate by time, way or speed; a power
law."""

from itertools import pairwise

import numpy as np

from benchtwin.bench.constants import G_M_S2
from benchtwin.bench.language import tr
from benchtwin.infer import power_law
from benchtwin.infer.power_law import Family, Law, raised, reference, resisting
from benchtwin.infer.problem import Fit
from benchtwin.infer.unlisted import Bin, Windows
from benchtwin.rigs.slide.model import run_motion
from benchtwin.rigs.slide.problem import travelled_mm

BINS = 8
POWERS = tuple(np.arange(0.25, 4.01, 0.25))
WORDS = {"x_mm": "the way slid", "v_m_s": "speed", "t_s": "the time since the onset"}


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
        "x_mm": [1e3 * x for x, *_ in flown],
        "v_m_s": [np.abs(v) for _, v, *_ in flown],
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


def law_of(fit: Fit) -> Law:
    """Friction that changes with a power of way, speed or time."""
    runs = fit.problem.model.session.runs
    if not runs:
        return ()
    axes, since = _axes(fit)
    most = {a: reference(max(float(v.max()) for v in axes[a])) for a in WORDS}
    pushes = []
    for r, run in enumerate(runs):
        cosine = G_M_S2 * np.cos(run.tilt.coefficients[0]) * (since[r] > 0)
        over = [raised(axes[a][r] / most[a], p) for a in WORDS for p in POWERS]
        pushes.append([-cosine * column for column in over])
    acts = resisting(tr("friction is more by"), "friction_power", most["v_m_s"])
    families = [
        _friction(tr("at {:g} mm", most["x_mm"]), "x_mm"),
        _friction(f"at {most['v_m_s']:g} m/s", "v_m_s", acts),
        _friction(f"after {most['t_s']:g} s", "t_s"),
    ]
    return power_law.law_of(fit, families, _travelled(fit, pushes))


def _friction(where: str, axis: str, acts=None) -> Family:
    def say(rises: bool, power: str) -> str:
        how = tr("grows") if rises else tr("falls")
        return tr(
            "a friction that {} with {} {}, while sliding", how, tr(WORDS[axis]), power
        )

    return Family(
        say,
        ("1", where),
        "sliding",
        POWERS,
        WORDS[axis],
        acts,
        tr("the twin knows no friction that goes with {}", tr(WORDS[axis]))
        * (acts is None),
    )
