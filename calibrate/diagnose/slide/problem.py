"""The slide as a problem: its noise, nuisances, and the runs' onsets to begin with."""

import math
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from numpy.polynomial import legendre

from calibrate.diagnose.noise import LOCK_PX, Noise, Stretch, estimate, frame_lag, spikes, whiten
from calibrate.diagnose.problem import Problem
from calibrate.diagnose.series import Locals, Series
from calibrate.diagnose.series import problem_of as series_problem
from calibrate.diagnose.slide.model import LOCALS, Model, moved, predict
from calibrate.diagnose.slide.motion import G_M_S2
from calibrate.diagnose.slide.session import RUN_SD, Read, Run, Session

DEGREE = 8  # of the curve beside which noise is what is left of a slide
BENDS = 6  # terms of a run's smooth curve beyond the baseline: accelerations of degree 0 to 5 from the onset on
LENS_SD, PERSPECTIVE_SD = 2e-4, 1e-3  # at the picture's edge; per metre
ANGLE_SD_DEG = 0.05  # of a tilt sensor, common to all
EXACT_MM = 1e-4  # a simulated track may be exact
ANYWHERE_MM, ANYWHEN_S, FRICTION_SD = 1e3, 1e3, 1.0
TURNS = 30  # of Gauss–Newton: an onset moves much for little, and what air does beside a plate gives way slowly
READING_SD_DEG = 0.03  # of a reader's own, beside the runs' scatter
NUISANCES = {"friction": 0.01, "lens": LENS_SD, "perspective": PERSPECTIVE_SD, "air": 1.0, "air-shade": 1.0, "scale": 1e-3}


@dataclass(frozen=True, eq=False)
class Prepared:
    """A session with its outliers gone, noise common to its runs, sigma (n,) [mm] of each run's rows."""

    session: Session
    noise: Noise
    sigma: tuple[np.ndarray, ...]


def prepare(session: Session) -> Prepared:
    """Noise of all runs together: about the place of rest, and about a flexible curve from the onset on, pixel lock beside it."""
    if not session.runs:
        spare = sum(len(r.angles) - 1 for r in session.reads)
        return Prepared(session, Noise(0.0, 0.0, math.sqrt(2 / (spare + 10))), ())
    noise = estimate([part for run in session.runs for part in _stretches(run)])
    kept, sigma = [], []
    for run in session.runs:
        good = np.concatenate([~spikes(_innovations(part, noise)) for part in _stretches(run)])
        rest = int(good[: run.rest].sum())
        clean = replace(run, time=run.time[good], travel=run.travel[good], frame=run.frame[good], rest=rest, lock=run.lock[good])
        kept.append(clean)
        sigma.append(_sigma(clean, noise))
    return Prepared(replace(session, runs=tuple(kept)), noise, tuple(sigma))


