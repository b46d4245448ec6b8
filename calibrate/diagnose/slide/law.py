"""A law for what has no name: on what the friction that is missing depends, and with which power.

Δμ = A s^p, s the way slid, the speed or the time since the onset, acts on the block as −g cos θ Δμ; each power's column is asked
in the reduced space how much of χ² it takes. Of what does as well the simplest is said.
"""

import numpy as np

from calibrate.diagnose.linear import fall_of_chi2, projector, stacked
from calibrate.diagnose.problem import Fit
from calibrate.diagnose.slide.model import moved
from calibrate.diagnose.slide.motion import G_M_S2
from calibrate.diagnose.slide.windows import pushed

POWERS = np.arange(0.25, 4.01, 0.25)
WORDS = {"x": "the way slid", "v": "speed", "t": "the time since the onset"}
SIMPLE = (0.5, 1.0, 1.5, 2.0, 3.0)
FALL_95 = 3.84


def law_of(base: Fit) -> str | None:
    """ "a friction that grows with the way slid as its power 1 (0.75 to 1.25)", None where no power says much."""
    model = base.problem.model
    if not model.session.runs or model.stairs:
        return None
    sizes, signs = _columns(base)
    top = max(sizes.values())
    best = max(
        (key for key in sizes if sizes[key] > top - FALL_95), key=lambda key: (key[1] in SIMPLE[1:4], key[0] == "x", sizes[key])
    )
    if sizes[best] < FALL_95 * 3:
        return None
    axis = best[0]
    inside = [p for (a, p), fall in sizes.items() if a == axis and fall > sizes[best] - FALL_95]
    low, high = min(inside), max(inside)
    power = min((p for p in SIMPLE if low <= p <= high), key=lambda p: abs(p - best[1]), default=best[1])
    grows = "grows" if signs[best] > 0 else "falls"
    rivals = [WORDS[a] for a in WORDS if a != axis and max(f for (b, _), f in sizes.items() if b == a) > sizes[best] - FALL_95]
    also = f"; {' or '.join(rivals)} would do as well" if rivals else ""
    return f"a friction that {grows} with {WORDS[axis]} to the power {power:g} ({low:g} to {high:g}), while sliding{also}"


def _columns(base: Fit) -> tuple[dict, dict]:
    """Fall in χ² and sign of Δμ for every axis and power."""
    model, keys = base.problem.model, [(axis, float(p)) for axis in WORDS for p in POWERS]
    flown = [moved(model, r, base.starts[r], base.by_name) for r in range(len(model.session.runs))]
    since = [np.clip(r.time - r.tilt.origin - base.starts[k, 1], 0, None) for k, r in enumerate(model.session.runs)]
    axes = {"x": [x for x, _, _ in flown], "v": [np.abs(v) for _, v, _ in flown], "t": since}
    extra = []
    for k, run in enumerate(model.session.runs):
        cosine = G_M_S2 * np.cos(run.tilt.coefficients[0]) * (since[k] > 0)
        scaled = [np.clip(axes[a][k], 0, None) / max(s.max() for s in axes[a]) for a, _ in keys]
        own = [pushed(run.time, -cosine * s**p) for s, (_, p) in zip(scaled, keys, strict=True)]
        extra.append(np.vstack([np.column_stack(own), np.zeros(len(keys))]))
    extra += [np.zeros((len(read.angles), len(keys))) for read in model.session.reads]
    a, b = stacked(base.problem.reduce(base.starts, base.values, extra)[0])
    a, columns = np.split(a, [len(base.names)], axis=1)
    project = projector(a, base.prior_sd)
    right = columns.T @ project(b)
    falls = {key: fall_of_chi2(columns[:, [i]], project, b)[0] for i, key in enumerate(keys)}
    return falls, dict(zip(keys, np.sign(right), strict=True))
