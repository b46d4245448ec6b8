"""The ripple of a seed that is not round: is there one, how far does the centre rise, does the stated shape say so.

Each run's ripple has a phase of its own: two columns a run, tested all together; where the seed's turning was not seen its radius
is looked for as well, and paid for by the number of radii that were tried.
"""

from dataclasses import dataclass, replace

import numpy as np

from calibrate.diagnose.decide import ALPHA
from calibrate.diagnose.linear import block_diagonal, chance, fall_of_chi2, projector, ridge, stacked
from calibrate.diagnose.locate import noise_doubt
from calibrate.diagnose.problem import Fit, Problem
from calibrate.diagnose.roll.motion import Table
from calibrate.diagnose.roll.problem import PUSH
from calibrate.diagnose.roll.session import Run, Seed
from calibrate.diagnose.roll.windows import Flown, flown, response
from calibrate.diagnose.scores import FLAT, HeldOut, unbound

RADII = 0.82, 1.18  # of the stated radius: sizes of one lot, and which of its axes a seed rolls about
MOST_RADII = 61
NEARER = 9  # radii between neighbours of the best one
POINTS_A_TURN = 24
AT_ONCE = 5  # radii
RISES, ROUND_ABOUT = 400, 129  # points of rise and of phase
OUT_OF_THE_QUESTION = 1e-8  # of the greatest likelihood
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


def likelihoods(found: Fit) -> tuple[np.ndarray, np.ndarray]:
    """Rises (K,) [mm], and the likelihood of each (R, K) by each run's own quadratures, whatever its phase: where one of the two
    is hardly seen, a run tells what the other leaves. The rises end where those end that all runs together may have."""
    seen = []
    for r in range(len(found.problem.model.runs)):
        pair = [found.names.index(f"shape-barrier.{kind}.{r}") for kind in ("cos", "sin")]
        seen.append((found.values[pair], found.covariance[np.ix_(pair, pair)] + 1e-18 * np.eye(2)))
    top = max(np.hypot(*value) + 4 * np.sqrt(np.trace(spread)) for value, spread in seen)
    while True:
        rise = np.linspace(0.0, top, RISES)
        each = np.array([_of_any_phase(rise, *one) for one in seen])
        least = [rise[np.argmax(own > OUT_OF_THE_QUESTION * own.max())] for own in each]
        together = _joint(rise, each, 0.0)
        most = rise[np.flatnonzero(together > together.max() + np.log(OUT_OF_THE_QUESTION))[-1]]
        needed = 2 * max(most, *least, rise[1])
        if needed > top / 4:
            return rise, each
        top = needed


def _of_any_phase(rise: np.ndarray, value: np.ndarray, spread: np.ndarray) -> np.ndarray:
    """Likelihood (K,) of each rise, the mean over all phases: many of them near the one that was seen."""
    near = min(np.pi, 6 * np.sqrt(np.trace(spread)) / max(np.hypot(*value), 1e-12))
    about = np.arctan2(*value[::-1]) + near * np.linspace(-1, 1, ROUND_ABOUT)
    around = np.sort(np.mod(np.concatenate([about, np.linspace(0, 2 * np.pi, ROUND_ABOUT)]), 2 * np.pi))
    share = (np.append(around[1:], around[0] + 2 * np.pi) - np.append(around[-1] - 2 * np.pi, around[:-1])) / (4 * np.pi)
    off = value - rise[:, None, None] * np.column_stack([np.cos(around), np.sin(around)])
    square = np.einsum("kpi,ij,kpj->kp", off, np.linalg.inv(spread), off)
    return np.exp(-(square - square.min()) / 2) @ share


def common_rise(found: Fit) -> tuple[float, float, float]:
    """Rise [mm] common to all runs, its sd, and by how much single runs scatter about it (sd, mm)."""
    rise, each = likelihoods(found)
    tried = [0.0, *np.geomspace(2 * rise[1], rise[-1] / 2, 20)] if len(each) > 2 else [0.0]
    ln = np.array([_joint(rise, each, scatter) for scatter in tried])
    best = int(np.argmax(ln.max(axis=1)))
    weight = np.exp(ln[best] - ln[best].max())
    mean = float((weight * rise).sum() / weight.sum())
    return mean, float(np.sqrt((weight * (rise - mean) ** 2).sum() / weight.sum())), float(tried[best])


def _joint(rise: np.ndarray, each: np.ndarray, scatter: float) -> np.ndarray:
    """ln of the likelihood (K,) of a common rise about which runs scatter."""
    if scatter:
        about = np.exp(-(((rise[:, None] - rise) / scatter) ** 2) / 2)
        each = each @ (about / about.sum(axis=0))
    return np.log(each + 1e-300).sum(axis=0)


def of_this_size(problem: Problem, found: Fit) -> Problem:
    """With a rise as likely as what was found of it: seeds of one lot rise alike, by how much nobody knows beforehand; a prior of
    any rise would be paid for by each run anew. Each quadrature is as wide as the whole rise, √2 of what was seen: about what it
    costs to have chosen the size."""
    rise, sd, scatter = common_rise(beside_all(found))
    size = float(np.hypot(max(rise, sd), scatter))
    own = set(problem.columns_of("shape-barrier")) - {"shape-barrier"}
    return replace(problem, effects={n: replace(e, prior_sd=size) if n in own else e for n, e in problem.effects.items()})


def beside_all(found: Fit) -> Fit:
    """The ripple beside all other candidates and each run's smooth curves, about the same point: what else is missing is not
    taken for it."""
    effects, (a, b) = found.problem.effects, stacked(found.reduced)
    curves = block_diagonal([r.smooth for r in found.reduced])
    curves = curves / np.sqrt((curves**2).sum(0)).clip(1e-300)
    wide = [FLAT * effects[n].prior_sd if n in effects else sd for n, sd in zip(found.names, found.prior_sd, strict=True)]
    return _solved(found, np.hstack([a, curves]), b, np.append(wide, np.full(curves.shape[1], FLAT)))


def as_seen(found: Fit) -> Fit:
    """The ripple as the runs have it: a prior tells what is likely to be there, not how much of it was seen."""
    return _solved(found, *stacked(found.reduced), unbound(found, ("shape-barrier",)).prior_sd)


def _solved(found: Fit, a: np.ndarray, b: np.ndarray, prior_sd: np.ndarray) -> Fit:
    """About the same point with other priors of the globals, which are the first columns of a."""
    values, covariance, _ = ridge(a, b, prior_sd)
    count = len(found.names)
    return replace(found, values=values[:count], covariance=covariance[:count, :count], prior_sd=prior_sd[:count])


def left_out_rise(found: Fit) -> tuple[float, ...]:
    """Rise [mm] as the other recordings have it, one value a recording; of a single recording its own."""
    rise, each = likelihoods(found)
    others = [np.delete(each, r, axis=0) if len(each) > 1 else each for r in range(len(each))]
    return tuple(float(rise[np.argmax(_joint(rise, other, 0.0))]) for other in others)


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
