"""The slide as a problem: nuisances, noise, starts; a session's, or one run's alone."""

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
from benchtwin.rigs.slide.model import OWN, SHAPES, Model, predict, run_motion
from benchtwin.rigs.slide.session import (
    MOVING,
    SET_OFF,
    SETTLES_S,
    SETTLING_S,
    WAVES,
    Read,
    Run,
    Session,
    rows_of,
)
from benchtwin.rigs.slide.starts import Start, start_of

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
# of runs of few rows: degree of the curve, on a plate that stands and on one that tilts
# (the pull grows with time); sd where it cannot be estimated
DEGREE_STANDING, DEGREE_TILTING = 2, 3
FEW_SD_MM = 0.5
EXACT_MM = 1e-4  # floor for simulated tracks
# flat, each run's own: place, onset, speed, friction; the plate's angle, a phase; lock
FLAT = 1e3
OWN_SD = (FLAT, FLAT, FLAT, 0.1, 1.0, 1.0, 1.0, LOCK_PX, LOCK_PX, FLAT)
OWN_STEP = (1e-3, 1e-6, 1e-6, 1e-5, 1e-4, 1e-4, 1e-2, 1e-3, 1e-3, 1e-3)
MAX_ITERATIONS = 30  # onset and air beside a plate converge slowly
WHITE = Noise(0.0, 0.0, 1.0)
LOSES = "kinetic-friction"  # the effect of a block that lets go with less friction
SLOW_CLIMB = 2.0  # sds of ln time: stairs leave side minima between fast and slow
# other rates of tilting from which a fit starts, as ln of the ratio to the stated one
LN_RATES = (-4.1, -2.0, -0.7, 0.7, 2.0, 4.1)
LESS = 4.0  # times less friction lost than seems, of a further start
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
    pooled = _pooled([run for run in session.runs if run.few])
    for run in session.runs:
        if run.few:
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


def until_its_end(run: Run) -> Run:
    """A run on a plate that stands, cut where the block meets something; where it comes
    to rest is told."""
    found = likeliest(run, [run.how])[0]
    run = found.run
    way = 1e3 * run_motion(found.fit.problem.model, 0, found.fit.starts[0], {})[0]
    resting = max(int((way[1:] >= way[-1]).sum()) - 1, 0)  # rows after that of the stop
    return replace(run, ended=resting, rests=resting > 0)


@dataclass(frozen=True, eq=False)
class Alone:
    """One run fitted alone; ln_evidence: see `likeliest`."""

    prepared: Prepared
    fit: Fit
    ln_evidence: float = 0.0

    @property
    def run(self) -> Run:
        """The run."""
        return self.prepared.session.runs[0]

    @property
    def left(self) -> np.ndarray:
        """Its rows (n,) less what is fitted [mm]."""
        seen = predict(self.fit.problem.model, 0, self.fit.starts[0], self.fit.by_name)
        return self.run.travel - seen[:-1]

    def losing(self, loss: float, near: Fit) -> Fit:
        """The fit with a known loss of friction at the onset."""
        model = replace(near.problem.model, loss=loss, seen={})
        known = problem_of(self.prepared, model, near.starts[:, : len(OWN)])
        return fit(known, start=near)


def alone(run: Run, noise: Noise, sigma: np.ndarray, near: Fit | None = None) -> Alone:
    """The fit of one run; it may lose friction where it lets go. sigma (n,): sds of its
    rows; near: where to begin."""
    session = Session((run,), (), (), ())
    prepared = Prepared(session, noise, (np.maximum(sigma, EXACT_MM),))
    problem = with_starts(prepared, Model(session, 0.0, effects_of(session)), near)
    free = () if run.in_motion else (LOSES,)
    begun = near and replace(near, starts=problem.starts, cache={})
    return Alone(prepared, fit(problem, free=free, start=begun))


