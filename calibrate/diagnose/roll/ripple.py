"""The ripple of a seed that is not round: is there one, how far does the centre rise, does the stated shape say so.

Each run's ripple has a phase of its own: two columns a run, tested all together; where the seed's turning was not seen its radius
is looked for as well, and paid for by the number of radii that were tried.
"""

from dataclasses import dataclass

import numpy as np

from calibrate.diagnose.decide import ALPHA
from calibrate.diagnose.linear import chance, fall_of_chi2, projector, ridge, stacked
from calibrate.diagnose.locate import noise_doubt
from calibrate.diagnose.problem import Fit
from calibrate.diagnose.roll.motion import Table
from calibrate.diagnose.roll.problem import PUSH
from calibrate.diagnose.roll.session import Run, Seed
from calibrate.diagnose.roll.windows import Flown, flown, response
from calibrate.diagnose.scores import HeldOut

RADII = 0.82, 1.18  # of the stated radius: sizes of one lot, and which of its axes a seed rolls about
MOST_RADII = 61
NEARER = 9  # radii between neighbours of the best one
POINTS_A_TURN = 24
AT_ONCE = 5  # radii
PHASES = 180
LIKE_STATED = (0.5, 1.5)  # rise over that of the stated shape which is taken for the stated shape's


@dataclass(frozen=True)
class Ripple:
    """p of a ripple as great by chance, after all radii tried; turn, phase (R,): its argument is turn x + phase."""

    p: float
    turn: np.ndarray
    phase: np.ndarray


def arguments(runs: tuple[Run, ...], seed: Seed, radius: float = 1.0) -> tuple[np.ndarray, np.ndarray]:
    """turn, phase (R,): twice the seen orientation, or 2/r from the middle of the way; radius: over the stated one."""
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
    """Asked of a baseline without ripple."""
    model = base.problem.model
    doubt, at = noise_doubt(base, rng), flown(base)
    if all(run.turning for run in model.runs):
        own = arguments(model.runs, model.seed)
        return Ripple(chance(*_falls(base, at, [own])[0], doubt), *own)
    way = max(float(seen[-1] - w.corner) for seen, w in zip(at.seen, at.ways, strict=True))
    count = int(np.clip((RADII[1] - RADII[0]) * way / model.seed.radius, 9, MOST_RADII))  # neighbours differ by 2 rad at the end
    radii = np.linspace(*RADII, count)
    falls = _asked(base, at, radii)
    best = int(np.argmax([fall for fall, _ in falls]))
    p = min(1.0, count * chance(*falls[best], doubt))
    if p < ALPHA:
        radii = radii[best] + (radii[1] - radii[0]) * np.linspace(-1, 1, NEARER)
        best = int(np.argmax([fall for fall, _ in _asked(base, at, radii)]))
    return Ripple(p, *arguments(model.runs, model.seed, radii[best]))


def _asked(base: Fit, at: Flown, radii: np.ndarray) -> list[tuple[float, int]]:
    """Fall of χ² and freedom for each of the radii, over the stated one."""
    asked, found = [arguments(base.problem.model.runs, base.problem.model.seed, radius) for radius in radii], []
    for some in (asked[k : k + AT_ONCE] for k in range(0, len(asked), AT_ONCE)):
        found += _falls(base, at, some)
    return found


def _falls(base: Fit, at: Flown, asked) -> list[tuple[float, int]]:
    """Fall of χ² and freedom for each of the arguments (turn, phase), when every run has a ripple of its own."""
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
    a, b = stacked(base.problem.reduce(base.starts, base.values, extra)[0])
    a, columns = np.split(a, [len(base.names)], axis=1)
    project = projector(a, base.prior_sd)
    return [fall_of_chi2(part, project, b) for part in np.split(columns, len(asked), axis=1)]


def rises(found: Fit) -> tuple[np.ndarray, np.ndarray]:
    """Rise [mm] of each run and its sd (R,), from a fit with the ripple freed; noise's own share taken off."""
    rise, sds = [], []
    for r in range(len(found.problem.model.runs)):
        pair = [found.names.index(f"shape-barrier.{kind}.{r}") for kind in ("cos", "sin")]
        value, spread = found.values[pair], found.covariance[np.ix_(pair, pair)]
        size = float(np.hypot(*value))
        along = value / max(size, 1e-12)
        sd = float(np.sqrt(max(along @ spread @ along, 1e-18)))
        across = float(np.sqrt(max(np.trace(spread) - sd**2, 0.0)))
        rise.append(float(np.sqrt(max(size**2 - across**2, 0.0))))
        sds.append(sd)
    return np.array(rise), np.array(sds)


def common_rise(found: Fit) -> tuple[float, float, float]:
    """Rise [mm] common to all runs, its sd, and by how much single runs scatter about it (sd, mm)."""
    rise, sd = rises(found)
    scatter = 0.0
    for _ in range(20):
        weight = 1 / (sd**2 + scatter**2)
        mean = float((weight * rise).sum() / weight.sum())
        beyond = float((weight**2 * ((rise - mean) ** 2 - sd**2)).sum() / (weight**2).sum())
        scatter = float(np.sqrt(max(beyond, 0.0))) if len(rise) > 2 else 0.0
    return mean, float(1 / np.sqrt(weight.sum())), scatter


def left_out_rise(found: Fit) -> tuple[float, ...]:
    """Rise [mm] as the other recordings have it, one value a recording; of a single recording its own."""
    rise, sd = rises(found)
    if len(rise) < 2:
        return (float(rise[0]),)
    weight = 1 / sd**2
    return tuple(float(v) for v in ((weight * rise).sum() - weight * rise) / (weight.sum() - weight))


def held_out_rise(found: Fit, base: Fit) -> HeldOut | None:
    """Each run predicted with the nuisances and the rise of the others; its phase, which nobody can foretell, is its own.

    None for one run."""
    rise, sse_fit, sse_base, sse_noise, columns = left_out_rise(found), 0.0, 0.0, 0.0, 0
    if len(rise) < 2:
        return None
    turns = np.linspace(0, 2 * np.pi, PHASES, endpoint=False)
    nil = np.where([n.startswith("shape-barrier") for n in base.names], 0.0, base.prior_sd)
    for r, (mine, its) in enumerate(zip(found.reduced, base.reduced, strict=True)):
        theta = ridge(*stacked(found.reduced[:r] + found.reduced[r + 1 :]), found.prior_sd)[0]
        theta_base = ridge(*stacked(base.reduced[:r] + base.reduced[r + 1 :]), nil)[0]
        pair = [found.names.index(f"shape-barrier.{kind}.{r}") for kind in ("cos", "sin")]
        theta[pair] = 0.0
        ripples = rise[r] * mine.a[:, pair] @ np.array([np.cos(turns), np.sin(turns)])
        sse_fit += float((((mine.b - mine.a @ theta)[:, None] - ripples) ** 2).sum(0).min())
        sse_base += float(((its.b - its.a @ theta_base) ** 2).sum())
        fall, count = fall_of_chi2(np.hstack([mine.a, mine.smooth]), lambda x: x, mine.b)
        sse_noise, columns = sse_noise + float((mine.b**2).sum()) - fall + count, columns + count
    return HeldOut.of(sse_base, sse_fit, sse_noise, float(np.sqrt(2 * columns)))


def as_stated(rise: float, sd: float, seed: Seed) -> bool:
    """Whether the stated shape makes such a rise."""
    if not np.isfinite(seed.rise_mm) or seed.round:
        return False
    return LIKE_STATED[0] * seed.rise_mm - 2 * sd < rise < LIKE_STATED[1] * seed.rise_mm + 2 * sd
