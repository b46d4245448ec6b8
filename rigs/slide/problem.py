"""The slide as a problem: nuisances, noise, initial onsets."""

import math
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from numpy.polynomial import legendre

from benchtwin.bench.constants import G_M_S2
from benchtwin.bench.priors import stated_sd, unstated_sd
from benchtwin.bench.robust import difference_noise
from benchtwin.infer.effect import Effect
from benchtwin.infer.evidence import UnknownScatter
from benchtwin.infer.linear import Reduced, stacked
from benchtwin.infer.noise import (
    LOCK_PX,
    Noise,
    Stretch,
    estimate,
    frame_lag,
    outliers,
    refined_level_sd,
)
from benchtwin.infer.own_scatter import own_scatter
from benchtwin.infer.problem import Fit, Problem, fit
from benchtwin.infer.series import Locals, Series
from benchtwin.infer.series import problem_of as series_problem
from benchtwin.rigs.slide.effects import EFFECTS
from benchtwin.rigs.slide.model import LOCALS, OWN, SHAPES, Model, predict, run_motion
from benchtwin.rigs.slide.modes import MOVING, Motion, in_motion, likeliest
from benchtwin.rigs.slide.session import (
    LEAST_REST,
    LEAST_SLIDING,
    SETTLES_S,
    SETTLING_S,
    WAVES,
    Read,
    Run,
    Session,
    slide_end,
)

# Nuisances: sd about 0. Stated keys replace the sd (scale) or the centre (air, tilt).
PRIORS = {
    "friction": 1.0,  # of the pair: flat, since it is measured
    "plate": stated_sd("level-plate"),  # [deg], beside its stated angle
    "scale": unstated_sd("scale"),
    "lens": unstated_sd("lens"),
    "perspective": unstated_sd("perspective"),
    "air": 1.0,  # times session.AirDrag.sd
    "air-shade": unstated_sd("drag-shade"),
    "climb": unstated_sd("step-climb"),
    "reader": unstated_sd("reader-zero"),
}
RUN_SD = unstated_sd("friction-scatter")
# frictions of a slide's own: steady, waves along it, pulses at its start
KINDS = (1, WAVES, len(SETTLES_S) - 2)
READER_ROWS = 4  # rows that this is worth beside the readings' own scatter
DEGREE = 8  # of the curve about which noise is estimated
# of runs of few rows: degree of the curve; sd where it cannot be estimated
FEW_DEGREE = 2
FEW_SD_MM = 0.5
EXACT_MM = 1e-4  # floor for simulated tracks
FLAT_PRIOR_MM, FLAT_PRIOR_S = 1e3, 1e3
MAX_ITERATIONS = 30  # onset and air beside a plate converge slowly
LAGS = (
    -1.5,
    -0.75,
    0.0,
    0.75,
    1.5,
)  # trial places on a step at which a block lets go [sd]
STEP = 1e-5  # of a prior's sd, for derivatives


@dataclass(frozen=True, eq=False)
class Prepared:
    """A session without outliers, noise common to its runs, sigma (n,) [mm] of each
    run's rows."""

    session: Session
    noise: Noise
    sigma: tuple[np.ndarray, ...]
    shared: tuple[float, ...] = ()  # sd of each friction that all share, in own sds


def prepare(session: Session) -> Prepared:
    """Noise of all runs: about the place of rest, and about a flexible curve from the
    onset on."""
    if not session.runs:
        return Prepared(session, _white(session), ())
    ended = tuple(until_its_end(r) if r.in_motion else r for r in session.runs)
    session = replace(session, runs=ended)
    noise = estimate([part for run in session.runs for part in stretches(run)])
    kept, sigma = [], []
    pooled = _pooled([run for run in session.runs if has_few_rows(run)])
    for run in session.runs:
        if has_few_rows(run):
            kept.append(run)
            sigma.append(np.full(len(run.time), pooled))
            continue
        good = np.concatenate(
            [~outliers(part.residual(noise)[0]) for part in stretches(run)]
        )
        clean = rows_of(run, good)
        kept.append(clean)
        sigma.append(_sigma(clean, noise))
    return Prepared(replace(session, runs=tuple(kept)), noise, tuple(sigma))


