"""From parameters to the travel of each run that a camera reads.

Locals of a run (OWN): time and place of release [s, m], way on the incline beside the
stated one [m], incline [deg] and rolling friction (relative) beside the common ones,
drag (relative) beside that of the stated sizes, depth [m] and direction of the run
beside the plane of the scale, and how far before the junction the path turns, over
r tan(β/2): the foot of a ball's centre leaves the incline so far before the junction
and begins on the level so far behind it."""

import math
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from benchtwin.bench.table import NOTHING, Table, over, total
from benchtwin.infer.effect import Effect
from benchtwin.rigs.roll.effects.corner import usual_loss
from benchtwin.rigs.roll.effects.resistance import drag_over_weight
from benchtwin.rigs.roll.effects.shape_barrier import ripple
from benchtwin.rigs.roll.effects.slope import drive
from benchtwin.rigs.roll.motion import Way, travel
from benchtwin.rigs.roll.session import Run, Seed, weight_over_inertia

SPEEDS = 240  # points of the table of resistance over speed
PLACES = 240  # and over the way, which may be so many times as long as seen
FARTHER = 2.0
REMEMBERED = 600  # predictions kept: a fit asks for the same point several times
OWN = (
    "release_s",
    "place_m",
    "length_m",
    "incline_deg",
    "own mu",
    "own drag",
    "depth_m",
    "astray",
    "cut",
)


@dataclass(frozen=True, eq=False)
class Model:
    """The runs of a session, and what does not change in a fit."""

    runs: tuple[Run, ...]
    seed: Seed
    mu: float  # initial rolling friction
    incline: np.ndarray  # (R,) [rad], stated or from the motion
    length: np.ndarray  # (R,) [m]
    turn: np.ndarray  # (R,) [1/m]; with phase: argument of the ripple
    phase: np.ndarray
    names: tuple[str, ...]  # of the globals
    top: float  # greatest speed [m/s]
    effects: dict[str, Effect] = field(default_factory=dict)
    seen: dict = field(default_factory=dict)  # cache of predictions

    def usual_loss(self, r: int, rank: float) -> float:
        """Share of the speed that the corner takes of run r; rank: the nuisance
        `corner`."""
        return usual_loss(self.incline[r], self.seed.inertia, self.mu, rank)

    @cached_property
    def relevant(self) -> tuple[tuple[str, ...], ...]:
        """Of every run the globals on which it depends: no other session's scale, no
        other run's parameter."""
        return tuple(
            tuple(
                n
                for n in self.names
                if (n == scale or not n.startswith("scale."))
                and (not n[-1].isdigit() or n.endswith(f".{r}") or n == scale)
            )
            for r, scale in enumerate(f"scale.{run.session}" for run in self.runs)
        )

    @cached_property
    def speeds(self) -> np.ndarray:
        """Speeds [m/s] of the table of resistance."""
        return np.linspace(0, self.top, SPEEDS)

    @cached_property
    def unit_drag(self) -> np.ndarray:
        """Drag at these speeds over that at 0.5 m/s."""
        return drag_over_weight(self.speeds, 1.0, self.seed.reynolds_per_speed)


@dataclass(frozen=True)
class Context:
    """What an effect's law may use."""

    run: Run
    seed: Seed
    speed: float  # at the end of the incline [m/s]
    resisted: float  # share of the drive on the incline that rolling friction takes
    at: dict[str, float]  # all globals


def incline_of(model: Model, r: int, own: np.ndarray, at: dict[str, float]) -> float:
    """Angle of run r's incline [rad]."""
    return float(model.incline[r] + math.radians(own[3] + at.get("incline", 0.0)))


def cut_m(model: Model, r: int, own: np.ndarray, at: dict[str, float]) -> float:
    """How far before the junction the path of run r turns [m]."""
    turn = 0.0 if model.runs[r].stays else math.tan(incline_of(model, r, own, at) / 2)
    return float(own[8] * model.seed.radius * turn)


