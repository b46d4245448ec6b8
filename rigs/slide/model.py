"""From parameters to what is seen of a slide: travel in the picture, or the angle read
off.

Parameters of a run's own, by name:

    place          at rest, or at the first row [mm]
    onset          when it lets go, or is set off [s since the tilt's origin]
    speed          with which it is set in motion [m/s], 0 where it lets go
    own friction   less the pair's, of a block that is set in motion; that of one that
                   lets go follows from its onset
    level, rate    of the plate's angle, beside the recorded one [sd]
    phase          of a shaken plate, or place on a step at which it lets go [sd]
    sine, cosine   waves of pixel lock [px]
    hinge          error of its place in a picture that was turned with the plate
                   [mm per rad]

That a run's friction is near the pair's is one more row, as the tangent of the angle at
which it lets go has it: friction times the load over that by the weight alone, so that
no pull to the plate makes frictions alike. Behind these, where slides show it [sd]: how
friction differs along each (`Run.wander`), and among the globals what of that all have
(SHAPES). A reading is a recording with idle parameters."""

import math
from dataclasses import dataclass, field

import numpy as np

from benchtwin.bench.constants import G_M_S2
from benchtwin.bench.priors import unstated_sd
from benchtwin.bench.table import over
from benchtwin.infer.effect import Effect
from benchtwin.rigs.slide.motion import NO_MORE, Laws, Tables, friction_at, travel
from benchtwin.rigs.slide.session import SET_OFF, SETTLES_S, WAVES, Read, Run, Session

HINGE_M = unstated_sd("hinge")  # it enters θ̇² (r₀ − x) only, 1e-4 g at 5°/s
OWN = (  # of a run
    *("place", "onset", "speed", "own friction", "level", "rate", "phase"),
    *("sine", "cosine", "hinge"),
)
ACTING = slice(1, 7)  # those that change its motion
# frictions along the slide that all slides have
SHAPES = tuple(f"shape-{k}" for k in range(WAVES + len(SETTLES_S) - 2))
# globals that do not change the motion
PICTURE = frozenset({"friction", "scale", "lens", "perspective", "reader", *SHAPES})
MOTIONS = 64  # cached
POINTS = 300  # of tables of friction
FASTER, FARTHER = 5.0, 2.0  # their ends: times the mean speed, and the way that is seen
LAG, LAG_SD = 0.5, 0.29  # place on a step at which it lets go: uniform
CLIMB_S = 0.07  # median time in which a plate climbs a step


@dataclass(frozen=True, eq=False)
class Model:
    """A session and its baseline."""

    session: Session
    friction: float  # initial, of the pair
    # that this session can show
    effects: dict[str, Effect] = field(default_factory=dict)
    loss: float = 0.0  # of friction, when a block lets go
    stair_deg: float = 0.0  # steps in which the plate is raised, 0 for none
    turning: float = 1.0  # 0 for a fixed plate under rotating gravity
    shaking: tuple[float, float] = (
        0.0,
        1.0,
    )  # amplitude [m/s²] and frequency [Hz] heard
    seen: dict = field(default_factory=dict)  # cache of motions


def of_own(own: np.ndarray) -> dict[str, float]:
    """A run's own parameters by name."""
    return dict(zip(OWN, own.tolist(), strict=False))


def laws_of(model: Model, run: Run, phase: float, values: dict[str, float]) -> Laws:
    """All that acts on a run, except its friction."""
    # each of n seeds feels n^−¼ (n^−½ to 1) of a lone one's
    amid = 0.25 * math.log(run.air.count)
    off = run.air.sd * values.get("air", 0.0) - amid * values.get("air-shade", 0.0)
    laws = Laws(
        turning=model.turning,
        from_hinge=run.from_hinge or HINGE_M,
        air=run.air.size * math.exp(-amid) * (1 + off),
        slow_air=run.air.slow,
        stair=math.radians(model.stair_deg),
        static_excess=model.loss,
        lag=min(max(LAG + LAG_SD * phase, 0.01), 0.99),
        wave_chance=phase,
        shake=model.shaking[0],
        omega=2 * math.pi * model.shaking[1],
        climb=CLIMB_S * math.exp(min(max(values.get("climb", 0.0), -4.0), 2.0)),
    )
    for name, effect in model.effects.items():
        if effect.act and (effect.group or values.get(name)):
            laws = effect.act(laws, run, values.get(name, 0.0))
    return laws


def tables_of(model: Model, run: Run, values: dict[str, float]) -> Tables:
    """Friction that effects add to a run's."""
    acting = [(e, v) for n, e in model.effects.items() if (v := values.get(n))]
    by_speed = [(e.resist, v) for e, v in acting if e.resist]
    by_way = [(e.along, v) for e, v in acting if e.along]
    if not (by_speed or by_way):
        return NO_MORE
    way = float(np.ptp(run.travel)) / 1000
    mean = way / float(np.ptp(run.time[run.moving]))
    roots = np.linspace(0.0, math.sqrt(FASTER * mean), POINTS)
    ways = np.linspace(0.0, FARTHER * way, POINTS)
    added = [resist(roots**2, v, run, values) for resist, v in by_speed]
    along = [of_way(ways, v) for of_way, v in by_way]
    return Tables(over(roots, sum(added, 0 * roots)), over(ways, sum(along, 0 * ways)))