def rows_of(run: Run, rows: np.ndarray) -> Run:
    """Some rows (n,) of a run."""
    rest, ended = run.moving.start, run.moving.stop
    return replace(
        run,
        time=run.time[rows],
        travel=run.travel[rows],
        frame=run.frame[rows],
        lock=run.lock[rows],
        rest=int(rows[:rest].sum()),
        ended=int(rows[ended:].sum()),
    )


def alone(run: Run, model: Model, sigma: np.ndarray) -> Motion:
    """One run as `modes` fits it."""
    model = replace(model, session=Session((run,), (), (), ()), seen={})
    return Motion(model, sigma, frame_lag(run.frame))


def until_its_end(run: Run) -> Run:
    """A run on a plate that stands, cut where the block meets something; where it comes
    to rest is told."""
    noise = difference_noise(run.travel, 2)
    met = slide_end(run.time, run.travel, noise)
    met = met if met >= LEAST_SLIDING // 2 else len(run.time)
    motion = alone(run, Model(Session((run,), (), (), ()), 0.0), np.ones(len(run.time)))
    best, _, end = likeliest(motion, [MOVING], met)
    way = best.motion.way_mm(MOVING, best.own)
    resting = int((way[1:] >= way[-1]).sum()) - 1  # rows after that of the stop
    cut = rows_of(run, np.arange(len(run.time)) < end)
    return replace(cut, ended=max(resting, 0))


def _pooled(runs: list[Run]) -> float:
    """σ [mm] of rows of all short runs, about a parabola each."""
    found = [
        part.residual(Noise(0.0, 0.0, 0.0)) for run in runs for part in stretches(run)
    ]
    spare = sum(n for _, n in found)
    if spare:
        return max(math.sqrt(sum(float(v @ v) for v, _ in found) / spare), EXACT_MM)
    return FEW_SD_MM


