"""From parameters to what is seen of a slide: the travel in the picture, or the angle that is read off.

Globals, by name, 0 at the baseline's centre: the effects; friction (of the pair), scale, lens, perspective, air (beside a
plate, air-shade: among several): nuisances.
Locals of a run: its place at rest [mm], its onset [s since the tilt's origin] (on stairs: its friction), its tilt's level and
rate [sd of what its column leaves], the phase at which a shaken plate lets it go [sd], its pixel lock's two waves [px] (places
may be counted from anywhere). Its friction follows from its onset; that it is the pair's within RUN_SD is one more row beside
those of the track.
"""

import math
from dataclasses import dataclass, field, replace
from functools import lru_cache

import numpy as np

from calibrate.diagnose.effects.effect import Effect
from calibrate.diagnose.effects.slide import EFFECTS, adhesion, angle_offset, clock_offset
from calibrate.diagnose.effects.slide.reading_delay import overshoot_deg
from calibrate.diagnose.slide.motion import G_M_S2, Laws, friction_at, travel
from calibrate.diagnose.slide.session import Run, Session

HINGE_M = 0.15  # from the block, where it is not stated: all that depends on it is θ̇² (r₀ − x), 1e-4 of g at 5°/s
LOCALS, ACTING = 7, slice(1, 5)  # of a run; those that change its motion
PICTURE = frozenset({"friction", "scale", "lens", "perspective"})  # globals that do not change the motion
MOTIONS = 64  # kept: of one linearisation
RIVAL = Effect(  # no candidate, but what a law outside the library looks like: where it wins, nothing is named
    name="(friction by way slid)", sector="sliding", unit="1/m", meaning="friction gained per way slid", prior_sd=0.5, low=-20.0,
    high=20.0, source="a scratched, dusty or waxed track", twins=("viscous-sliding", "stribeck"),
)  # fmt: skip


@dataclass(frozen=True, eq=False)
class Model:
    """friction: of the pair to begin with; effects: candidates that this session can show; stairs: each run's tilt goes up in
    its column's own stairs; turning: 1 where the block goes with a plate that turns, 0 where the weight turns about a plate that
    stands still (some simulate it so, which is another motion: no Coriolis acceleration lifts the block)."""

    session: Session
    friction: float
    effects: dict = field(default_factory=dict)
    stairs: bool = False
    turning: float = 1.0


def candidates(session: Session) -> dict:
    """Effects that show in what there is, steps apart; a vibration that is heard (scan.py) needs no inference."""
    names = []
    if session.runs:
        names += ["kinetic-friction", "stribeck", "stribeck.ln-speed", "stribeck.shape", "viscous-sliding", "partial-rolling"]
        names += ["plate-vibration", "plate-vibration.ln-hertz"]
    if np.isfinite(session.masses).all():
        names.append("adhesion")
    if np.isfinite([r.rate_deg_s for r in session.reads]).any():
        names.append("reading-delay")
    if any(r.tilt.sensor for r in session.runs) or session.reads:
        names += ["clock-offset", "angle-offset"]
    effects = {n: EFFECTS[n] for n in names}
    if session.runs:  # a block is the faster the farther it has slid: speed and way are told apart by what differs between runs
        viscous = effects["viscous-sliding"]
        effects |= {viscous.name: replace(viscous, twins=(*viscous.twins, RIVAL.name)), RIVAL.name: RIVAL}
    return effects


def laws_of(model: Model, r: int, own: np.ndarray, values: dict[str, float], stair: float, phase: float) -> Laws:
    """All that acts on run r, its friction apart; stair, phase [rad]: of its tilt."""
    run = model.session.runs[r]
    get = values.get
    press = adhesion.press(get("adhesion", 0.0), run.mass_g) if np.isfinite(run.mass_g) else 0.0
    return Laws(
        press=press, static_excess=get("kinetic-friction", 0.0), stribeck=get("stribeck", 0.0),
        ln_speed=get("stribeck.ln-speed", 0.0), shape=get("stribeck.shape", 0.0), viscous=get("viscous-sliding", 0.0),
        inertia=get("partial-rolling", 0.0), stair=stair, stair_phase=phase,
        turning=model.turning, from_hinge=run.from_hinge or HINGE_M, air=blown(run, values), slow_air=run.air.slow,
        worn=get(RIVAL.name, 0.0), shake=get("plate-vibration", 0.0), ln_hertz=get("plate-vibration.ln-hertz", 0.0),
        wave_chance=own[4],
    )  # fmt: skip


def blown(run: Run, values: dict[str, float]) -> float:
    """Air's size [1/m]: of n seeds in a block each is blown at by n^−¼ as much, from n^−½ (a raft) to 1 (side by side)."""
    amid = 0.25 * math.log(run.air.count)
    off = run.air.sd * values.get("air", 0.0) - amid * values.get("air-shade", 0.0)
    return run.air.size * math.exp(-amid) * (1 + off)


