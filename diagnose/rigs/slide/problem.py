"""The slide as a problem: what every bench has, with priors; its noise; the runs' onsets to begin with."""

import math
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from numpy.polynomial import legendre

from diagnose.air import G_M_S2
from diagnose.effects.slide import EFFECTS
from diagnose.engine.evidence import Spread
from diagnose.engine.linear import Reduced, stacked
from diagnose.engine.noise import LOCK_PX, Noise, Stretch, estimate, frame_lag, spikes, told_by
from diagnose.engine.problem import Problem
from diagnose.engine.series import Locals, Series
from diagnose.engine.series import problem_of as series_problem
from diagnose.rigs.slide.model import LOCALS, Model, moved, predict
from diagnose.rigs.slide.session import LEAST_REST, LEAST_SLIDING, Read, Run, Session

# What every bench has, about nil: sd, unit, why. What a bench states replaces the sd (scale) or the centre (air, tilt).
PRIORS = {
    "friction": 1.0,  # of the pair: it is measured here
    "scale": 0.01,  # relative; a stated mm_per_px_sd replaces it
    "lens": 2e-4,  # distortion at the picture's edge, of a good lens
    "perspective": 1e-3,  # per metre: a camera that looks straight on
    "air": 1.0,  # of what a lone seed's drag beside a plate is uncertain by (session.BESIDE_PLATE_SD)
    "air-shade": 1.0,  # among n seeds each is blown at by n^0 to n^-1/2
    "climb": 1.0,  # of ln of the time in which a plate that is raised in stairs climbs one, over model.CLIMB_S
    "reader": 0.1,  # deg: of a protractor's zero; and, read to a grid, a quarter of it (to nearest, or cut, or upward)
}
SENSOR_DEG = 0.05  # of a tilt sensor, common to all runs; and a quarter of a coarse column's grid
GRID_SHARE = 0.25
RUN_SD = 0.003  # of a run's friction about the pair's; larger scatter is a variance component (evidence.SCATTERS)
READING_SD_DEG = 0.03  # of a reader's own, beside the runs' scatter
READER_ROWS = 4  # rows that this is worth beside the readings' own scatter
DEGREE = 8  # of the curve beside which noise is what is left of a slide
FEW_DEGREE, FEW_SD_MM = 2, 0.5  # of runs of few rows: their curve; sd where nothing tells it
EXACT_MM = 1e-4  # a simulated track may be exact
ANYWHERE_MM, ANYWHEN_S = 1e3, 1e3
TURNS = 30  # of Gauss–Newton: an onset moves much for little, and what air does beside a plate gives way slowly
LAGS = (-1.5, -0.75, 0.0, 0.75, 1.5)  # tried of how far up a stair a block lets go [sd]
STEP = 1e-5  # of a prior's sd, for derivatives


@dataclass(frozen=True, eq=False)
class Prepared:
    """A session with its outliers gone, noise common to its runs, sigma (n,) [mm] of each run's rows."""

    session: Session
    noise: Noise
    sigma: tuple[np.ndarray, ...]


def prepare(session: Session) -> Prepared:
    """Noise of all runs together: about the place of rest, and about a flexible curve from the onset on, pixel lock beside it."""
    if not session.runs:
        return Prepared(session, _white(session), ())
    noise = estimate([part for run in session.runs for part in _stretches(run)])
    kept, sigma = [], []
    pooled = _pooled([run for run in session.runs if _few(run)])
    for run in session.runs:
        if _few(run):
            kept.append(run)
            sigma.append(np.full(len(run.time), pooled))
            continue
        good = np.concatenate([~spikes(part.residual(noise)[0]) for part in _stretches(run)])
        rest = int(good[: run.rest].sum())
        clean = replace(run, time=run.time[good], travel=run.travel[good], frame=run.frame[good], rest=rest, lock=run.lock[good])
        kept.append(clean)
        sigma.append(_sigma(clean, noise))
    return Prepared(replace(session, runs=tuple(kept)), noise, tuple(sigma))


def _pooled(runs: list[Run]) -> float:
    """σ [mm] of the rows of runs of few, all together: about a parabola each."""
    found = [part.residual(Noise(0.0, 0.0, 0.0)) for run in runs for part in _stretches(run)]
    spare = sum(n for _, n in found)
    return max(math.sqrt(sum(float(v @ v) for v, _ in found) / spare), EXACT_MM) if spare else FEW_SD_MM


