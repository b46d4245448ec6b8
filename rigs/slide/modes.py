"""How the block of one recording moves, with what the recording leaves open.

    seen = place + (1 − s) 1000 x(t; onset, speed, μ_k) + h (θ(t) − θ(t₁))

x: `motion.travel` under all that `model.laws_of` says acts. A mode says which of place
[mm], onset [s], speed at the onset [m/s] and μ_k are the recording's own:

    lets go    place, onset, μ_k: at rest on a tilting plate, until it is steep enough
    keeps      place, onset: the same, and slides on under the friction that held it
    moving     place, speed, μ_k: in motion at the first row
    set off    place, onset, speed, μ_k: let go or pushed on a plate that stands

A block in motion may come to rest, and then stays."""

import math
from dataclasses import dataclass, field, replace

import numpy as np
from scipy.optimize import least_squares, minimize_scalar

from benchtwin.bench.constants import G_M_S2
from benchtwin.infer.noise import Noise
from benchtwin.rigs.slide.model import LOCALS, Model, laws_of, tilt_of
from benchtwin.rigs.slide.motion import Laws, friction_at, travel
from benchtwin.rigs.slide.session import Run

LETS_GO, KEEPS, MOVING, SET_OFF = "lets go", "keeps", "moving", "set off"
OWN = {
    LETS_GO: ("place", "onset", "friction"),
    KEEPS: ("place", "onset"),
    MOVING: ("place", "speed", "friction"),
    SET_OFF: ("place", "onset", "speed", "friction"),
}
STEPS = {"place": 1e-3, "onset": 1e-6, "speed": 1e-6, "friction": 1e-5}
SMALL = 0.05  # of a prior sd, the same for nuisances and effects
STEPS |= {"scale": 1e-4, "hinge": 1e-3}
COARSE = 50  # onsets tried over the whole recording
ENOUGH = 200  # rows for that
EARLY = 6  # rows that tell the speed with which a block sets off
INSIDE = 1.96**2  # rise of χ² at the ends of a 95 % interval
HALVINGS = 10  # of the way to such an end


@dataclass(frozen=True)
class Nuisance:
    """Something of which this recording tells little: its prior sd about 0, and whether
    it is the same in all recordings of a session."""

    name: str
    sd: float
    common: bool


@dataclass(frozen=True, eq=False)
class Motion:
    """A recording and the model of it.

    free_scale: the unit of length or of time is unknown, so that the scale is free;
    pictured: the plate's angle is from the picture, where an error of the hinge makes a
    travel that goes with the angle; nuisances: fitted with their priors, beside (n, m):
    what is seen changes by one sd of each."""

    model: Model
    sigma: np.ndarray  # (n,) relative sd of the rows
    lag: np.ndarray  # (n,) frames since the row before
    free_scale: bool = False
    pictured: bool = False
    noise: Noise = field(default_factory=lambda: Noise(0.0, 0.0, 1.0))
    level: float = 1.0  # sd of the white rows
    nuisances: tuple[Nuisance, ...] = ()
    beside: np.ndarray | None = None

    @property
    def run(self) -> Run:
        """The recording."""
        return self.model.session.runs[0]

    @property
    def since(self) -> np.ndarray:
        """Times (n,) after the origin of the tilt [s]."""
        return self.run.time - self.run.tilt.origin

    def laws(self, own: dict[str, float]) -> tuple[np.ndarray, Laws]:
        """Tilt coefficients (4,) and all that acts, for some values by name."""
        locals_ = np.zeros(LOCALS)
        locals_[2:4] = own.get("level", 0.0), own.get("rate", 0.0)
        tilt = tilt_of(self.model, self.run, locals_, {})
        tilt[0] += math.radians(own.get("zero", 0.0))
        effects = self.model.effects
        acting = {n: e for n, e in effects.items() if n in own or e.group in own}
        laws = laws_of(replace(self.model, effects=acting), self.run, locals_, own)
        friction = own.get("friction")
        if friction is None:
            friction = friction_at(own["onset"], tilt, laws)
        return tilt, laws._replace(friction=friction)

    def way_mm(self, mode: str, own: dict[str, float]) -> np.ndarray:
        """Travel (n,) from rest or from the first row on."""
        tilt, laws = self.laws(own)
        onset = own.get("onset", self.since[0])
        rests = mode in (MOVING, SET_OFF)
        way, _ = travel(self.since, onset, tilt, laws, own.get("speed", 0.0), rests)
        return 1e3 * way

    def seen(self, mode: str, own: dict[str, float]) -> np.ndarray:
        """Travel (n,) in the picture."""
        stretch = 1 - own.get("scale", 0.0)
        seen = own["place"] + stretch * self.way_mm(mode, own)
        return seen + own["hinge"] * self.turned if own.get("hinge") else seen

    @property
    def turned(self) -> np.ndarray:
        """How far the plate has turned (n,) since the first row [rad]."""
        angle = self.run.tilt.at(self.run.time)
        return angle - angle[0]

    def white(self, rows: np.ndarray) -> np.ndarray:
        """Rows (n, …) made independent, of one variance."""
        flat = rows.reshape(len(rows), -1) / self.sigma[:, None]
        return self.noise.whiten(flat, self.lag).reshape(rows.shape)