def _stretches(run: Run) -> list[Stretch]:
    out = []
    for part, degree in ((slice(0, run.rest), 0), (slice(run.rest, None), DEGREE)):
        t = run.time[part]
        t = (t - t[0]) / max(t[-1] - t[0], 1e-9) * 2 - 1
        degree = min(degree, max(len(t) // 6, 0))
        design = np.column_stack([legendre.legvander(t, degree), _ripple(run, part)])
        out.append(Stretch(design, run.travel[part], frame_lag(run.frame[part])))
    return out


def _ripple(run: Run, part: slice) -> np.ndarray:
    """Pixel lock (m, 2) where a block crosses more pixels than such a curve follows; else (m, 0)."""
    crossed = float(np.ptp(run.travel[part])) > DEGREE * float(np.hypot(*run.lock[0]))
    return run.lock[part] if crossed and run.lock.any() else run.lock[part, :0]


def motion_of(run: Run) -> Stretch:
    """The slide of one run beside a flexible curve."""
    return _stretches(run)[1]


def _innovations(stretch: Stretch, noise: Noise) -> np.ndarray:
    both = np.column_stack([stretch.design, stretch.data])[:, None, :]
    clean = whiten(both, stretch.lag[:, None], noise.rho, noise.white)[0][:, 0]
    return clean[:, -1] - clean[:, :-1] @ np.linalg.lstsq(clean[:, :-1], clean[:, -1], rcond=None)[0]


def _sigma(run: Run, noise: Noise) -> np.ndarray:
    """At rest and in motion each its own where both are long enough to tell, else one."""
    left, spare = [], []
    for part in _stretches(run):
        left.append(float((_innovations(part, noise) ** 2).sum()))
        spare.append(len(part.data) - part.design.shape[1])
    both = math.sqrt(sum(left) / max(sum(spare), 1))
    apart = all(n >= 60 for n in spare)
    each = [math.sqrt(p / n) if apart else both for p, n in zip(left, spare, strict=True)]
    return np.maximum(np.repeat(each, [run.rest, len(run.time) - run.rest]), EXACT_MM)


def problem_of(prepared: Prepared, model: Model, starts: np.ndarray) -> Problem:
    """starts (R, LOCALS): from `begin`."""
    session = prepared.session
    series = [_series(model, k, prepared, starts[k]) for k in range(len(session.runs))]
    series += [_reading(read, prepared) for read in session.reads]
    count = len(series)
    own = Locals(
        np.column_stack([starts[:, :2], np.zeros((count, LOCALS - 2))]), np.array([1e-3, 1e-6, 1e-4, 1e-4, 1e-2, 1e-3, 1e-3]),
        np.array([ANYWHERE_MM, ANYWHEN_S, 1.0, 1.0, 1.0, LOCK_PX, LOCK_PX]),
    )  # fmt: skip
    known = {"friction": FRICTION_SD}
    if session.runs:
        scale = float(np.median([r.scale_sd for r in session.runs]))
        known |= {"scale": scale, "lens": LENS_SD, "perspective": PERSPECTIVE_SD, "air": 1.0}
        known |= {"air-shade": 1.0} if any(r.air.count > 1 for r in session.runs) else {}
    if "angle-offset" in model.effects:
        known["angle-offset"] = ANGLE_SD_DEG
    problem = series_problem(
        "slide", tuple(series), own, partial(predict, model), model.effects, {n: s for n, s in NUISANCES.items() if n in known},
        known, model, turns=TURNS, step=1e-5, smooth=True,
    )  # fmt: skip
    return replace(problem, starts=starts)


def _series(model: Model, r: int, prepared: Prepared, start: np.ndarray) -> Series:
    """The track's rows, and the run's friction, which is the pair's within RUN_SD."""
    run = prepared.session.runs[r]
    lag = np.append(frame_lag(run.frame), np.inf)
    onset = 0.0 if model.stairs else start[1]
    smooth = np.vstack([bends(run, onset), np.zeros(BENDS)])
    return Series(run.recording, np.append(run.travel, 0.0), np.append(prepared.sigma[r], RUN_SD), lag, prepared.noise, smooth)


def bends(run: Run, onset: float) -> np.ndarray:
    """Travel (n, BENDS) [mm] that accelerations of Legendre's form add from the onset on."""
    since = run.time - run.tilt.origin - onset
    s = np.clip(since / max(since[-1], 1e-9), 0.0, None)
    polynomials = [legendre.Legendre.basis(k, domain=[0, 1]).integ(2, lbnd=0) for k in range(BENDS)]
    return 1e3 * np.column_stack([p(s) for p in polynomials])


def _reading(read: Read, prepared: Prepared) -> Series:
    """Readings scatter by the runs' friction and the reader; by more where they themselves say so."""
    reads = prepared.session.reads
    friction = math.tan(math.radians(float(np.median(read.angles))))
    floor = math.hypot(math.degrees(RUN_SD / (1 + friction**2)), READING_SD_DEG)
    spare = sum(len(r.angles) - 1 for r in reads)
    about = sum(float(((r.angles - r.angles.mean()) ** 2).sum()) for r in reads)
    sigma = math.sqrt(max(floor**2, (about + 4 * floor**2) / (spare + 4)))
    white = Noise(0.0, 0.0, math.sqrt(2 / (spare + 10)))
    n = len(read.angles)
    return Series(read.recording, read.angles, sigma, frame_lag(np.arange(n)), white, np.ones((n, 1)))


def begin(prepared: Prepared, model: Model) -> tuple[Model, np.ndarray]:
    """Model with the pair's friction, and starts (R, LOCALS): each run's onset where its travel alone fits best."""
    session = prepared.session
    model = replace(model, session=session)
    starts = np.zeros((len(session.runs) + len(session.reads), LOCALS))
    frictions = [math.tan(math.radians(float(np.median(r.angles)))) for r in session.reads]
    for k in range(len(session.runs)):
        starts[k, 0], starts[k, 1], friction, _ = _onset(model, prepared, k, jump=False)
        frictions.append(friction)
    return replace(model, friction=float(np.median(frictions))), starts


def begin_with_jump(prepared: Prepared, model: Model, starts: np.ndarray) -> tuple[np.ndarray, float]:
    """Starts where each run may gain an acceleration of its own at its onset, and the friction that this is (median): a block
    that lets go with a jump seems to let go earlier without one, and no step of a fit leads from the one onset to the other."""
    starts, lost = starts.copy(), []
    for k in range(len(prepared.session.runs)):
        starts[k, 0], starts[k, 1], _, jump = _onset(model, prepared, k, jump=True)
        lost.append(jump)
    return starts, float(np.median(lost))


def _onset(model: Model, prepared: Prepared, r: int, *, jump: bool) -> tuple[float, float, float, float]:
    """Place at rest [mm], onset [s], friction of one run by itself, and friction lost at the onset (nil without `jump`)."""
    run, sigma = prepared.session.runs[r], prepared.sigma[r]
    time = run.time - run.tilt.origin

    def misfit(onset: float) -> tuple[float, float, float, float]:
        way, _, friction = moved(model, r, np.array([0.0, onset, 0.0, 0.0, 0.0]), {})
        columns = [np.ones(len(time))] + ([np.clip(time - onset, 0, None) ** 2] if jump else [])
        design, left = np.column_stack(columns) / sigma[:, None], (run.travel - 1e3 * way) / sigma
        solution = np.linalg.lstsq(design, left, rcond=None)[0]
        if jump and solution[1] < 0:  # friction that is greater in motion has no jump: the other minimum
            solution = np.array([left @ design[:, 0] / (design[:, 0] @ design[:, 0]), 0.0])
        lost = 2e-3 * float(solution[1]) * math.hypot(1.0, friction) / G_M_S2 if jump else 0.0
        return float(((left - design @ solution) ** 2).sum()), float(solution[0]), friction, lost

    grid = np.linspace(time[0], time[0] + 0.9 * (time[-1] - time[0]), 120 if model.stairs else 60)
    if model.stairs:
        grid = np.tan(np.polynomial.polynomial.polyval(grid, run.tilt.coefficients))
    for _ in range(5):
        at = int(np.argmin([misfit(t)[0] for t in grid]))
        grid = np.linspace(grid[max(at - 1, 0)], grid[min(at + 1, len(grid) - 1)], 15)
    _, place, friction, lost = misfit(grid[7])
    return place, float(grid[7]), friction, lost
