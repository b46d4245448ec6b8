"""Ripple of a seed that is not round: is there one, and at which rolling radius?

Each run has its own phase. Where the rotation was not seen the radius is searched for.
"""

from dataclasses import dataclass

import numpy as np

from diagnose.engine.linear import beside_globals, chance, fall_of_chi2
from diagnose.engine.problem import Fit
from diagnose.rigs.roll.motion import Table
from diagnose.rigs.roll.problem import PUSH
from diagnose.rigs.roll.run_noise import has_few_rows
from diagnose.rigs.roll.session import Run, Seed
from diagnose.rigs.roll.unlisted import FittedRuns, fitted_runs, response

RADII = 0.82, 1.18  # of the stated radius: sizes in one lot, and the axis of rolling
MOST_RADII = 61
NEARER = 9  # radii between neighbours of the best one
POINTS_A_TURN = 24
AT_ONCE = 5  # radii
SEEN_P = 0.01  # p of as great a ripple by chance below which it is a candidate


@dataclass(frozen=True)
class Ripple:
    """p of as great a ripple by chance; turn, phase (R,): its argument is turn x + phase."""

    p: float
    turn: np.ndarray
    phase: np.ndarray


def arguments(runs: tuple[Run, ...], seed: Seed, radius: float = 1.0) -> tuple[np.ndarray, np.ndarray]:
    """turn, phase (R,): twice the seen orientation, or 2/r; radius: over the stated one."""
    turn, phase = [], []
    for run in runs:
        if run.turning:
            slope, level = (np.sign(run.turning[0]) * value for value in run.turning)
            turn.append(2 * slope)
            phase.append(2 * level)
        else:
            turn.append(2 / (seed.radius * radius))
            phase.append(-turn[-1] * float(np.mean(run.x)))
    return np.array(turn), np.array(phase)


def find_ripple(base: Fit, rng: np.random.Generator) -> Ripple:
    """For a fitted baseline without ripple."""
    model = base.problem.model
    if any(has_few_rows(run) for run in model.runs):
        return Ripple(1.0, *arguments(model.runs, model.seed))
    doubt, at = np.exp(base.problem.level_sd * rng.standard_normal(4000)), fitted_runs(base)
    if all(run.turning for run in model.runs):
        own = arguments(model.runs, model.seed)
        return Ripple(chance(*_falls(base, at, [own])[0], doubt), *own)
    way = max(float(seen[-1] - (w.x0 if run.stays else w.corner)) for seen, w, run in zip(at.seen, at.ways, model.runs, strict=True))
    count = int(np.clip((RADII[1] - RADII[0]) * way / model.seed.radius, 9, MOST_RADII))  # neighbours differ by 2 rad at the end of the way
    radii = np.linspace(*RADII, count)
    falls = _falls_by_radius(base, at, radii)
    best = int(np.argmax([fall for fall, _ in falls]))
    p = min(1.0, count * chance(*falls[best], doubt))
    if p < SEEN_P:
        radii = radii[best] + (radii[1] - radii[0]) * np.linspace(-1, 1, NEARER)
        best = int(np.argmax([fall for fall, _ in _falls_by_radius(base, at, radii)]))
    return Ripple(p, *arguments(model.runs, model.seed, radii[best]))


def _falls_by_radius(base: Fit, at: FittedRuns, radii: np.ndarray) -> list[tuple[float, int]]:
    """Fall of χ² and degrees of freedom at each radius over the stated one."""
    asked, found = [arguments(base.problem.model.runs, base.problem.model.seed, radius) for radius in radii], []
    for some in (asked[k : k + AT_ONCE] for k in range(0, len(asked), AT_ONCE)):
        found += _falls(base, at, some)
    return found


def _falls(base: Fit, at: FittedRuns, asked) -> list[tuple[float, int]]:
    """Fall of χ² and degrees of freedom for each (turn, phase), each run with its own ripple."""
    model, count = base.problem.model, len(base.problem.model.runs)
    extra = [np.zeros((len(run.time_s), 2 * count * len(asked))) for run in model.runs]
    for k, (turn, phase) in enumerate(asked):
        for r in range(count):
            reach = 1.1 * float(at.seen[r][-1] - at.ways[r].x0)
            grid = np.linspace(0.0, reach, max(50, int(reach * turn[r] / (2 * np.pi) * POINTS_A_TURN)))
            phi = turn[r] * (grid + at.ways[r].x0) + phase[r]
            for j, wave in enumerate((np.cos, np.sin)):
                push = Table(0.0, float(grid[1]), PUSH * wave(phi))
                extra[r][:, 2 * (k * count + r) + j] = response(base, at, r, place=push)
    columns, project, b = beside_globals(base.problem.reduce(base.starts, base.values, extra)[0], base.prior_sd)
    return [fall_of_chi2(part, project, b) for part in np.split(columns, len(asked), axis=1)]