def likeliest(run: Run, hows: list[str]) -> list[Alone]:
    """Ways in which a block may move, each fitted, likeliest first; behind the row at
    which it may meet something it may do anything smooth.

    ln_evidence: with the rows' noise and all parameters of the run's own marginalised
    to first order (Schwarz 1978, Annals of Statistics 6, 461)."""
    n, tried, rows_sd = len(run.time), [], difference_noise(run.travel, 2)
    for end in dict.fromkeys((run.met, n)):
        after, more = _smooth(run, end)
        for how in hows:
            if how != MOVING and run.rest < 2:
                continue
            cut = rows_of(replace(run, how=how), np.arange(n) < end)
            found = alone(cut, WHITE, rows_sd * cut.weight)
            misfit = float(((found.left / cut.weight) ** 2).sum()) + after
            count = 3 + (how == SET_OFF) + more
            ln = -n / 2 * math.log(max(misfit, 1e-12) / n) - count / 2 * math.log(n)
            tried.append(replace(found, ln_evidence=ln))
    return sorted(tried, key=lambda found: -found.ln_evidence)


def _smooth(run: Run, end: int) -> tuple[float, int]:
    """Misfit of the rows from `end` on about a parabola, and its parameters with the
    time of the meeting."""
    time, x = run.time[end:], run.travel[end:]
    if not len(time):
        return 0.0, 0
    degree = min(2, len(time) - 1)
    left = (x - np.polyval(np.polyfit(time, x, degree), time)) / run.weight[end:]
    return float(left @ left), degree + 2


