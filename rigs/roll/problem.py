"""The roll as a problem: nuisances, noise, initial values."""

import math
from collections import Counter
from dataclasses import replace
from functools import partial

import numpy as np
from scipy.optimize import least_squares

from benchtwin.bench import distributions as stats
from benchtwin.bench.air import SEED_DRAG
from benchtwin.bench.priors import stated_sd, unstated_sd
from benchtwin.infer.effect import Effect
from benchtwin.infer.evidence import UnknownScatter
from benchtwin.infer.linear import Reduced, stacked
from benchtwin.infer.problem import Problem
from benchtwin.infer.series import Locals, Series, problem_of
from benchtwin.rigs.roll.effects import EFFECTS
from benchtwin.rigs.roll.effects.shape_barrier import NAME, quadratures
from benchtwin.rigs.roll.model import OWN, Model, predict
from benchtwin.rigs.roll.run_noise import (
    RunNoise,
    row_weight,
    smooth_curves,
)
from benchtwin.rigs.roll.session import Run, Seed, weight_over_inertia

# Nuisances: sd about 0. Stated keys replace the centre (incline, length, air) or the sd
# (scale).
PRIORS = {
    "mu": 3.0,  # relative: flat, since it is measured
    "incline": stated_sd("incline") / math.sqrt(2),  # and as much each run's own
    "corner": unstated_sd("sharp-corner"),
}
STEADY_MU = 0.01  # initial, of seeds that stay on an incline of unknown angle
MU_SD = unstated_sd("rolling-scatter")
STEADY_DEG = 0.01  # least sd of the incline from run to run
GATE_SD_M = unstated_sd("gate-place") / 1000
LENGTH_SD_M = stated_sd("way-on-incline") / 1000
DEPTH_SD_M, ASTRAY_SD = unstated_sd("depth") / 1000, unstated_sd("astray")
GRAVITY_SD = unstated_sd("gravity")  # acts as the scale does
CUT = unstated_sd("corner-cut")  # centre and sd
FREE_SCALE_SD = 3.0  # where the unit of length or of time is unknown
OWN_STEP = np.array(
    [1e-7, 1e-8, 1e-8, 1e-5, 1e-6, 1e-5, 1e-6, 1e-6, 1e-5]
)  # of derivatives by locals
# by globals, in prior sds: short, since slope and friction differ by 1e-3 of their
# effect only
STEP = 1e-5
PUSH = 1e-6  # over weight, for derivatives: 1e-4 of friction


def build(
    runs: tuple[Run, ...],
    seed: Seed,
    turn: np.ndarray,
    phase: np.ndarray,
    *,
    ripple: bool,
) -> Model:
    """The model with all globals that this session can say something about."""
    f = weight_over_inertia(seed)
    told = [r.way.slowing / f for r in runs if not r.stays]
    told = told or [
        math.tan(r.incline) - r.way.acceleration / f / math.cos(r.incline)
        for r in runs
        if math.isfinite(r.incline)
    ]
    mu = float(
        np.clip(
            np.median(told or [STEADY_MU]),
            1e-4 if any(not r.stays for r in runs) else STEADY_MU,
            0.5,
        )
    )
    incline, length = [], []
    for run in runs:
        drive = min(run.way.acceleration / f, 0.95)
        incline.append(
            run.incline
            if math.isfinite(run.incline)
            else math.asin(drive) + math.atan(mu)
        )
        longer = (
            run.way.way_down
            if run.stays or not math.isfinite(run.length)
            else run.length
        )
        length.append(
            max(longer, run.length)
            if run.stays and math.isfinite(run.length)
            else longer
        )
    speeds = [
        math.sqrt(2 * f * max(math.sin(b) - mu * math.cos(b), 0.01) * s)
        for b, s in zip(incline, length, strict=True)
    ]
    sessions = tuple(dict.fromkeys(f"scale.{run.session}" for run in runs))
    effects = {
        n: e for n, e in EFFECTS.items() if e.needs is None or e.needs(runs, seed)
    }
    effects = {n: e for n, e in effects.items() if not e.group or e.group in effects}
    effects = effects | quadratures(len(runs)) if ripple else effects
    if not ripple:
        effects.pop(NAME, None)
    passed = Counter(gate for run in runs for gate in run.gate_of)
    # of one run alone, what its gates are off is in its noise
    gates = tuple(name for name, times in passed.items() if times > 1)
    names = (
        *effects,
        "mu",
        "incline",
        "level",
        "inertia",
        "corner",
        *sessions,
        *(("air",) if seed.drag else ()),
        *gates,
    )
    return Model(
        runs,
        seed,
        mu,
        np.array(incline),
        np.array(length),
        turn,
        phase,
        names,
        1.6 * max(speeds),
        effects,
    )


def level_sd_deg(stated: bool, both_ways: bool) -> float:
    """How level a plate is beside what is stated or, in both directions, named."""
    if stated:
        return stated_sd("level-plate")
    return unstated_sd("level-both-ways" if both_ways else "level-plate")


