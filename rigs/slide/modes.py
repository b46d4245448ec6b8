"""How the block of one recording moves, with what the recording leaves open.

    seen = place + (1 − s) 1000 x(t; onset, speed, μ_k) + h (θ(t) − θ(t₁))

x: `motion.travel` under all that `model.laws_of` says acts. A mode says which of place
[mm], onset [s], speed at the onset [m/s] and μ_k are the recording's own:

    lets go    place, onset, μ_k: at rest on a tilting plate, until it is steep enough
    moving     place, speed, μ_k: in motion at the first row
    set off    place, onset, speed, μ_k: at rest on a plate that stands, let go or pushed

A block in motion may come to rest, and then stays."""

import math
from dataclasses import dataclass, field, replace

import numpy as np
from benchtwin.infer.noise import Noise
from benchtwin.rigs.slide.model import LOCALS, Model, laws_of, tilt_of
from benchtwin.rigs.slide.motion import Laws, friction_at, travel
from benchtwin.rigs.slide.session import Run
from scipy.optimize import least_squares, minimize_scalar

LETS_GO, MOVING, SET_OFF = "lets go", "moving", "set off"
OWN = {
    LETS_GO: ("place", "onset", "friction"),
    MOVING: ("place", "speed", "friction"),
    SET_OFF: ("place", "onset", "speed", "friction"),
}
STEPS = {"place": 1e-3, "onset": 1e-6, "speed": 1e-6, "friction": 1e-5}
STEPS |= {"scale": 1e-4, "hinge": 1e-3}
COARSE = 50  # onsets tried over the whole recording
ENOUGH = 200  # rows for that
INSIDE = 1.96**2  # rise of χ² at the ends of a 95 % interval
HALVINGS = 14  # of the way to such an end


@dataclass(frozen=True, eq=False)
class Motion:
    """A recording and the model of it; `free_scale`: the unit of length or of time is
    unknown, so that the scale is free; `sides`: rows' prior weights (n,)."""

    model: Model
    sigma: np.ndarray  # (n,) relative sd of the rows
    lag: np.ndarray  # (n,) frames since the row before
    free_scale: bool = False
    pictured: bool = False
    noise: Noise = field(default_factory=lambda: Noise(0.0, 0.0, 1.0))
    off: dict[str, float] = field(default_factory=dict)  # values beside those fitted

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
        own = own | self.off
        locals_ = np.zeros(LOCALS)
        locals_[2:4] = own.get("level", 0.0), own.get("rate", 0.0)
        tilt = tilt_of(self.model, self.run, locals_, {})
        tilt[0] += math.radians(own.get("zero", 0.0))
        effects = self.model.effects
        acting = {n: e for n, e in effects.items() if n in own or e.group in own}
        laws = laws_of(replace(self.model, effects=acting), self.run, locals_, own)
        return tilt, laws._replace(friction=own["friction"])

    def way_mm(self, mode: str, own: dict[str, float]) -> np.ndarray:
        """Travel (n,) from rest or from the first row on."""
        tilt, laws = self.laws(own)
        onset = own.get("onset", self.since[0])
        rests = mode != LETS_GO
        way, _ = travel(self.since, onset, tilt, laws, own.get("speed", 0.0), rests)
        return 1e3 * way

    def seen(self, mode: str, own: dict[str, float]) -> np.ndarray:
        """Travel (n,) in the picture."""
        stretch = 1 - own.get("scale", 0.0) - self.off.get("scale", 0.0)
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

    @property
    def count(self) -> int:
        """Free parameters."""
        return len(self.names)

    def ln_evidence(self, after: float = 0.0, more: int = 0) -> float:
        """Of the recording, with σ and all parameters marginalised to first order
        (Schwarz 1978, Annals of Statistics 6, 461); after, more: misfit and parameters
        of rows behind the slide."""
        n = len(self.motion.lag)
        left = max(self.misfit + after, 1e-12)
        return -n / 2 * math.log(left / n) - (self.count + more) / 2 * math.log(n)

    @property
    def names(self) -> tuple[str, ...]:
        """The recording's own parameters."""
        motion = self.motion
        more = (*("scale",) * motion.free_scale, *("hinge",) * motion.pictured)
        return (*OWN[self.mode], *more)

    def columns(self) -> np.ndarray:
        """Derivatives (n, k) by the recording's own parameters."""
        return np.column_stack([self.slope(n, STEPS[n]) for n in self.names])

    def slope(self, name: str, step: float) -> np.ndarray:
        """Derivative (n,) of what is seen by one value."""
        here = self.own.get(name, 0.0)
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
        tried = [_linear(few, float(onset), None) for onset in grid]
        near = min(tried, key=lambda found: found.misfit)
    onset, guess = near.own["onset"], near.own["friction"]
    best = minimize_scalar(
        lambda onset: _linear(motion, onset, guess).misfit,
        bounds=(max(onset - width, first), min(onset + width, last)),
        method="bounded",
        options={"xatol": 1e-5 * (time[-1] - time[0])},
    )
    return _linear(motion, float(best.x), guess)


