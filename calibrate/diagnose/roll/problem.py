"""The roll as a problem: nuisances, noise, where the fit begins."""

import math
from dataclasses import replace
from functools import partial
from itertools import pairwise

import numpy as np
from scipy import stats
from scipy.optimize import least_squares

from calibrate.diagnose.air import SEED_DRAG
from calibrate.diagnose.effects.effect import Effect
from calibrate.diagnose.effects.roll import EFFECTS
from calibrate.diagnose.effects.roll.shape_barrier import quadrature
from calibrate.diagnose.problem import Fit, Problem
from calibrate.diagnose.roll.model import OWN, Model, moved, predict, way_of
from calibrate.diagnose.roll.motion import Table
from calibrate.diagnose.roll.noise_of_run import RunNoise, estimate_noise
from calibrate.diagnose.roll.session import Run, Seed, weight_over_inertia
from calibrate.diagnose.series import Locals, Series, problem_of

MU_SD = 0.03  # of each run about the common one, relative
INCLINE_SD_DEG, LEVEL_SD_DEG = 0.1, 0.003
STEADY_DEG = 0.01  # by how much less no incline differs from run to run: it stands there, but seeds resist unevenly on it
LENGTH_SD_M = 1e-3  # of the centre's way on the incline: where the seed was laid, and the corner that its centre cuts
GRAVITY_SD = 5e-4  # beside 9.80665: a twin of the scale
WIDE_MU = 1.0  # the common rolling friction is measured here, not known
CURVES = 6
PARTS = 40  # of the level, for what a seed that is no ball meets by chance: some to half a turn
SCATTER_P = 1e-3  # of a scatter of friction as great by chance, below which it is taken for seeds that differ more
OWN_STEP = np.array([1e-7, 1e-8, 1e-8, 1e-5, 1e-6, 1e-5])  # for derivatives by a run's own numbers, and
STEP = 1e-5  # of a prior's sd, by globals: so short since slope and friction are twins but for 1e-3 of what they do
PUSH = 1e-6  # over weight, for derivatives: a 1e-4 of friction, so that the stop moves in proportion


def build(runs: tuple[Run, ...], seed: Seed, turn: np.ndarray, phase: np.ndarray, *, ripple: bool) -> Model:
    """The model with all globals that this session can say something about. turn, phase (R,): argument of the ripple."""
    f = weight_over_inertia(seed)
    mu = float(np.clip(np.median([r.way.slowing / f for r in runs]), 1e-4, 0.5))
    incline, length = [], []
    for run in runs:
        drive = min(run.way.acceleration / f, 0.95)
        incline.append(run.incline if math.isfinite(run.incline) else math.asin(drive) + math.atan(mu))
        length.append(run.length if math.isfinite(run.length) else run.way.way_down)
    speeds = [math.sqrt(2 * f * max(math.sin(b) - mu * math.cos(b), 0.01) * s) for b, s in zip(incline, length, strict=True)]
    sessions = tuple(dict.fromkeys(f"scale.{run.session}" for run in runs))
    names = (*effects_of(runs, seed, ripple=ripple), "mu", "incline", "level", "inertia", "corner", *sessions)
    names += ("drag",) if "drag" not in names and seed.drag else ()
    return Model(runs, seed, mu, np.array(incline), np.array(length), turn, phase, names, 1.6 * max(speeds))


def effects_of(runs, seed: Seed, *, ripple: bool) -> dict[str, Effect]:
    """Candidates that these recordings can show: no drag where the stated air already gives it, no slope from one direction."""
    left_out = {"drag", "drag.exponent"} if seed.drag else set()
    if len({run.sign for run in runs}) < 2:
        left_out.add("slope")
    if not ripple:
        left_out.add("shape-barrier")
    found = {n: e for n, e in EFFECTS.items() if n not in left_out}
    if ripple:
        own = [quadrature(kind, r) for r in range(len(runs)) for kind in ("cos", "sin")]
        found |= {e.name: e for e in own}
    return found


