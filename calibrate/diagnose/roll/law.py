"""A law for what has no name: the term in speed, travel or time that takes most of the excess, by sparse regression.

One term at a time, each a resistance over weight on the level that grows as a power of its variable, or acts on one part of the
plate; its exponent with the range that the data leave (χ² within 3.84 of the best).
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np

from calibrate.diagnose.linear import fall_of_chi2, projector, stacked
from calibrate.diagnose.locate import Location
from calibrate.diagnose.problem import Fit
from calibrate.diagnose.roll.motion import Table
from calibrate.diagnose.roll.problem import PUSH
from calibrate.diagnose.roll.windows import POINTS, Flown, bump, flown, response

POWERS = (-1.0, -0.5, 0.5, 1.0, 1.5, 2.0, 3.0)
PARTS = 10  # of the run-out, for what acts on one part of the plate
WITHIN = 3.84
SECOND_TERM = 12.0  # fall of χ² that a further term must bring


@dataclass(frozen=True)
class Term:
    """family: speed | travel | time | part | corner; power, or (low, high) [mm] of the part."""

    family: str
    power: float = 0.0
    part: tuple[float, float] = (0.0, 0.0)


@dataclass(frozen=True, eq=False)
class Asked:
    """Terms with their columns (M, K) in the reduced space of a fit, the globals: a (M, G), projection and residual b (M,)."""

    terms: list[Term]
    columns: np.ndarray
    a: np.ndarray
    project: Callable
    b: np.ndarray


def asked_of(base: Fit) -> Asked:
    """The library of terms, put to a fit."""
    terms, library = _library(base)
    a, b = stacked(base.problem.reduce(base.starts, base.values, library)[0])
    a, columns = np.split(a, [len(base.names)], axis=1)
    return Asked(terms, columns, a, projector(a, base.prior_sd), b)


def named_and_nameless(base: Fit, model: Fit) -> tuple[float, float]:
    """ln of the Bayes factors over the baseline, about, of what `model` frees and of the best single term in its place that no
    candidate stands for: ones that grow with travel or time, or act on one part of the plate. Half the fall of χ², less ½ ln of
    the fall (Schwarz) and ln of the terms tried; both as they are about the model, since a strong effect is far from the
    baseline."""
    asked = asked_of(replace(model, prior_sd=base.prior_sd))
    own = asked.a[:, model.prior_sd > base.prior_sd]
    others = [i for i, t in enumerate(asked.terms) if t.family in ("travel", "time", "part")]
    named = fall_of_chi2(own, asked.project, asked.b)[0]
    nameless = max(fall_of_chi2(asked.columns[:, [i]], asked.project, asked.b)[0] for i in others)
    return _ln_bayes(named, own.shape[1]), _ln_bayes(nameless, 1) - float(np.log(len(others)))


def _ln_bayes(fall: float, count: int) -> float:
    return 0.5 * fall - 0.5 * count * float(np.log(max(fall, 1.0)))


def law_of(base: Fit, where: Location) -> str | None:
    """The law in words, None where nothing stands out."""
    asked = asked_of(base)
    terms, columns, project, b = asked.terms, asked.columns, asked.project, asked.b
    chosen: list[int] = []
    reached, said = 0.0, np.zeros(len(terms))
    for _ in range(2):
        falls = np.array([fall_of_chi2(columns[:, [*chosen, i]], project, b)[0] for i in range(len(terms))])
        best = int(np.argmax(falls))
        if falls[best] - reached < SECOND_TERM:
            break
        chosen.append(best)
        said = falls if len(chosen) == 1 else said
        reached = float(falls[best])
    if not chosen:
        return None
    gram = columns[:, chosen].T @ project(columns[:, chosen])
    size = np.linalg.solve(gram, columns[:, chosen].T @ project(b))
    words = [_words(terms[i], s, terms, said if n == 0 else None) for n, (i, s) in enumerate(zip(chosen, size, strict=True))]
    return " and ".join(words) + (", in the run-out only" if where.sectors[0].name == "run-out" else "")


def _library(base: Fit) -> tuple[list[Term], list[np.ndarray]]:
    """Terms, and each run's columns (n, K)."""
    at, runs = flown(base), base.problem.model.runs
    reach = max(float(x[-1] - way.corner) for x, way in zip(at.seen, at.ways, strict=True))
    edges = np.linspace(0.0, reach, PARTS + 1)
    terms = [Term(family, p) for family in ("speed", "travel", "time") for p in POWERS if family == "speed" or p > 0]
    terms += [Term("part", part=(1e3 * a, 1e3 * b)) for a, b in combinations(edges, 2) if b - a < 0.65 * reach]
    terms.append(Term("corner"))
    return terms, [np.column_stack([_column(base, at, r, term, reach) for term in terms]) for r in range(len(runs))]


def _column(base: Fit, at: Flown, r: int, term: Term, reach: float) -> np.ndarray:
    way = at.ways[r]
    length = way.corner - way.x0
    if term.family == "corner":
        return response(base, at, r, way=replace(way, keep=way.keep * (1 - PUSH)))
    if term.family == "part":
        return response(base, at, r, place=bump(length + term.part[0] / 1e3, length + term.part[1] / 1e3, 1.3 * (length + reach)))
    top = max(float(s.max()) for s in at.speed)
    if term.family == "speed":
        grid = np.linspace(0.0, 1.3 * top, POINTS)
        values = np.maximum(grid / top, 0.05) ** term.power
        return response(base, at, r, more=Table(0.0, float(grid[1]), PUSH * values))
    if term.family == "travel":
        grid = np.linspace(0.0, 1.3 * (length + reach), POINTS)
        values = np.maximum((grid - length) / reach, 0) ** term.power
        return response(base, at, r, place=Table(0.0, float(grid[1]), -PUSH * values))
    t = base.problem.model.runs[r].time_s
    corner = float(np.interp(way.corner, np.maximum.accumulate(at.seen[r]), t)) - way.t0
    grid = np.linspace(0.0, float(t[-1]) - way.t0, POINTS)
    values = np.maximum((grid - corner) / grid[-1], 0) ** term.power
    return response(base, at, r, time=Table(0.0, float(grid[1]), -PUSH * values))


def _words(term: Term, size: float, terms: list[Term], falls: np.ndarray | None) -> str:
    how = "against" if size > 0 else "along"
    if term.family == "corner":
        return f"a {'loss' if size > 0 else 'gain'} of {100 * abs(size):.2g} % of the speed at the corner"
    if term.family == "part":
        where = f"between {term.part[0]:.0f} and {term.part[1]:.0f} mm behind the corner"
        return f"a force {how} the motion of {abs(size):.2g} of the weight {where}"
    power = f"{term.power:g}"
    if falls is not None:
        kept = [t.power for t, f in zip(terms, falls, strict=True) if t.family == term.family and f > falls.max() - WITHIN]
        power += f" (between {min(kept):g} and {max(kept):g})" if len(kept) > 1 else ""
    greatest = {"speed": "the greatest speed", "travel": "the end of the way", "time": "the end"}[term.family]
    return f"a force {how} the motion as {term.family} to the power {power}, {abs(size):.2g} of the weight at {greatest}"