def way_of(model: Model, r: int, own: np.ndarray, at: dict[str, float]) -> Way:
    """Run r's way for its locals and the globals."""
    seed, get = model.seed, at.get
    f = weight_over_inertia(seed) * (1 + get("inertia", 0.0))
    beta = incline_of(model, r, own, at)
    stated = 0.0 if math.isnan(model.runs[r].slope) else model.runs[r].slope
    mu = model.mu * (1 + get("mu", 0.0)) * (1 + own[4])
    length = max(model.length[r] + own[2] - cut_m(model, r, own, at), 1e-4)
    speed = math.sqrt(
        max(2 * f * (math.sin(beta) - mu * math.cos(beta)) * length, 1e-6)
    )
    way = {
        "level": drive(stated + get("level", 0.0), model.runs[r].sign),
        "keep": 1 - model.usual_loss(r, get("corner", 0.0)),
    }
    # d ln(1 + I/(m h²)) = −2 (1 − 1/c) δh/r for an ellipse; half of it, ± half: seeds
    # are not ellipses
    if "oval" in at:
        way["oval"] = 0.5 * (1 + at["oval"]) * (1 - 1 / seed.inertia) / seed.radius
    resisted = min(max(mu, 0.0) / math.tan(beta), 0.9) if beta > 0 else 0.0
    context = Context(model.runs[r], seed, speed, resisted, at)
    for name, effect in model.effects.items():
        if effect.act and get(name):
            way = effect.act(way, at[name], context)
    if model.runs[r].stays:  # the whole apparatus leans
        beta += math.asin(max(min(way["level"], 0.9), -0.9))
    return Way(
        own[0],
        own[1],
        own[1] + length,
        f,
        math.sin(beta),
        math.cos(beta),
        mu,
        ripple=ripple(at, r),
        turn=model.turn[r],
        phase=model.phase[r],
        **way,
    )


def resistance_of(model: Model, r: int, own: np.ndarray, at: dict[str, float]) -> Table:
    """Speed-dependent resistance over weight of run r: stated air, and effects."""
    air = model.seed.drag * (1 + at.get("air", 0.0)) * model.runs[r].drag * (1 + own[5])
    acting = [
        (e.resist, at[n]) for n, e in model.effects.items() if e.resist and at.get(n)
    ]
    if not air and not acting:
        return NOTHING
    speed, values = model.speeds, air * model.unit_drag
    for resist, value in acting:
        values = values + resist(speed, value, model.seed, at)
    return over(speed, values)


def resisted_along(model: Model, r: int, at: dict[str, float]) -> Table:
    """What of effects pushes run r over the way since its release, over weight."""
    acting = [
        (e.along, at[n]) for n, e in model.effects.items() if e.along and at.get(n)
    ]
    if not acting:
        return NOTHING
    way = np.linspace(0, FARTHER * float(np.ptp(model.runs[r].x)), PLACES)
    return over(way, -sum(along(way, value) for along, value in acting))


def predict(model: Model, r: int, own: np.ndarray, at: dict[str, float]) -> np.ndarray:
    """Travel (n,) [m] that the camera reads of run r, and, where that was seen in the
    picture, the place of the junction."""
    key = (r, *own, *(at[n] for n in model.relevant[r]))
    if key not in model.seen:
        if len(model.seen) >= REMEMBERED:
            model.seen.clear()
        x = run_motion(model, r, own, at)[0]
        if model.runs[r].junction is not None:
            junction = np.array([junction_of(model, r, own, at)])
            x = np.append(x, as_read(model, r, own, at, junction))
        model.seen[key] = x
    return model.seen[key]


def junction_of(model: Model, r: int, own: np.ndarray, at: dict[str, float]) -> float:
    """Place [m] from which run r's run-out counts."""
    return float(own[1] + model.length[r] + own[2] - 2 * cut_m(model, r, own, at))


def beside_m(model: Model, r: int, own: np.ndarray, x: np.ndarray) -> np.ndarray:
    """By how much less than x (n,) [m] a camera reads of a run beside the plane of the
    scale: perspective about the picture's middle."""
    run = model.runs[r]
    off = x - run.middle
    return off * (own[6] + own[7] * (x - own[1])) / run.away


def as_read(
    model: Model, r: int, own: np.ndarray, at: dict[str, float], x: np.ndarray
) -> np.ndarray:
    """Places (n,) as the camera reads them."""
    scale = at.get(f"scale.{model.runs[r].session}", 0.0)
    return (x - beside_m(model, r, own, x)) / (1 + scale)


def run_motion(
    model: Model,
    r: int,
    own: np.ndarray,
    at: dict[str, float],
    more: Table = NOTHING,
    place: Table = NOTHING,
    time: Table = NOTHING,
    way: Way | None = None,
) -> tuple[np.ndarray, np.ndarray]:
    """Travel as read (n,) [m] and true speed (n,) [m/s] of run r.

    more: further resistance over speed; place, time: pushes over weight along travel
    and time since release; way: instead of `way_of`."""
    by_speed = total(more, resistance_of(model, r, own, at))
    place = total(place, resisted_along(model, r, at))
    # Rows are block means: the mean of two points one sd before and after agrees to
    # third order.
    run = model.runs[r]
    both = travel(run.around_s, way or way_of(model, r, own, at), by_speed, place, time)
    x, v = ((each[::2] + each[1::2]) / 2 for each in both)
    x = as_read(model, r, own, at, x)
    if run.gates:
        x = x - np.array([at.get(gate, 0.0) for gate in run.gate_of])
    return x, v