def roll_problem(
    model: Model,
    scales: dict[str, float],
    *,
    shape_known: float = 0.0,
    mu_sd: float = MU_SD,
    rough: np.ndarray | None = None,
) -> Problem:
    """scales: sd of each session's scale, relative; shape_known [mm]: rise that the stated shape makes, part of the baseline;
    mu_sd: of each run's rolling friction about the common one, relative; rough (R,): see roll.rough."""
    effects = effects_of(model.runs, model.seed, ripple="shape-barrier" in model.names)
    if shape_known:
        effects = {n: e for n, e in effects.items() if not n.startswith("shape-barrier")}
    noise = estimate_noise(model.runs, model.turn)
    known = {
        "mu": WIDE_MU, "incline": INCLINE_SD_DEG, "level": LEVEL_SD_DEG, "inertia": model.seed.inertia_sd, "corner": 1.0,
        **{f"scale.{s}": math.hypot(sd, GRAVITY_SD) for s, sd in scales.items()},
    }  # fmt: skip
    sizes = {"mu": 0.1, "incline": 0.1, "level": 0.003, "inertia": 0.01, "corner": 1.0} | {f"scale.{s}": 1e-3 for s in scales}
    if model.seed.drag:
        known["drag"], sizes["drag"] = model.seed.drag_sd, model.seed.drag_sd
    if shape_known:
        ripple = {n: shape_known / math.sqrt(2) for n in model.names if n.startswith("shape-barrier.")}
        known, sizes = known | ripple | {"oval": 1.0}, sizes | ripple | {"oval": 1.0}
    own = locals_of(model, mu_sd)
    model = replace(model, names=(*effects, *sizes), seen={})
    starts = np.array([_closer(model, r, own, noise) for r in range(len(model.runs))])
    steady = np.where(np.array(OWN) == "incline_deg", incline_scatter_deg(model.runs, starts), np.inf)
    own = replace(own, sd=np.minimum(own.sd, steady))
    series = tuple(_series(model, r, own.start[r], noise, None if rough is None else rough[r]) for r in range(len(model.runs)))
    made = problem_of("roll", series, own, partial(predict, model), effects, sizes, known, model, turns=20, step=STEP)
    return replace(made, starts=starts)


def _closer(model: Model, r: int, own: Locals, noise: RunNoise) -> np.ndarray:
    """Run r's own numbers fitted to it alone, so that the fit of all begins near its end: stops move by friction's share."""
    run, nil = model.runs[r], {n: 0.0 for n in model.names}
    loose = np.array([np.inf, np.inf, own.sd[2], 5 * own.sd[3], 0.3, own.sd[5]])
    unit = np.array([1e-3, 1e-4, 1e-3, 0.1, 0.03, 0.03])
    sigma = float(np.hypot(noise.sigma[r], 1e-5))

    def misfit(u: np.ndarray) -> np.ndarray:
        at = own.start[r] + unit * u
        return np.concatenate([(run.x - moved(model, r, at, nil)[0]) / sigma, unit * u / loose])

    return own.start[r] + unit * least_squares(misfit, np.zeros(len(OWN)), method="lm", diff_step=1e-5, max_nfev=60).x


def locals_of(model: Model, mu_sd: float) -> Locals:
    """Each run's own numbers to begin with, and how well they are known beforehand."""
    start, f = [], weight_over_inertia(model.seed)
    for r, run in enumerate(model.runs):
        b, s, way = model.incline[r], model.length[r], run.way
        release, place = way.release, way.place
        if way.corner < run.time_s[0]:  # the track begins behind the corner: what is stated says how it came there
            top = math.sqrt(2 * f * max(math.sin(b) - model.mu * math.cos(b), 0.01) * s)
            release = way.stop - top / (f * model.mu) - 2 * s / top
            place = run.x[-1] - top**2 / (2 * f * model.mu) - s
        start.append([release, place, 0.0, 0.0, 0.0, 0.0])
    length_stated = all(math.isfinite(run.length) for run in model.runs)
    incline_stated = all(math.isfinite(run.incline) for run in model.runs)
    sd = [np.inf, np.inf, LENGTH_SD_M if length_stated else 0.02, INCLINE_SD_DEG if incline_stated else 5.0, mu_sd, SEED_DRAG]
    return Locals(np.array(start), OWN_STEP, np.array(sd))