def _pooled(runs: list[Run]) -> float:
    """σ [mm] of rows of all short runs, about a curve each."""
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
        few = DEGREE_STANDING if run.in_motion else DEGREE_TILTING
        degree = min(degree, few if run.few else max(len(t) // 6, 0))
        design = legendre.legvander(t, degree)
        crossed = float(np.ptp(run.travel[part])) > DEGREE * float(
            np.hypot(*run.lock[0])
        )
        # waves finer than the curve
        if crossed and run.lock.any() and not run.few:
            design = np.column_stack([design, run.lock[part]])
        if run.in_motion and degree and not run.few:
            pulses = wander_of(run, 1.0)[part, 1 + WAVES :]
            design = np.column_stack([design, pulses])
        out.append(Stretch(design, run.travel[part], frame_lag(run.frame[part])))
    return out


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
    """starts (R, L): each run's own parameters."""
    session = prepared.session
    phased = bool(model.stair_deg or model.shaking[0])
    series = [
        _series(run, prepared, prepared.sigma[k], phased=phased)
        for k, run in enumerate(session.runs)
    ]
    series += [_reading(read, prepared, model.stair_deg) for read in session.reads]
    count = max((run.wander.shape[1] for run in session.runs), default=0)
    sds, steps = (np.append(each, np.ones(count)) for each in (OWN_SD, OWN_STEP))
    starts = np.column_stack([starts, np.zeros((len(starts), count))])
    own = Locals(starts * (sds == FLAT), steps, sds)
    known = _known(session, model) | dict(zip(SHAPES, prepared.shared))
    # a step of 1e-3 in friction, in which all is linear
    sizes = {n: 100.0 if n == "friction" else PRIORS[n] for n in PRIORS if n in known}
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
        return problem_of(prepared, more, starts[:, : len(OWN)])

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
    if any(r.tilt.stands and not r.tilt.sensor for r in session.runs):
        names |= {"plate"}
    if session.runs:
        names |= {"scale", "lens", "perspective", "air"}
        names |= {"air-shade"} if any(r.air.count > 1 for r in session.runs) else set()
    names |= {"climb"} if model.stair_deg else set()
    known = {n: PRIORS[n] for n in PRIORS if n in names}
    if session.runs:
        known["scale"] = float(np.median([r.scale_sd for r in session.runs]))
        steps = [max(r.tilt.grid_deg, r.tilt.read_to_deg) for r in session.runs]
        column = float(np.median(steps))
        step = 0.0 if model.stair_deg else unstated_sd("column-step") * column
        sensor = math.hypot(unstated_sd("tilt-sensor-zero"), step)
        pictured = [r.tilt.zero_sd_deg for r in session.runs if r.tilt.zero_sd_deg]
        sensor = float(np.median(pictured)) if pictured else sensor
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


def _series(run: Run, prepared: Prepared, sigma: np.ndarray, *, phased: bool) -> Series:
    """The track's rows, and the run's friction, which is the pair's within RUN_SD."""
    lag = np.append(frame_lag(run.frame), np.inf)
    return Series(
        run.recording,
        np.append(run.travel, 0.0),
        np.append(sigma, RUN_SD),
        lag,
        prepared.noise,
        np.zeros((len(lag), 0)),
        _known_slopes(run, phased),
        known=1,
    )


def _known_slopes(run: Run, phased: bool) -> dict[int | str, np.ndarray]:
    """Derivatives (n + 1,) that are the same everywhere, by number of a run's own
    parameter and name of a global; phased: whether its phase tells."""
    n = len(run.time)
    of_own = {"place": np.ones(n), "hinge": run.turned}
    of_own |= {"sine": run.lock[:, 0], "cosine": run.lock[:, 1]}
    idle = ("onset",) * (run.how == MOVING) + ("phase",) * (not phased)
    idle += () if run.in_motion else ("speed", "own friction")
    of_own |= {name: np.zeros(n) for name in idle}
    out: dict[int | str, np.ndarray] = {
        OWN.index(name): np.append(column, 0.0) for name, column in of_own.items()
    }
    wander = np.vstack([run.wander, np.zeros(run.wander.shape[1])]).T
    out |= {len(OWN) + k: column for k, column in enumerate(wander)}
    out |= dict(zip(SHAPES, wander))
    return out


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


def with_starts(prepared: Prepared, model: Model, near: Fit | None = None) -> Problem:
    """The problem, each run's parameters searched (near: known already), with further
    starts where there are other minima: blocks that lose friction when they let go,
    stairs that are climbed slowly, other rates of tilting than stated."""
    session = prepared.session
    model = replace(model, session=session)
    runs = range(len(session.runs))
    if near is not None:
        model = replace(near.problem.model, session=session, seen={})
        found = [Start(own[: len(OWN)], model.friction) for own in near.starts]
    else:
        found = [start_of(model, r, prepared.sigma[r]) for r in runs]
    read = [math.tan(math.radians(float(np.median(r.angles)))) for r in session.reads]
    friction = float(np.median([*(s.friction for s in found), *read]))
    model = replace(model, friction=friction)
    starts = np.zeros((len(found) + len(read), len(OWN)))
    at = OWN.index("own friction")
    for r, begun in enumerate(found):
        starts[r] = begun.own
        if near is None and session.runs[r].in_motion:
            starts[r, at] = begun.friction - friction
    problem = problem_of(prepared, model, starts)
    if model.stair_deg:
        slow = _globals(problem, {"climb": SLOW_CLIMB})
        return replace(problem, further_starts=((problem.starts, slow),))
    further = [
        (problem.starts, _globals(problem, {"tilt-rate": ln}))
        for ln in LN_RATES
        if "tilt-rate" in model.effects
    ]
    letting = [r for r in runs if not session.runs[r].in_motion]
    if letting and near is None:
        lost = [start_of(model, r, prepared.sigma[r], jump=True) for r in letting]
        own, loss = problem.starts.copy(), float(np.median([s.loss for s in lost]))
        for r, begun in zip(letting, lost, strict=True):
            own[r, : len(OWN)] = begun.own
        for name, effect in model.effects.items():
            if effect.rest and effect.nonlinear:
                columns = problem.columns_of(name)
                slow = {n: model.effects[n].low for n in columns}
                further += [
                    (own, _globals(problem, slow | {name: loss})),
                    (problem.starts, _globals(problem, {name: loss / LESS})),
                ]
    return replace(problem, further_starts=tuple(further))


def _globals(problem: Problem, values: dict[str, float]) -> np.ndarray:
    """Globals (G,) at 0 but for some."""
    return np.array([values.get(name, 0.0) for name in problem.names])