def taken(motion: Motion, rows: slice) -> Motion:
    """Some rows of a recording."""
    run = motion.run
    arrays = ("time", "travel", "frame", "lock")
    run = replace(run, **{name: getattr(run, name)[rows] for name in arrays})
    session = replace(motion.model.session, runs=(run,))
    model = replace(motion.model, session=session, seen={})
    lag = motion.lag[rows]
    return replace(motion, model=model, sigma=motion.sigma[rows], lag=lag)


@dataclass(frozen=True, eq=False)
class Found:
    """The best values of one mode; misfit: sum of squares of the white rows."""

    motion: Motion
    mode: str
    own: dict[str, float]
    misfit: float

    def ln_evidence(self, after: float = 0.0, more: int = 0) -> float:
        """Of the recording, with σ and all parameters marginalised to first order
        (Schwarz 1978, Annals of Statistics 6, 461); after, more: misfit and parameters
        of rows behind the slide."""
        n = len(self.motion.lag)
        left = max(self.misfit + after, 1e-12)
        return -n / 2 * math.log(left / n) - (len(self.names) + more) / 2 * math.log(n)

    @property
    def names(self) -> tuple[str, ...]:
        """What is fitted: the recording's own, then the nuisances."""
        motion = self.motion
        more = (*("scale",) * motion.free_scale, *("hinge",) * motion.pictured)
        return (*OWN[self.mode], *more, *(one.name for one in motion.nuisances))

    def columns(self) -> np.ndarray:
        """Derivatives (n, k) by what is fitted."""
        return np.column_stack([self.slope(n) for n in self.names])

    def step(self, name: str) -> float:
        """For derivatives by one value."""
        sds = {one.name: one.sd for one in self.motion.nuisances}
        return SMALL * sds[name] if name in sds else STEPS[name]

    def slope(self, name: str, step: float = 0.0) -> np.ndarray:
        """Derivative (n,) of what is seen by one value."""
        here, step = self.own.get(name, 0.0), step or self.step(name)
        up, down = ({**self.own, name: here + d} for d in (step, -step))
        seen = self.motion.seen
        return (seen(self.mode, up) - seen(self.mode, down)) / (2 * step)

    @property
    def residual(self) -> np.ndarray:
        """Rows (n,) less what is fitted [mm]."""
        return self.motion.run.travel - self.motion.seen(self.mode, self.own)