def tilt_of(
    model: Model, run: Run, own: dict[str, float], values: dict[str, float]
) -> np.ndarray:
    """Coefficients (4,) [rad] of the true tilt in t − origin."""
    tilt = run.tilt
    if tilt.stands and not tilt.sensor:  # one plate for all
        off = math.radians(values.get("plate", 0.0))
        return tilt.coefficients + np.array([off, 0.0, 0.0, 0.0])
    off, faster = own["level"] * tilt.level_sd, own["rate"] * tilt.rate_sd
    c = tilt.coefficients + np.array([off, faster, 0.0, 0.0])
    for name, effect in model.effects.items():
        if effect.tilt and values.get(name):
            c = effect.tilt(c, run.tilt, values[name])
    return c


def run_motion(
    model: Model, r: int, own: np.ndarray, values: dict[str, float]
) -> tuple[np.ndarray, np.ndarray, float, float]:
    """True travel [m], speed [m/s] and friction of run r, before the picture, and its
    load where it lets go, over that by its weight alone."""
    key = (
        r,
        *own[ACTING].tolist(),
        *(v for n, v in values.items() if n not in PICTURE),
    )
    if key not in model.seen:
        if len(model.seen) >= MOTIONS:
            model.seen.clear()
        run, p = model.session.runs[r], of_own(own)
        c, time = tilt_of(model, run, p, values), run.time - run.tilt.origin
        tables = tables_of(model, run, values)
        if run.in_motion:
            onset = p["onset"] if run.how == SET_OFF else float(time[0])
            load = 1.0
            friction = model.friction + p["own friction"]
            laws = laws_of(model, run, 0.0, values)._replace(friction=friction)
            way, speed = travel(time, onset, c, laws, p["speed"], run.rests, tables)
        else:
            laws = laws_of(model, run, p["phase"], values)
            friction = friction_at(p["onset"], c, laws, tables)
            angle = float(np.polynomial.polynomial.polyval(p["onset"], c))
            load = 1 + laws.press / (G_M_S2 * math.cos(angle))
            laws = laws._replace(friction=friction)
            way, speed = travel(time, p["onset"], c, laws, tables=tables)
        model.seen[key] = way, speed, friction, load
    return model.seen[key]


def predict(
    model: Model, r: int, own: np.ndarray, values: dict[str, float]
) -> np.ndarray:
    """Travel in the picture (n,) [mm] and friction less the pair's times load, or
    angles (m,) [deg]."""
    count = len(model.session.runs)
    if r >= count:
        return angles(model, model.session.reads[r - count], values)
    run, p = model.session.runs[r], of_own(own)
    way, _, friction, load = run_motion(model, r, own, values)
    x = 1e3 * way
    reach = max(float(np.ptp(run.travel)) / 2, 1.0)
    off = x - reach
    bent = (
        values.get("lens", 0.0) * off * (off / reach) ** 2
        + 1e-3 * values.get("perspective", 0.0) * off**2
    )
    seen = (
        p["place"]
        + x * (1 - values.get("scale", 0.0))
        + bent
        + run.lock @ [p["sine"], p["cosine"]]
        + p["hinge"] * run.turned
    )
    if len(own) > len(OWN):
        shared = [values.get(n, 0.0) for n in SHAPES]
        seen = seen + run.wander @ (own[len(OWN) :] + shared)
    off = friction - model.friction - values.get("friction", 0.0)
    return np.append(seen, off * load)


def angles(model: Model, read: Read, values: dict[str, float]) -> np.ndarray:
    """Angles read: onset, tan θ = μ_s (1 + F/(m g cos θ)), with the reader's errors."""
    laws, mu = Laws(), model.friction + values.get("friction", 0.0)
    for name, effect in model.effects.items():
        if values.get(name):
            mu += effect.rest(values[name]) if effect.rest else 0.0
            if effect.act and np.isfinite(read.mass_g):
                laws = effect.act(laws, read, values[name])
    # sin θ − μ cos θ = μ F/(m g), and sin θ − μ cos θ = √(1 + μ²) sin(θ − atan μ)
    lean = mu * laws.press / G_M_S2 / math.hypot(1.0, mu)
    out = math.degrees(math.atan(mu) + math.asin(min(max(lean, -0.99), 0.99)))
    for name, effect in model.effects.items():
        if (
            effect.read
            and values.get(name)
            and not (effect.tilt and model.session.runs)
        ):  # errors of a sensor do not affect readers
            out = effect.read(out, read, values[name])
    return np.full(
        len(read.angles), out + values.get("reader", 0.0) + model.stair_deg / 2
    )  # of steps: the next one up