def roll_problem(model: Model, scales: dict[str, float], noise: RunNoise) -> Problem:
    """scales: relative sd of each session's scale."""
    effects, seed = model.effects, model.seed
    known = PRIORS | {
        "inertia": seed.inertia_sd,
        "level": level_sd_deg(
            all(math.isfinite(run.slope) for run in model.runs),
            len({run.sign for run in model.runs}) > 1,
        ),
    }
    known |= {f"scale.{s}": math.hypot(sd, GRAVITY_SD) for s, sd in scales.items()}
    sizes = {
        "mu": 0.1,
        "incline": 0.1,
        "level": known["level"],
        "inertia": 0.01,
        "corner": 1.0,
    } | {f"scale.{s}": 1e-3 for s in scales}
    if seed.drag:
        known["air"], sizes["air"] = seed.drag_sd / seed.drag, seed.drag_sd / seed.drag
    gates = [n for n in model.names if n.startswith("gate.")]
    known |= dict.fromkeys(gates, GATE_SD_M)
    sizes |= dict.fromkeys(gates, GATE_SD_M)
    own_shape = [n for n, e in effects.items() if e.group == NAME]
    if (
        own_shape and np.isfinite(seed.rise_mm) and not seed.round
    ):  # as its stated shape makes it
        known |= dict.fromkeys(own_shape, seed.rise_mm / math.sqrt(2)) | {"oval": 1.0}
        sizes["oval"] = 1.0
    own = locals_of(model)
    model = replace(model, names=(*effects, *sizes), seen={})
    starts = np.array(
        [_fit_alone(model, r, own, noise) for r in range(len(model.runs))]
    )
    steady = np.where(
        np.array(OWN) == "incline_deg", incline_scatter_deg(model.runs, starts), np.inf
    )
    own = replace(own, sd=np.minimum(own.sd, steady))
    series = tuple(
        Series(
            run.recording,
            *seen_rows(run, noise.sigma[r] * row_weight(run)),
            noise.noise,
            smooth_curves(run),
            known=int(run.junction is not None),
        )
        for r, run in enumerate(model.runs)
    )
    made = problem_of(
        "roll",
        series,
        own,
        partial(predict, model),
        effects,
        sizes,
        known,
        model,
        max_iterations=20,
        step=STEP,
    )

    def with_effect(effect: Effect) -> Problem:
        more = replace(model, effects=effects | {effect.name: effect})
        return roll_problem(more, scales, noise)

    return replace(
        made, starts=starts, unknown_scatter=unknown_scatter, with_effect=with_effect
    )


def seen_rows(run: Run, sigma: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Places, sds and lags of a run's rows, the junction's last where it was seen."""
    if run.junction is None:
        return run.x, sigma, run.lag
    more = zip((run.x, sigma, run.lag), (*run.junction, np.inf), strict=True)
    x, sigma, lag = (np.append(rows, value) for rows, value in more)
    return x, sigma, lag


def unknown_scatter(problem: Problem, reduced: tuple[Reduced, ...]) -> UnknownScatter:
    """Rows' change by one MU_SD of each run's own rolling friction."""
    return UnknownScatter(stacked(reduced)[0][:, problem.names.index("mu")] * MU_SD)


def _fit_alone(model: Model, r: int, own: Locals, noise: RunNoise) -> np.ndarray:
    """Run r's locals fitted to it alone, to begin near the joint minimum."""
    run, nil = model.runs[r], {n: 0.0 for n in model.names}
    loose = np.array([np.inf, np.inf, own.sd[2], 5 * own.sd[3], 0.3, *own.sd[5:]])
    unit = np.array([1e-3, 1e-4, 1e-3, 0.1, 0.03, 0.03, DEPTH_SD_M, ASTRAY_SD, 0.1])
    data, sigma, _ = seen_rows(run, noise.sigma[r] * row_weight(run))
    sigma = np.hypot(sigma, 1e-5)

    def misfit(u: np.ndarray) -> np.ndarray:
        at = own.start[r] + unit * u
        return np.concatenate(
            [(data - predict(model, r, at, nil)) / sigma, unit * u / loose]
        )

    return (
        own.start[r]
        + unit
        * least_squares(
            misfit, np.zeros(len(OWN)), method="lm", diff_step=1e-5, max_nfev=60
        ).x
    )


def locals_of(model: Model) -> Locals:
    """Each run's initial locals and their prior sds."""
    start, f = [], weight_over_inertia(model.seed)
    for r, run in enumerate(model.runs):
        b, s, way = model.incline[r], model.length[r], run.way
        release, place = way.release, way.place
        stated = math.isfinite(run.length) or math.isfinite(run.incline)
        # the track begins behind the corner: extrapolated from stated keys
        if stated and way.corner < run.time_s[0]:
            top = math.sqrt(2 * f * max(math.sin(b) - model.mu * math.cos(b), 0.01) * s)
            release = way.stop - top / (f * model.mu) - 2 * s / top
            place = run.x[-1] - top**2 / (2 * f * model.mu) - s
        start.append([release, place, *np.zeros(len(OWN) - 3), CUT])
    length_stated = all(math.isfinite(run.length) for run in model.runs)
    incline_stated = all(math.isfinite(run.incline) for run in model.runs)
    length_sd = LENGTH_SD_M if length_stated else unstated_sd("way-on-incline") / 1000
    incline_sd = PRIORS["incline"] if incline_stated else unstated_sd("incline")
    sd = [
        np.inf,
        np.inf,
        length_sd,
        incline_sd,
        MU_SD,
        SEED_DRAG,
        DEPTH_SD_M,
        ASTRAY_SD,
        CUT,
    ]
    return Locals(np.array(start), OWN_STEP, np.array(sd))


def incline_scatter_deg(runs: tuple[Run, ...], starts: np.ndarray) -> float:
    """Upper bound of the sd of a run's incline about that of runs alike; inf for too
    few."""
    kinds: dict[tuple, list[float]] = {}
    for run, value in zip(runs, starts[:, OWN.index("incline_deg")], strict=True):
        kinds.setdefault((run.sign, run.incline, run.length), []).append(value)
    square = sum(float(((np.array(v) - np.mean(v)) ** 2).sum()) for v in kinds.values())
    freedom = len(runs) - len(kinds)
    if freedom < 2:
        return math.inf
    wider = stats.t.ppf(0.975, freedom) / stats.norm.ppf(0.975)
    return max(STEADY_DEG, math.sqrt(square / freedom) * wider)