def lets_go(motion: Motion, near: Found | None = None) -> Found:
    """The best onset, everything else linear beside it; near: where to look."""
    time = motion.since
    first, last = time[0], time[-3]
    width = (time[-1] - time[0]) / COARSE
    if near is None:
        grid = np.linspace(first, last, COARSE)
        few = taken(motion, slice(None, None, max(1, len(time) // ENOUGH)))
        tried = [_linear(few, float(onset), None, 1) for onset in grid]
        near = min(tried, key=lambda found: found.misfit)
    onset, guess = near.own["onset"], near.own["friction"]
    best = minimize_scalar(
        lambda onset: _linear(motion, onset, guess).misfit,
        bounds=(max(onset - width, first), min(onset + width, last)),
        method="bounded",
        options={"xatol": 1e-5 * (time[-1] - time[0])},
    )
    return _linear(motion, float(best.x), guess)


def _linear(motion: Motion, onset: float, guess: float | None, turns: int = 2) -> Found:
    """Place, friction, and where free scale and hinge, by least squares for a given
    onset."""
    tilt, laws = motion.laws({"friction": 0.0})
    friction = friction_at(onset, tilt, laws) if guess is None else guess
    own = {"place": 0.0, "onset": onset, "friction": friction}
    x = motion.run.travel
    misfit = math.inf
    held = np.zeros((0, 0)) if motion.beside is None else motion.beside
    count = len(motion.nuisances)
    for _ in range(turns):
        way = motion.way_mm(LETS_GO, own)
        bumped = own | {"friction": own["friction"] + STEPS["friction"]}
        slope = (motion.way_mm(LETS_GO, bumped) - way) / STEPS["friction"]
        columns = [np.ones(len(x)), slope]
        if motion.free_scale:
            columns.append(way)
        if motion.pictured:
            columns.append(motion.turned)
        aim = x if motion.free_scale else x - way
        white = motion.white(np.column_stack([*columns, *held.T[:count], aim]))
        prior = np.zeros((count, white.shape[1]))
        prior[:, len(columns) : -1] = motion.level * np.eye(count)
        # the triangle says the same as all rows, and is solved at once
        white = np.asarray(np.linalg.qr(np.vstack([white, prior]), mode="r"))
        solution, _, _, _ = np.linalg.lstsq(white[:, :-1], white[:, -1], rcond=1e-12)
        left = white[:, -1] - white[:, :-1] @ solution
        misfit = float(left @ left)
        stretch = float(solution[2]) if motion.free_scale else 1.0
        change = float(solution[1]) / (stretch or 1.0)
        own |= {"place": float(solution[0]), "friction": own["friction"] + change}
        if motion.free_scale:
            own["scale"] = 1 - stretch
        if motion.pictured:
            own["hinge"] = float(solution[len(columns) - 1])
        if abs(change) < 1e-6:
            break
    sizes = solution[len(columns) :]
    own |= {o.name: float(v) * o.sd for o, v in zip(motion.nuisances, sizes)}
    return Found(motion, LETS_GO, own, misfit)


def onset_sd(found: Found) -> float:
    """sd of the onset from the interval in which χ² rises by less than 1.96².

    A linearised sd does not suffice: with μ_k = μ_s χ² rises with the fourth power."""
    motion, onset, friction = found.motion, found.own["onset"], found.own["friction"]
    limits, reach = (motion.since[0], motion.since[-3]), []
    for limit in limits:
        near, far = 0.0, 1.0
        for _ in range(HALVINGS):
            middle = far / 16 if near == 0 else (near + far) / 2
            there = _linear(motion, onset + middle * (limit - onset), friction)
            inside = there.misfit < found.misfit + INSIDE * motion.level**2
            near, far = (middle, far) if inside else (near, middle)
        reach.append(abs(limit - onset) * (near + far) / 2)
    return sum(reach) / 2 / math.sqrt(INSIDE)


def in_motion(motion: Motion, mode: str) -> Found:
    """The best values of a block that has a speed when it sets off; several frictions
    are tried, since one that stops it within the recording is another minimum."""
    x, time = motion.run.travel, motion.since
    angle = float(motion.run.tilt.at(motion.run.time).mean())
    edge = 0 if mode == MOVING else max(motion.run.rest - 1, 0)
    since, gone = time[edge:] - time[edge], 1e-3 * (x[edge:] - x[edge])
    speed = float(np.polyfit(since, gone, min(2, len(since) - 1))[-2])
    early = slice(1, max(2, min(EARLY, len(since) // 3)))
    first = float(np.median(gone[early] / since[early]))  # before friction tells
    way = max(float(np.ptp(gone)), 1e-6)
    starts = []
    for v in (speed, first, way / float(np.ptp(time))):
        stops = math.tan(angle) + v**2 / (2 * G_M_S2 * way * math.cos(angle))
        starts += [(v, math.tan(angle) - 0.05), (v, stops)]
    if motion.run.tilt.coefficients[1]:  # a raised plate does not stop what slides
        starts = starts[:1]
    known = {"place": float(x[edge]), "onset": float(time[edge])}
    return min(
        (
            descent(motion, mode, known | {"speed": v, "friction": f}, quick=True)
            for v, f in starts
        ),
        key=lambda found: found.misfit,
    )


def likeliest(
    motion: Motion, modes: list[str], met: int
) -> tuple[Found, list[tuple[Found, float]], int]:
    """Of some modes that of most evidence, the others with the ln of theirs less its
    own, and the row behind the slide's last; met: row at which it may end. Behind a
    slide that meets something the block may do anything smooth."""
    n = len(motion.lag)
    tried = []
    for end in dict.fromkeys((met, n)):
        part = taken(motion, slice(0, end))
        after, more = _smooth(motion, end)
        for mode in modes:
            if mode != MOVING and motion.run.rest < 2:
                continue
            found = lets_go(part) if mode == LETS_GO else in_motion(part, mode)
            evidence = replace(found, motion=motion).ln_evidence(after, more)
            tried.append((evidence, found, end))
    tried.sort(key=lambda t: -t[0])
    evidence, best, end = tried[0]
    others = [(f, e - evidence) for e, f, _ in tried[1:] if f.mode != best.mode]
    return best, others, end


def _smooth(motion: Motion, end: int) -> tuple[float, int]:
    """Misfit of the rows from `end` on about a parabola, and its parameters with the
    time of the meeting."""
    time, x = motion.run.time[end:], motion.run.travel[end:]
    if not len(time):
        return 0.0, 0
    degree = min(2, len(time) - 1)
    left = (x - np.polyval(np.polyfit(time, x, degree), time)) / motion.sigma[end:]
    return float(left @ left), degree + 2


def keeps(near: Found) -> Found:
    """The best values of a block whose friction stays, from those of one that may lose
    some."""
    motion, own = near.motion, near.own
    tilt, laws = motion.laws(own)
    time = motion.since
    onsets = np.linspace(time[0], time[-3], COARSE)
    holds = [friction_at(onset, tilt, laws) for onset in onsets]
    start = own | {"onset": float(np.interp(own["friction"], holds, onsets))}
    return descent(motion, KEEPS, start)


def descent(
    motion: Motion, mode: str, start: dict[str, float], *, quick: bool = False
) -> Found:
    """Nonlinear least squares from some values on; quick: near enough to compare."""
    free = Found(motion, mode, {}, 0.0).names
    x, time = motion.run.travel, motion.since

    def left(values: np.ndarray) -> np.ndarray:
        own = dict(zip(free, values, strict=True))
        rows = motion.white((x - motion.seen(mode, own))[:, None])[:, 0]
        held = [motion.level * own[one.name] / one.sd for one in motion.nuisances]
        return np.append(rows, held)

    def slopes(values: np.ndarray) -> np.ndarray:
        own = dict(zip(free, values, strict=True))
        rows = -motion.white(Found(motion, mode, own, 0.0).columns())
        held = np.zeros((len(motion.nuisances), len(free)))
        for k, one in enumerate(motion.nuisances):
            held[k, free.index(one.name)] = motion.level / one.sd
        return np.vstack([rows, held])

    low = [time[0] if n == "onset" else 0.0 if n == "speed" else -np.inf for n in free]
    high = [time[-3] if n == "onset" else np.inf for n in free]
    best = least_squares(
        left,
        np.clip([start.get(n, 0.0) for n in free], low, high),
        slopes,
        bounds=(low, high),
        x_scale="jac",
        ftol=1e-8 if quick else 1e-12,
        xtol=1e-12,
        max_nfev=20 if quick else 100,
    )
    own = dict(zip(free, (float(v) for v in best.x), strict=True))
    return Found(motion, mode, own, 2 * float(best.cost))


def refined(found: Found, noise: Noise, nuisances: tuple[Nuisance, ...]) -> Found:
    """The same mode fitted again under its noise, with what the recording tells little
    of."""
    motion = replace(found.motion, noise=noise)
    found = _again(motion, found)
    freedom = max(len(motion.lag) - len(found.names), 1)
    level = math.sqrt(max(found.misfit / freedom, 1e-18))
    kept = tuple(one for one in nuisances if one.sd > 0)
    beside = [one.sd * found.slope(one.name, SMALL * one.sd) for one in kept]
    motion = replace(
        motion, level=level, nuisances=kept, beside=np.column_stack(beside)
    )
    return _again(motion, found)


def raised_at(found: Found, factor: float) -> Found:
    """The same mode fitted again on a plate raised `factor` times as fast as stated,
    from the same angle at t = 0."""
    motion = found.motion
    run = motion.run
    start, rate = run.tilt.at(0.0), run.tilt.coefficients[1]
    angle = np.array([start + factor * rate * run.tilt.origin, factor * rate, 0.0, 0.0])
    run = replace(run, tilt=replace(run.tilt, coefficients=angle))
    session = replace(motion.model.session, runs=(run,))
    model = replace(motion.model, session=session, seen={})
    return _again(replace(motion, model=model), found)


def _again(motion: Motion, near: Found) -> Found:
    if near.mode == LETS_GO:
        return lets_go(motion, near)
    return descent(motion, near.mode, near.own)