def _stretches(run: Run) -> list[Stretch]:
    out = []
    for part, degree in ((slice(0, run.rest), 0), (slice(run.rest, None), DEGREE)):
        t = run.time[part]
        if not len(t):  # light gates see no rest
            continue
        t = (t - t[0]) / max(t[-1] - t[0], 1e-9) * 2 - 1
        degree = min(degree, FEW_DEGREE if _few(run) else max(len(t) // 6, 0))
        design = np.column_stack([legendre.legvander(t, degree), _ripple(run, part)])
        out.append(Stretch(design, run.travel[part], frame_lag(run.frame[part])))
    return out


def _few(run: Run) -> bool:
    """Whether it has so few rows that each stands for itself."""
    return len(run.time) < LEAST_SLIDING + LEAST_REST


def _ripple(run: Run, part: slice) -> np.ndarray:
    """Pixel lock (m, 2) where a block crosses more pixels than such a curve follows; else (m, 0)."""
    if _few(run):
        return run.lock[part, :0]
    crossed = float(np.ptp(run.travel[part])) > DEGREE * float(np.hypot(*run.lock[0]))
    return run.lock[part] if crossed and run.lock.any() else run.lock[part, :0]


def motion_of(run: Run) -> Stretch:
    """The slide of one run beside a flexible curve."""
    return _stretches(run)[-1]


def _sigma(run: Run, noise: Noise) -> np.ndarray:
    """At rest and in motion each its own where both are long enough to tell, else one."""
    found = [part.residual(noise) for part in _stretches(run)]
    left, spare = [float((r**2).sum()) for r, _ in found], [n for _, n in found]
    both = math.sqrt(sum(left) / max(sum(spare), 1))
    apart = all(n >= 60 for n in spare)
    each = [math.sqrt(p / n) if apart else both for p, n in zip(left, spare, strict=True)]
    return np.maximum(np.repeat(each, [run.rest, len(run.time) - run.rest]), EXACT_MM)


def problem_of(prepared: Prepared, model: Model, starts: np.ndarray) -> Problem:
    """starts (R, LOCALS): from `begin`."""
    session = prepared.session
    series = [_series(run, prepared, prepared.sigma[k]) for k, run in enumerate(session.runs)]
    series += [_reading(read, prepared, model.stair_deg) for read in session.reads]
    count = len(series)
    own = Locals(
        np.column_stack([starts[:, :2], np.zeros((count, LOCALS - 2))]), np.array([1e-3, 1e-6, 1e-4, 1e-4, 1e-2, 1e-3, 1e-3]),
        np.array([ANYWHERE_MM, ANYWHEN_S, 1.0, 1.0, 1.0, LOCK_PX, LOCK_PX]),
    )  # fmt: skip
    known = _known(session, model)
    sizes = {n: 0.01 if n == "friction" else PRIORS[n] for n in PRIORS if n in known}
    problem = series_problem(
        "slide", tuple(series), own, partial(predict, model), model.effects, sizes, known, model, turns=TURNS, step=STEP, smooth=True,
    )  # fmt: skip
    tracks = told_by(prepared.noise.log_level_sd, DEGREE * len(session.runs))  # of readings it is in their sd
    level_sd = tracks if session.runs else problem.level_sd
    return replace(problem, starts=starts, spread=spread, level_sd=level_sd)


def effects_of(session: Session) -> dict:
    """Those that these recordings can show."""
    found = {n: e for n, e in EFFECTS.items() if e.needs is None or e.needs(session)}
    return {n: e for n, e in found.items() if not e.group or e.group in found}


def _known(session: Session, model: Model) -> dict[str, float]:
    """sd of each global that every bench has."""
    names = {"friction"}
    if session.runs:
        names |= {"scale", "lens", "perspective", "air"}
        names |= {"air-shade"} if any(r.air.count > 1 for r in session.runs) else set()
    names |= {"climb"} if model.stair_deg else set()
    known = {n: PRIORS[n] for n in PRIORS if n in names}
    if session.runs:
        known["scale"] = float(np.median([r.scale_sd for r in session.runs]))
        column = float(np.median([r.tilt.grid_deg for r in session.runs]))
        sensor = math.hypot(SENSOR_DEG, 0.0 if model.stair_deg else GRID_SHARE * column)
        known |= {n: sensor for n, e in model.effects.items() if e.tilt and e.unit == "deg"}
    if session.reads:
        grid = 0.0 if model.stair_deg else max(r.grid_deg for r in session.reads)
        known["reader"] = math.hypot(PRIORS["reader"], GRID_SHARE * grid)
    return known


def spread(problem: Problem, reduced: tuple[Reduced, ...]) -> Spread:
    """What one RUN_SD of each run's own friction does; of readings, which are a run each, it stands in their own scatter."""
    runs = len(problem.model.session.runs)
    tracked = np.concatenate([np.full(len(r.b), k < runs) for k, r in enumerate(reduced)])
    return Spread(stacked(reduced)[0][:, problem.names.index("friction")] * RUN_SD * tracked)


def _series(run: Run, prepared: Prepared, sigma: np.ndarray) -> Series:
    """The track's rows, and the run's friction, which is the pair's within RUN_SD."""
    lag = np.append(frame_lag(run.frame), np.inf)
    return Series(run.recording, np.append(run.travel, 0.0), np.append(sigma, RUN_SD), lag, prepared.noise, np.zeros((len(lag), 0)))


def _reading(read: Read, prepared: Prepared, stair_deg: float) -> Series:
    """Readings scatter by the runs' friction, the reader and the grid; by more where they themselves say so."""
    reads = prepared.session.reads
    friction = math.tan(math.radians(float(np.median(read.angles))))
    grid = max(read.grid_deg, stair_deg) / math.sqrt(12)
    floor = math.hypot(math.degrees(RUN_SD / (1 + friction**2)), READING_SD_DEG, grid)
    spare = sum(len(r.angles) - 1 for r in reads)
    about = sum(float(((r.angles - r.angles.mean()) ** 2).sum()) for r in reads)
    sigma = math.sqrt(max(floor**2, (about + READER_ROWS * floor**2) / (spare + READER_ROWS)))
    n = len(read.angles)
    return Series(read.recording, read.angles, sigma, frame_lag(np.arange(n)), _white(prepared.session), np.ones((n, 1)))


def _white(session: Session) -> Noise:
    spare = sum(len(r.angles) - 1 for r in session.reads)
    return Noise(0.0, 0.0, math.sqrt(2 / (spare + 10)))


def begin(prepared: Prepared, model: Model) -> tuple[Model, np.ndarray]:
    """Model with the pair's friction, and starts (R, LOCALS): each run's onset where its travel alone fits best."""
    session = prepared.session
    model = replace(model, session=session)
    starts = np.zeros((len(session.runs) + len(session.reads), LOCALS))
    frictions = [math.tan(math.radians(float(np.median(r.angles)))) for r in session.reads]
    for k in range(len(session.runs)):
        starts[k, 0], starts[k, 1], friction, _, starts[k, 4] = _onset(model, prepared, k, jump=False)
        frictions.append(friction)
    return replace(model, friction=float(np.median(frictions))), starts


def begin_with_jump(prepared: Prepared, model: Model, starts: np.ndarray) -> tuple[np.ndarray, float]:
    """Starts where each run may gain an acceleration of its own at its onset, and the friction that this is (median): a block
    that lets go with a jump seems to let go earlier without one, and no step of a fit leads from the one onset to the other."""
    starts, lost = starts.copy(), []
    for k in range(len(prepared.session.runs)):
        starts[k, 0], starts[k, 1], _, jump, _ = _onset(model, prepared, k, jump=True)
        lost.append(jump)
    return starts, float(np.median(lost))


def _onset(model: Model, prepared: Prepared, r: int, *, jump: bool) -> tuple[float, float, float, float, float]:
    """Place at rest [mm], onset [s], friction of one run by itself, friction lost at the onset (nil without `jump`), and how far up a
    stair it lets go [sd]."""
    run, sigma = prepared.session.runs[r], prepared.sigma[r]
    time = run.time - run.tilt.origin

    def misfit(onset: float, lag: float = 0.0) -> tuple[float, float, float, float]:
        way, _, friction = moved(model, r, np.array([0.0, onset, 0.0, 0.0, lag, 0.0, 0.0]), {})
        columns = [np.ones(len(time))] + ([np.clip(time - onset, 0, None) ** 2] if jump else [])
        design, left = np.column_stack(columns) / sigma[:, None], (run.travel - 1e3 * way) / sigma
        solution = np.linalg.lstsq(design, left, rcond=None)[0]
        if jump and solution[1] < 0:  # friction that is greater in motion has no jump: the other minimum
            solution = np.array([left @ design[:, 0] / (design[:, 0] @ design[:, 0]), 0.0])
        lost = 2e-3 * float(solution[1]) * math.hypot(1.0, friction) / G_M_S2 if jump else 0.0
        return float(((left - design @ solution) ** 2).sum()), float(solution[0]), friction, lost

    grid = np.linspace(time[0], time[0] + 0.9 * (time[-1] - time[0]), 60)
    for _ in range(5):
        at = int(np.argmin([misfit(t)[0] for t in grid]))
        grid = np.linspace(grid[max(at - 1, 0)], grid[min(at + 1, len(grid) - 1)], 15)
    lags = LAGS if model.stair_deg else (0.0,)
    fine = np.linspace(grid[0], grid[-1], 9) + (grid[1] - grid[0] if model.stair_deg else 0.0) * np.arange(-4, 5)
    best = min((misfit(t, lag)[0], t, lag) for t in (fine if model.stair_deg else grid[7:8]) for lag in lags)
    _, place, friction, lost = misfit(*best[1:])
    return place, float(best[1]), friction, lost, float(best[2])