def stretches(run: Run) -> list[Stretch]:
    """Rest, if seen, motion, and rest again of a run."""
    out = []
    parts = (
        (slice(0, run.rest), 0),
        (run.moving, DEGREE),
        (slice(run.moving.stop, None), 0),
    )
    for part, degree in parts:
        t = run.time[part]
        if not len(t):  # light gates see no rest
            continue
        t = (t - t[0]) / max(t[-1] - t[0], 1e-9) * 2 - 1
        degree = min(degree, FEW_DEGREE if has_few_rows(run) else max(len(t) // 6, 0))
        design = legendre.legvander(t, degree)
        crossed = float(np.ptp(run.travel[part])) > DEGREE * float(
            np.hypot(*run.lock[0])
        )
        # waves finer than the curve
        if crossed and run.lock.any() and not has_few_rows(run):
            design = np.column_stack([design, run.lock[part]])
        if run.in_motion and degree and not has_few_rows(run):
            pulses = wander_of(run, 1.0)[part, 1 + WAVES :]
            design = np.column_stack([design, pulses])
        out.append(Stretch(design, run.travel[part], frame_lag(run.frame[part])))
    return out


def has_few_rows(run: Run) -> bool:
    """Whether a run has so few rows that each is independent."""
    return len(run.time) < LEAST_SLIDING + LEAST_REST


def _sigma(run: Run, noise: Noise) -> np.ndarray:
    """At rest and in motion separately where both are long, else together."""
    found = [part.residual(noise) for part in stretches(run)]
    left, spare = [float((r**2).sum()) for r, _ in found], [n for _, n in found]
    both = math.sqrt(sum(left) / max(sum(spare), 1))
    apart = all(n >= 60 for n in spare)
    each = [
        math.sqrt(p / n) if apart else both for p, n in zip(left, spare, strict=True)
    ]
    counts = [len(part.data) for part in stretches(run)]
    return np.maximum(np.repeat(each, counts), EXACT_MM)


def problem_of(prepared: Prepared, model: Model, starts: np.ndarray) -> Problem:
    """starts (R, LOCALS): from `initial_onsets`."""
    session = prepared.session
    series = [
        _series(run, prepared, prepared.sigma[k]) for k, run in enumerate(session.runs)
    ]
    series += [_reading(read, prepared, model.stair_deg) for read in session.reads]
    sds = [FLAT_PRIOR_MM, FLAT_PRIOR_S, 1.0, 1.0, 1.0, LOCK_PX, LOCK_PX]
    steps = [1e-3, 1e-6, 1e-4, 1e-4, 1e-2, 1e-3, 1e-3]
    count = max((run.wander.shape[1] for run in session.runs), default=0)
    sds, steps = sds + count * [1.0], steps + count * [1.0]
    starts = np.column_stack([starts, np.zeros((len(starts), count))])
    middle = starts * (np.arange(len(sds)) < 2)
    own = Locals(middle, np.array(steps), np.array(sds))
    known = _known(session, model) | dict(zip(SHAPES, prepared.shared))
    sizes = {n: 0.01 if n == "friction" else PRIORS[n] for n in PRIORS if n in known}
    sizes |= {n: 1.0 for n in SHAPES if n in known}
    problem = series_problem(
        "slide",
        tuple(series),
        own,
        partial(predict, model),
        model.effects,
        sizes,
        known,
        model,
        max_iterations=MAX_ITERATIONS,
        step=STEP,
        smooth=True,
    )
    # that of readings is in their sd
    tracks = refined_level_sd(prepared.noise.log_level_sd, DEGREE * len(session.runs))
    level_sd = tracks if session.runs else problem.level_sd

    def with_effect(effect: Effect) -> Problem:
        more = replace(model, effects=model.effects | {effect.name: effect}, seen={})
        return problem_of(prepared, more, starts[:, :LOCALS])

    return replace(
        problem,
        starts=starts,
        unknown_scatter=unknown_scatter,
        level_sd=level_sd,
        with_effect=with_effect,
    )


def with_scatter(prepared: Prepared, problem: Problem) -> Prepared:
    """The session with the scatter of friction along each slide, as all of them show
    it, and what of it they may have in common."""
    sd, usual = scatter_beside(prepared, fit(problem))
    if not sd[1:].any():  # that of a steady one is summed over
        return prepared
    # of few slides the own size is told badly, and by little what they share
    ratio = np.maximum(usual / np.where(sd > 0, sd, np.inf), 1.0)[1:]
    shared = tuple(float(r) for r in unstated_sd("friction-shared") * ratio)
    runs = tuple(
        replace(run, wander=(own * sd)[:, 1:])
        for run, own in zip(prepared.session.runs, wanders(prepared), strict=True)
    )
    session = replace(prepared.session, runs=runs)
    return replace(prepared, session=session, shared=shared)


def wanders(prepared: Prepared) -> list[np.ndarray]:
    """`wander_of` each run."""
    runs = prepared.session.runs
    longest = max(float(np.ptp(run.time[run.moving])) for run in runs)
    return [wander_of(run, longest) for run in runs]


def scatter_beside(prepared: Prepared, found: Fit) -> tuple[np.ndarray, np.ndarray]:
    """sd (K,) of frictions along the slides, beside a fit and all that is common; and
    the usual one."""
    problem, session = found.problem, prepared.session
    extra = []
    for own in wanders(prepared):
        own = np.vstack([own, np.zeros(own.shape[1])])
        extra.append(np.column_stack([own[:, : WAVES + 1], own]))
    to_rest = any(run.in_motion for run in session.runs)
    along = "friction-to-rest" if to_rest else "friction-within-run"
    usual = [RUN_SD, unstated_sd(along), unstated_sd("friction-settling")]
    usual, always = np.repeat([usual, [False, to_rest, False]], KINDS, axis=1)
    width = WAVES + 1 + len(usual)
    extra += [np.zeros((len(r.angles), width)) for r in session.reads]
    reduced = problem.reduce(found.starts, found.values, extra)[0]
    common = len(problem.names) + WAVES + 1
    return own_scatter(reduced, common, usual, always > 0).sd, usual


def wander_of(run: Run, longest_s: float) -> np.ndarray:
    """Travel (n, K) [mm] by frictions of size 1: a steady one, WAVES of mean 0 by the
    time from the moment it rests (longest_s: of all), and pulses at its start where it
    was set in motion."""
    out = np.zeros((len(run.time), sum(KINDS)))
    time = run.time[run.moving]
    from_rest = time[-1] - time if run.in_motion else time - time[0]
    along = 2 * from_rest / longest_s - 1
    pull = -G_M_S2 * math.cos(float(run.tilt.coefficients[0]))
    waves = legendre.legvander(along, WAVES).T
    shapes = [waves[0], *(waves[1:] - waves[1:].mean(1, keepdims=True))]
    for low, at, high in zip(SETTLES_S, SETTLES_S[1:], SETTLES_S[2:]):
        size = math.exp(-at / SETTLING_S)
        shape = np.interp(time - time[0], [low, at, high], [0.0, size, 0.0])
        shapes.append(shape * run.in_motion)
    for k, shape in enumerate(shapes):
        out[run.moving, k] = travelled_mm(time, pull * shape)
    out[run.moving.stop :] = out[run.moving.stop - 1]
    return out


def travelled_mm(time: np.ndarray, push: np.ndarray) -> np.ndarray:
    """Double integral (n,) [mm] of a push [m/s²], linear between rows."""
    h = np.diff(time)
    speed = np.concatenate([[0.0], np.cumsum(h * (push[1:] + push[:-1]) / 2)])
    way = np.cumsum(h * speed[:-1] + h**2 * (2 * push[:-1] + push[1:]) / 6)
    return 1e3 * np.concatenate([[0.0], way])


def effects_of(session: Session) -> dict:
    """Effects that these recordings can show."""
    found = {n: e for n, e in EFFECTS.items() if e.needs is None or e.needs(session)}
    return {n: e for n, e in found.items() if not e.group or e.group in found}


def _known(session: Session, model: Model) -> dict[str, float]:
    """sd of each global that every bench has."""
    names = {"friction"}
    if any(r.in_motion and not r.tilt.sensor for r in session.runs):
        names |= {"plate"}
    if session.runs:
        names |= {"scale", "lens", "perspective", "air"}
        names |= {"air-shade"} if any(r.air.count > 1 for r in session.runs) else set()
    names |= {"climb"} if model.stair_deg else set()
    known = {n: PRIORS[n] for n in PRIORS if n in names}
    if session.runs:
        known["scale"] = float(np.median([r.scale_sd for r in session.runs]))
        column = float(np.median([r.tilt.grid_deg for r in session.runs]))
        step = 0.0 if model.stair_deg else unstated_sd("column-step") * column
        sensor = math.hypot(unstated_sd("tilt-sensor-zero"), step)
        known |= {
            n: sensor for n, e in model.effects.items() if e.tilt and e.unit == "deg"
        }
    if session.reads:
        grid = 0.0 if model.stair_deg else max(r.grid_deg for r in session.reads)
        known["reader"] = math.hypot(
            PRIORS["reader"], unstated_sd("reader-step") * grid
        )
    return known


def unknown_scatter(problem: Problem, reduced: tuple[Reduced, ...]) -> UnknownScatter:
    """Rows' change by one RUN_SD of each run's friction; readings have it in their own
    scatter."""
    runs = len(problem.model.session.runs)
    tracked = np.concatenate(
        [np.full(len(r.b), k < runs) for k, r in enumerate(reduced)]
    )
    return UnknownScatter(
        stacked(reduced)[0][:, problem.names.index("friction")] * RUN_SD * tracked
    )


def _series(run: Run, prepared: Prepared, sigma: np.ndarray) -> Series:
    """The track's rows, and the run's friction, which is the pair's within RUN_SD."""
    lag = np.append(frame_lag(run.frame), np.inf)
    wander = np.vstack([run.wander, np.zeros(run.wander.shape[1])]).T
    return Series(
        run.recording,
        np.append(run.travel, 0.0),
        np.append(sigma, RUN_SD),
        lag,
        prepared.noise,
        np.zeros((len(lag), 0)),
        {LOCALS + k: column for k, column in enumerate(wander)}
        | dict(zip(SHAPES, wander)),
    )


def _reading(read: Read, prepared: Prepared, stair_deg: float) -> Series:
    """Readings scatter by the runs' friction, the reader and the grid, or more if they
    show it."""
    reads = prepared.session.reads
    friction = math.tan(math.radians(float(np.median(read.angles))))
    grid = max(read.grid_deg, stair_deg) / math.sqrt(12)
    floor = math.hypot(
        math.degrees(RUN_SD / (1 + friction**2)), unstated_sd("reading"), grid
    )
    spare = sum(len(r.angles) - 1 for r in reads)
    about = sum(float(((r.angles - r.angles.mean()) ** 2).sum()) for r in reads)
    sigma = math.sqrt(
        max(floor**2, (about + READER_ROWS * floor**2) / (spare + READER_ROWS))
    )
    n = len(read.angles)
    lag = frame_lag(np.arange(n))
    noise = _white(prepared.session)
    return Series(read.recording, read.angles, sigma, lag, noise, np.ones((n, 1)))


def _white(session: Session) -> Noise:
    spare = sum(len(r.angles) - 1 for r in session.reads)
    return Noise(0.0, 0.0, math.sqrt(2 / (spare + 10)))


def initial_onsets(prepared: Prepared, model: Model) -> tuple[Model, np.ndarray]:
    """Model with the pair's friction, and starts (R, LOCALS) from each run alone."""
    session = prepared.session
    model = replace(model, session=session)
    starts = np.zeros((len(session.runs) + len(session.reads), LOCALS))
    frictions = [
        math.tan(math.radians(float(np.median(r.angles)))) for r in session.reads
    ]
    for k, run in enumerate(session.runs):
        if run.in_motion:
            found = in_motion(alone(run, model, prepared.sigma[k]), MOVING).own
            starts[k, :2] = found["place"], found["speed"]
            frictions.append(found["friction"])
            continue
        starts[k, 0], starts[k, 1], friction, _, starts[k, 4] = _onset(
            model, prepared, k, jump=False
        )
        frictions.append(friction)
    model = replace(model, friction=float(np.median(frictions)))
    for k, run in enumerate(session.runs):
        if run.in_motion:
            starts[k, 4] = (frictions[len(session.reads) + k] - model.friction) / OWN
    return model, starts


def initial_onsets_with_jump(
    prepared: Prepared, model: Model, starts: np.ndarray
) -> tuple[np.ndarray, float]:
    """Starts of runs that lose friction at onset, another minimum of χ²; median
    loss."""
    starts, lost = starts.copy(), []
    for k, run in enumerate(prepared.session.runs):
        if run.in_motion:
            continue
        starts[k, 0], starts[k, 1], _, jump, _ = _onset(model, prepared, k, jump=True)
        lost.append(jump)
    return starts, float(np.median(lost)) if lost else 0.0


def _onset(
    model: Model, prepared: Prepared, r: int, *, jump: bool
) -> tuple[float, float, float, float, float]:
    """Of a run: place at rest [mm], onset [s], friction, its loss, place on a step
    [sd]."""
    run, sigma = prepared.session.runs[r], prepared.sigma[r]
    time = run.time - run.tilt.origin

    def misfit(onset: float, lag: float = 0.0) -> tuple[float, float, float, float]:
        way, _, friction = run_motion(
            model, r, np.array([0.0, onset, 0.0, 0.0, lag, 0.0, 0.0]), {}
        )
        columns = [np.ones(len(time))] + (
            [np.clip(time - onset, 0, None) ** 2] if jump else []
        )
        design = np.column_stack(columns) / sigma[:, None]
        left = (run.travel - 1e3 * way) / sigma
        solution = np.linalg.lstsq(design, left, rcond=None)[0]
        if jump and solution[1] < 0:  # friction does not increase at the onset
            solution = np.array(
                [left @ design[:, 0] / (design[:, 0] @ design[:, 0]), 0.0]
            )
        if jump:
            lost = 2e-3 * float(solution[1]) * math.hypot(1.0, friction) / G_M_S2
        else:
            lost = 0.0
        return (
            float(((left - design @ solution) ** 2).sum()),
            float(solution[0]),
            friction,
            lost,
        )

    grid = np.linspace(time[0], time[0] + 0.9 * (time[-1] - time[0]), 60)
    for _ in range(5):
        at = int(np.argmin([misfit(t)[0] for t in grid]))
        grid = np.linspace(grid[max(at - 1, 0)], grid[min(at + 1, len(grid) - 1)], 15)
    lags = LAGS if model.stair_deg else (0.0,)
    fine = np.linspace(grid[0], grid[-1], 9) + (
        grid[1] - grid[0] if model.stair_deg else 0.0
    ) * np.arange(-4, 5)
    best = min(
        (misfit(t, lag)[0], t, lag)
        for t in (fine if model.stair_deg else grid[7:8])
        for lag in lags
    )
    _, place, friction, lost = misfit(*best[1:])
    return place, float(best[1]), friction, lost, float(best[2])
