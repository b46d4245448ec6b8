"""From parameters to what is seen of a slide: the travel in the picture, or the angle that is read off.

Globals, by name, 0 at the baseline's centre: the effects, whose hooks act on the motion's laws, on the recorded tilt and on what is
read; and the nuisances of problem.PRIORS. Locals of a run: its place at rest [mm], its onset [s since the tilt's origin], its
tilt's level and rate [sd of what its column leaves], the phase at which a shaken plate lets it go or how far up a stair it would
have slid [sd], its pixel lock's two waves [px]. Its friction follows from its onset; that it is the pair's is one more row beside
those of the track. A reading is a recording of its own, whose locals are idle.
"""

import math
from dataclasses import dataclass, field

import numpy as np

from diagnose.air import G_M_S2
from diagnose.effects.effect import Effect
from diagnose.rigs.slide.motion import Laws, friction_at, travel
from diagnose.rigs.slide.session import Read, Run, Session

HINGE_M = 0.15  # from the block, where it is not stated: all that depends on it is θ̇² (r₀ − x), 1e-4 of g at 5°/s
LOCALS, ACTING = 7, slice(1, 5)  # of a run; those that change its motion
PICTURE = frozenset({"friction", "scale", "lens", "perspective", "reader"})  # globals that do not change the motion
MOTIONS = 64  # kept: of one linearisation
LAG, LAG_SD = 0.5, 0.29  # of a stair: it lets go anywhere on it
CLIMB_S = 0.07  # in which a plate climbs a stair, about which its logarithm counts


@dataclass(frozen=True, eq=False)
class Model:
    """friction: of the pair to begin with; effects: those that this session can show; stair_deg: height of the stairs in which the
    plate climbs, 0: it climbs evenly; turning: 1 where the block goes with a plate that turns, 0 where the weight turns about a
    plate that stands still (another motion: no Coriolis acceleration lifts the block); shaking: heard amplitude [m/s²] and
    frequency [Hz] of the plate; seen: motions already worked out."""

    session: Session
    friction: float
    effects: dict[str, Effect] = field(default_factory=dict)
    stair_deg: float = 0.0
    turning: float = 1.0
    shaking: tuple[float, float] = (0.0, 1.0)
    seen: dict = field(default_factory=dict)


def laws_of(model: Model, run: Run, own: np.ndarray, values: dict[str, float]) -> Laws:
    """All that acts on a run, its friction apart."""
    laws = Laws(
        turning=model.turning, from_hinge=run.from_hinge or HINGE_M, air=blown(run, values), slow_air=run.air.slow,
        stair=math.radians(model.stair_deg), lag=min(max(LAG + LAG_SD * own[4], 0.01), 0.99), wave_chance=own[4],
        shake=model.shaking[0], omega=2 * math.pi * model.shaking[1],
        climb=CLIMB_S * math.exp(min(max(values.get("climb", 0.0), -4.0), 2.0)),
    )  # fmt: skip
    for name, effect in model.effects.items():
        if effect.act and (effect.group or values.get(name)):
            laws = effect.act(laws, run, values.get(name, 0.0))
    return laws


def blown(run: Run, values: dict[str, float]) -> float:
    """Air's size [1/m]: of n seeds in a block each is blown at by n^−¼ as much, from n^−½ (a raft) to 1 (side by side)."""
    amid = 0.25 * math.log(run.air.count)
    off = run.air.sd * values.get("air", 0.0) - amid * values.get("air-shade", 0.0)
    return run.air.size * math.exp(-amid) * (1 + off)


def tilt_of(model: Model, run: Run, own: np.ndarray, values: dict[str, float]) -> np.ndarray:
    """True tilt's coefficients (4,) [rad] in t − origin; of stairs the line through them."""
    tilt = run.tilt
    c = tilt.coefficients + np.array([own[2] * tilt.level_sd, own[3] * tilt.rate_sd, 0.0, 0.0])
    if tilt.sensor:
        for name, effect in model.effects.items():
            if effect.tilt and values.get(name):
                c = effect.tilt(c, values[name])
    return c


def moved(model: Model, r: int, own: np.ndarray, values: dict[str, float]) -> tuple[np.ndarray, np.ndarray, float]:
    """True travel [m] and speed [m/s] of run r, and its friction; what the picture does is not in them."""
    key = (r, *own[ACTING].tolist(), *(v for n, v in values.items() if n not in PICTURE))
    if key not in model.seen:
        if len(model.seen) >= MOTIONS:
            model.seen.clear()
        run = model.session.runs[r]
        c, laws = tilt_of(model, run, own, values), laws_of(model, run, own, values)
        friction = friction_at(own[1], c, laws)
        way, speed = travel(run.time - run.tilt.origin, own[1], c, laws._replace(friction=friction))
        model.seen[key] = way, speed, friction
    return model.seen[key]


def predict(model: Model, r: int, own: np.ndarray, values: dict[str, float]) -> np.ndarray:
    """What recording r shows: travel in the picture (n,) [mm] and its friction less the pair's, or angles (m,) [deg]."""
    count = len(model.session.runs)
    if r >= count:
        return angles(model, model.session.reads[r - count], values)
    run = model.session.runs[r]
    way, _, friction = moved(model, r, own, values)
    x = 1e3 * way
    reach = max(float(np.ptp(run.travel)) / 2, 1.0)
    off = x - reach
    bent = values.get("lens", 0.0) * off * (off / reach) ** 2 + 1e-3 * values.get("perspective", 0.0) * off**2
    seen = own[0] + x * (1 - values.get("scale", 0.0)) + bent + run.lock @ own[ACTING.stop :]
    return np.append(seen, friction - model.friction - values.get("friction", 0.0))


def angles(model: Model, read: Read, values: dict[str, float]) -> np.ndarray:
    """Angles read off: onset, tan θ = μ_s (1 + F/(m g cos θ)), with what the reader adds."""
    laws, mu = Laws(), model.friction + values.get("friction", 0.0)
    for name, effect in model.effects.items():
        if values.get(name):
            mu += effect.rest(values[name]) if effect.rest else 0.0
            laws = effect.act(laws, read, values[name]) if effect.act and np.isfinite(read.mass_g) else laws
    # sin θ − μ cos θ = μ F/(m g), and sin θ − μ cos θ = √(1 + μ²) sin(θ − atan μ)
    lean = mu * laws.press / G_M_S2 / math.hypot(1.0, mu)
    out = math.degrees(math.atan(mu) + math.asin(min(max(lean, -0.99), 0.99)))
    for name, effect in model.effects.items():
        if effect.read and values.get(name) and not (effect.tilt and model.session.runs):  # a sensor's fault is no reader's
            out = effect.read(out, read, values[name])
    return np.full(len(read.angles), out + values.get("reader", 0.0) + model.stair_deg / 2)  # on stairs: the next one up