def tilt_of(model: Model, r: int, own: np.ndarray, values: dict[str, float]) -> tuple[np.ndarray, float, float]:
    """True tilt's coefficients [rad] in t − origin; stair height and phase [rad]."""
    tilt = model.session.runs[r].tilt
    c = tilt.coefficients + np.array([own[2] * tilt.level_sd, own[3] * tilt.rate_sd, 0.0, 0.0])
    stair, phase = math.radians(tilt.stair_deg), math.radians(tilt.stair_phase_deg)
    if tilt.sensor:
        late = clock_offset.true_time(0.0, values.get("clock-offset", 0.0))
        c = np.array([  # θ(t) = recorded(t + late): the cubic about another moment
            c[0] + late * (c[1] + late * (c[2] + late * c[3])), c[1] + late * (2 * c[2] + late * 3 * c[3]),
            c[2] + 3 * late * c[3], c[3],
        ])  # fmt: skip
        off = math.radians(angle_offset.true_tilt_deg(0.0, values.get("angle-offset", 0.0)))
        c[0] += off
        phase += off
    if not model.stairs:
        c[0] -= stair / 2  # a reading that was rounded up, of a plate that climbs steadily
        return c, 0.0, 0.0
    c[0] += stair / 2
    return c, stair, phase


def moved(model: Model, r: int, own: np.ndarray, values: dict[str, float]) -> tuple[np.ndarray, np.ndarray, float]:
    """True travel [m] and speed [m/s] of run r, and its friction; what the picture does is not in them."""
    return _moved(model, r, (0.0, *own[ACTING].tolist()), tuple((n, v) for n, v in values.items() if n not in PICTURE))


@lru_cache(maxsize=MOTIONS)
def _moved(model: Model, r: int, place: tuple[float, ...], acting: tuple) -> tuple[np.ndarray, np.ndarray, float]:
    run, own, values = model.session.runs[r], np.array(place), dict(acting)
    c, stair, phase = tilt_of(model, r, own, values)
    laws, onset = laws_of(model, r, own, values, stair, phase), own[1]
    if stair:  # it lets go where a stair begins: the friction is free within that stair
        friction = own[1]
        onset = _edge(friction, laws.press, c, stair, phase)
    else:
        friction = friction_at(onset, c, laws)
    return *travel(run.time - run.tilt.origin, onset, c, laws._replace(friction=friction)), friction


def _edge(friction: float, press: float, c: np.ndarray, stair: float, phase: float) -> float:
    """When the first stair begins on which a block of this friction slides."""
    needed = math.atan(friction) + math.asin(min(max(friction * press / G_M_S2 / math.hypot(1.0, friction), -0.99), 0.99))
    level, t = phase + stair * math.ceil((needed - phase) / stair), 0.0
    for _ in range(4):
        t += (level - (c[0] + t * (c[1] + t * (c[2] + t * c[3])))) / (c[1] + t * (2 * c[2] + t * 3 * c[3]))
    return t


def predict(model: Model, r: int, own: np.ndarray, values: dict[str, float]) -> np.ndarray:
    """What recording r shows: travel in the picture (n,) [mm] and its friction less the pair's, or angles (m,) [deg]."""
    count = len(model.session.runs)
    if r >= count:
        return angles(model, r - count, values)
    run = model.session.runs[r]
    way, _, friction = moved(model, r, own, values)
    x = 1e3 * way
    reach = max(float(np.ptp(run.travel)) / 2, 1.0)
    off = x - reach
    bent = values.get("lens", 0.0) * off * (off / reach) ** 2 + 1e-3 * values.get("perspective", 0.0) * off**2
    seen = own[0] + x * (1 - values.get("scale", 0.0)) + bent + run.lock @ own[ACTING.stop :]
    return np.append(seen, friction - model.friction - values.get("friction", 0.0))


def angles(model: Model, k: int, values: dict[str, float]) -> np.ndarray:
    """Angles read off: onset, tan θ = μ_s (1 + F/(m g cos θ)), with what the reader adds."""
    read = model.session.reads[k]
    friction = model.friction + values.get("friction", 0.0) + values.get("kinetic-friction", 0.0) + values.get("stribeck", 0.0)
    press = adhesion.press(values.get("adhesion", 0.0), read.mass_g) if np.isfinite(read.mass_g) else 0.0
    # sin θ − μ cos θ = μ F/(m g), and sin θ − μ cos θ = √(1 + μ²) sin(θ − atan μ)
    lean = friction * press / G_M_S2 / math.hypot(1.0, friction)
    onset = math.degrees(math.atan(friction) + math.asin(min(max(lean, -0.99), 0.99)))
    out = onset + values.get("angle-offset", 0.0)
    if np.isfinite(read.rate_deg_s):
        out += overshoot_deg(values.get("reading-delay", 0.0), read.rate_deg_s, onset)
        out -= read.rate_deg_s * values.get("clock-offset", 0.0)
    return np.full(len(read.angles), out)