def _series(model: Model, r: int, start: np.ndarray, noise: RunNoise, rough: float | None) -> Series:
    run, curves = model.runs[r], _curves(model, r, start)
    own = rough * parts(model, r, start, {n: 0.0 for n in model.names}) if rough else None
    return Series(run.recording, run.x, float(noise.sigma[r]), run.lag, noise.noise, curves, own)


def parts(model: Model, r: int, start: np.ndarray, values: dict[str, float]) -> np.ndarray:
    """(n, PARTS) [m]: what a resistance of the weight in each part of the level alone would change of run r's travel."""
    way = way_of(model, r, start, values)
    seen = moved(model, r, start, values, way=way)[0]
    length = way.corner - way.x0
    reach = max(float(np.max(seen)) - start[1], 1.5 * length)
    pushes = [push_in(a, b, reach) for a, b in pairwise(np.linspace(length, reach, PARTS + 1))]
    return np.column_stack([moved(model, r, start, values, place=p, way=way)[0] - seen for p in pushes]) / PUSH


def _curves(model: Model, r: int, start: np.ndarray) -> np.ndarray:
    """(n, CURVES + 2): what a push in each part of the way, and a loss at the corner, would change; of this run alone."""
    nil = {n: 0.0 for n in model.names}
    way = way_of(model, r, start, nil)
    seen = moved(model, r, start, nil, way=way)[0]
    length = way.corner - way.x0
    reach = max(float(np.max(seen)) - start[1], 1.5 * length)
    edges = np.concatenate([[0.0], np.linspace(length, reach, CURVES + 1)])
    pushes = [push_in(edges[k], edges[k + 1], reach) for k in range(CURVES + 1)]
    columns = [(moved(model, r, start, nil, place=p, way=way)[0] - seen) / PUSH for p in pushes]
    slower = replace(way, keep=way.keep * (1 - PUSH))
    columns.append((moved(model, r, start, nil, way=slower)[0] - seen) / PUSH)
    return np.column_stack(columns)


def push_in(low: float, high: float, reach: float, points: int = 400) -> Table:
    """−PUSH between `low` and `high` [m from the release], nothing elsewhere."""
    grid = np.linspace(0.0, 1.2 * reach, points)
    width = grid[1]
    inside = np.clip((grid - low) / width + 0.5, 0, 1) * np.clip((high - grid) / width + 0.5, 0, 1)
    return Table(0.0, float(width), -PUSH * inside)


def scatter_of(base: Fit) -> float:
    """Relative sd of rolling friction among runs of one direction and incline: MU_SD, or what is seen where that is more."""
    square, freedom = _within_kinds(base.problem.model.runs, base.starts[:, OWN.index("mu")])
    if freedom < 2 or stats.chi2.sf(square / MU_SD**2, freedom) > SCATTER_P:
        return MU_SD
    return math.sqrt(square / freedom)


def incline_scatter_deg(runs: tuple[Run, ...], starts: np.ndarray) -> float:
    """sd of a run's own incline about the common one, widened for its few runs; from what each run by itself has for it,
    `starts` (R, 6), so with the doubt of measuring it. Infinite where too few runs are alike."""
    square, freedom = _within_kinds(runs, starts[:, OWN.index("incline_deg")])
    if freedom < 2:
        return math.inf
    return max(STEADY_DEG, math.sqrt(square / freedom) * stats.t.ppf(0.975, freedom) / stats.norm.ppf(0.975))


def _within_kinds(runs: tuple[Run, ...], values: np.ndarray) -> tuple[float, int]:
    """Sum of squares of `values` (R,) about their mean among runs of one direction and incline, and its freedom."""
    kinds: dict[tuple, list[float]] = {}
    for run, value in zip(runs, values, strict=True):
        kinds.setdefault((run.sign, run.incline, run.length), []).append(value)
    square = sum(float(((np.array(v) - np.mean(v)) ** 2).sum()) for v in kinds.values())
    return square, len(runs) - len(kinds)