def _linear(motion: Motion, onset: float, guess: float | None) -> Found:
    """Place, friction, and where free scale and hinge, by least squares for a given
    onset."""
    tilt, laws = motion.laws({"friction": 0.0})
    friction = friction_at(onset, tilt, laws) if guess is None else guess
    own = {"place": 0.0, "onset": onset, "friction": friction}
    x = motion.run.travel
    misfit = math.inf
    known = 1 - motion.off.get("scale", 0.0)
    for _ in range(2):
        way = known * motion.way_mm(LETS_GO, own)
        bumped = own | {"friction": own["friction"] + STEPS["friction"]}
        slope = (known * motion.way_mm(LETS_GO, bumped) - way) / STEPS["friction"]
        columns = [np.ones(len(x)), slope]
        if motion.free_scale:
            columns.append(way)
        if motion.pictured:
            columns.append(motion.turned)
        aim = x if motion.free_scale else x - way
        white = motion.white(np.column_stack([*columns, aim]))
        solution, _, _, _ = np.linalg.lstsq(white[:, :-1], white[:, -1], rcond=1e-12)
        left = white[:, -1] - white[:, :-1] @ solution
        misfit = float(left @ left)
        stretch = float(solution[2]) if motion.free_scale else 1.0
        change = float(solution[1]) / (stretch or 1.0)
        own |= {
            "place": float(solution[0]),
            "scale": 1 - stretch,
            "hinge": float(solution[-1]) if motion.pictured else 0.0,
            "friction": own["friction"] + change,
        }
        if abs(change) < 1e-6:
            break
    return Found(motion, LETS_GO, own, misfit)


def shifted(found: Found, name: str, by: float) -> np.ndarray:
    """Change (k,) of the values where something that is not fitted is off: fitted
    again, since near μ_k = μ_s the onset does not follow in proportion."""
    motion = replace(found.motion, off={name: by})
    there = lets_go(motion, found)
    return np.array([there.own[n] - found.own[n] for n in found.names])


def onset_sd(found: Found, variance: float) -> float:
    """sd of the onset from the interval in which χ² rises by less than 1.96².

    A linearised sd does not suffice: with μ_k = μ_s χ² rises with the fourth power."""
    motion, onset, friction = found.motion, found.own["onset"], found.own["friction"]
    limits, reach = (motion.since[0], motion.since[-3]), []
    for limit in limits:
        near, far = 0.0, 1.0
        for _ in range(HALVINGS):
            middle = far / 16 if near == 0 else (near + far) / 2
            there = _linear(motion, onset + middle * (limit - onset), friction)
            inside = there.misfit < found.misfit + INSIDE * variance
            near, far = (middle, far) if inside else (near, middle)
        reach.append(abs(limit - onset) * (near + far) / 2)
    return sum(reach) / 2 / math.sqrt(INSIDE)


def in_motion(motion: Motion, mode: str, near: Found | None = None) -> Found:
    """The best values of a block that has a speed when it sets off; several frictions
    are tried, since one that stops it within the recording is another minimum."""
    free = Found(motion, mode, {}, 0.0).names
    x, time = motion.run.travel, motion.since
    angle = float(motion.run.tilt.at(motion.run.time).mean())

    def left(values: np.ndarray) -> np.ndarray:
        own = dict(zip(free, values, strict=True))
        return motion.white(x - motion.seen(mode, own))

    def slopes(values: np.ndarray) -> np.ndarray:
        own = dict(zip(free, values, strict=True))
        return -motion.white(Found(motion, mode, own, 0.0).columns())

    if near is not None:
        starts = [[near.own[n] for n in free]]
    else:
        edge = 0 if mode == MOVING else max(motion.run.rest - 1, 0)
        parts = time[edge:] - time[edge], x[edge:]
        speed = 1e-3 * float(np.polyfit(*parts, min(2, len(parts[0]) - 1))[-2])
        fast = max(speed, 1e-3 * float(np.ptp(x)) / float(np.ptp(time)))
        slowing = fast**2 / (2 * 9.81 * max(1e-3 * float(np.ptp(x)), 1e-6))
        frictions = [
            math.tan(angle) - 0.05,
            math.tan(angle) + slowing / math.cos(angle),
        ]
        values = {"place": x[edge], "onset": time[edge], "scale": 0.0, "hinge": 0.0}
        tried = [(v, f) for f in frictions for v in (speed, fast)]
        starts = [
            [(values | {"speed": v, "friction": f})[n] for n in free]
            for v, f in (tried[:1] if motion.run.tilt.coefficients[1] else tried)
        ]
    low = [time[0] if n == "onset" else 0.0 if n == "speed" else -np.inf for n in free]
    high = [time[-3] if n == "onset" else np.inf for n in free]
    best = min(
        (
            least_squares(
                left,
                np.clip(s, low, high),
                slopes,
                bounds=(low, high),
                x_scale="jac",
                ftol=1e-8 if near is None else 1e-12,
                xtol=1e-12,
                max_nfev=20 if near is None else 100,
            )
            for s in starts
        ),
        key=lambda found: found.cost,
    )
    own = dict(zip(free, (float(v) for v in best.x), strict=True))
    return Found(motion, mode, own, 2 * float(best.cost))


def refined(found: Found, noise: Noise) -> Found:
    """The same mode fitted again under other noise."""
    motion = replace(found.motion, noise=noise)
    if found.mode == LETS_GO:
        return lets_go(motion, found)
    return in_motion(motion, found.mode, found)
