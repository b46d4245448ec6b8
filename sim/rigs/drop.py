"""Drop: one seed let go above a plate, and its bounces."""

from dataclasses import dataclass, field

import numpy as np

from benchtwin.bench.constants import G_M_S2
from benchtwin.sim.engine.state import State
from benchtwin.sim.engine.step import Every
from benchtwin.sim.engine.walls import Rectangle
from benchtwin.sim.engine.world import Placed, World
from benchtwin.sim.motion import Motion
from benchtwin.sim.rigs.bench import Bench, Columns, Frames, Watch, no_watch, reach
from benchtwin.sim.rigs.engine import OURS, Engine, Way
from benchtwin.sim.rigs.parts import prism
from benchtwin.sim.rotation import about, any_turn, product
from benchtwin.sim.seed import Seed

PLATE_THICKNESS_M = 5e-3
# touches closer than this (one end of a seed, then the other) are one impact
ONE_IMPACT_S = 0.02
LONGEST_S = 5.0
AIR_SLOWS = 1.2  # flights through air last so much longer at most than through none
BELOW_M = 0.06  # a seed so far below the plate's end has left it
MOST_TILT_DEG = 15.0


@dataclass(frozen=True)
class Drop:
    """height_m: release to plate, of the seed's lowest point. plate_m: its length (x)
    and width (y). bounces: flights after the first impact that are waited for.
    spin_rad_s (3,): at the release, None: drawn, each component normal with
    spin_sd_rad_s. hold_s: how long the seed is seen held before the release. tilt_deg:
    how far the plate falls towards +x (0: level), about the place right below the
    release; a fault of the bench, not of the seed. orientation: "flat", as tweezers
    hold it: the long axis level in any direction, tipped by an angle that is normal
    with tip_sd_deg, and turned about itself by any angle; "any", every orientation as
    likely; or a unit quaternion (w, x, y, z). It decides the rebound: a seed that lands
    on an end goes on spinning instead of rising."""

    height_m: float = 0.310
    plate_m: tuple[float, float] = (0.300, 0.200)
    bounces: int = 3
    orientation: str | tuple[float, float, float, float] = "flat"
    tip_sd_deg: float = 6.0
    spin_rad_s: tuple[float, float, float] | None = None
    spin_sd_rad_s: float = 0.0
    hold_s: float = 0.01
    tilt_deg: float = 0.0

    def __post_init__(self) -> None:
        if self.bounces < 1:
            raise ValueError(
                f"bounces = {self.bounces}: at least 1 flight after the first impact is"
                " needed"
            )
        if (
            not self.height_m > 0
            or not min(self.plate_m) > 0
            or not self.hold_s >= 0
            or not self.spin_sd_rad_s >= 0
        ):
            raise ValueError(
                "height, plate, hold and spin must be positive lengths, times and"
                f" speeds, not {self}"
            )
        if not abs(self.tilt_deg) < MOST_TILT_DEG:
            raise ValueError(
                f"tilt_deg = {self.tilt_deg:g}: must lie between -{MOST_TILT_DEG:g} and"
                f" {MOST_TILT_DEG:g}"
            )
        if isinstance(self.orientation, str) and self.orientation not in (
            "flat",
            "any",
        ):
            raise ValueError(
                f"orientation = {self.orientation!r}: 'flat', 'any' or four numbers (w,"
                " x, y, z)"
            )


def run_drop(
    rig: Drop,
    bench: Bench,
    rng: np.random.Generator,
    *,
    fps: float = 1000.0,
    watch: Watch = no_watch,
    engine: Engine = OURS,
) -> Motion:
    """Drop one seed of the lot; over when it has touched `bounces` + 1 times, left the
    plate or lies still."""
    (seed,) = bench.draw(rng, 1)
    q = _orientation(rig, rng)
    if rig.spin_rad_s is None:
        spin = rng.normal(0.0, rig.spin_sd_rad_s, 3)
    else:
        spin = np.asarray(rig.spin_rad_s, float)
    x, y = np.array(rig.plate_m) / 2
    tilt = np.radians(rig.tilt_deg)
    along = np.array([np.cos(tilt), 0.0, -np.sin(tilt)])
    normal = np.array([np.sin(tilt), 0.0, np.cos(tilt)])
    start = np.array(
        [0.0, 0.0, rig.height_m + reach(seed, q, tuple(-normal)) / normal[2]]
    )
    corner = tuple(-x * along - (0.0, y, 0.0))
    plate = Rectangle("plate", bench.wall, corner, tuple(2 * x * along), (0, 2 * y, 0))
    world = bench.world(
        Placed((seed,), bench.grain, start[None], q[None], spins=spin[None]), [plate]
    )
    frames = Frames(1, fps)
    over = Impacts(rig.bounces + 1, rig.plate_m, watch, float(np.tan(tilt)))
    fall_s = np.sqrt(2 * rig.height_m / G_M_S2)
    off = BELOW_M + rig.plate_m[0] * abs(np.tan(tilt))
    way = Way(
        "drop",
        "falling and bouncing",
        LONGEST_S,
        surely_s=0.1 + AIR_SLOWS * fall_s * (1 + 2 * rig.bounces),
        over=f"v_z<-{off:.9g}",
    )
    looks = [Every(1 / fps, frames), Every(min(1e-3, 1 / fps), over)]
    engine.follow(world, rng, way, looks, watch)
    columns = _held(frames.columns(), round(rig.hold_s * fps), 1 / fps)
    top, below = x * along[[0, 2]], -PLATE_THICKNESS_M * normal[[0, 2]]
    parts = (prism("plate", [below - top, below + top, top, -top], -y, y),)
    motion = Motion(shapes=(seed,), shape_of=np.zeros(1, int), parts=parts, **columns)
    motion.truth.update(_truth(motion, seed, rig, over, round(rig.hold_s * fps) / fps))
    return motion


def _orientation(rig: Drop, rng: np.random.Generator) -> np.ndarray:
    if rig.orientation == "any":
        return any_turn(rng)
    if rig.orientation == "flat":
        heading, own = rng.uniform(0, 2 * np.pi, 2)
        tip = np.radians(rig.tip_sd_deg) * rng.normal()
        return product(
            about((0, 0, 1), heading),
            product(about((0, 1, 0), tip), about((1, 0, 0), own)),
        )
    return np.asarray(rig.orientation, float)


@dataclass
class Impacts:
    """An observer that counts impacts, and ends the run after `most`, off the plate, or
    when the seed lies still."""

    most: int
    plate_m: tuple[float, float]
    watch: Watch
    slope: float = 0.0  # of the plate, falling towards +x
    # [before its first touch, after its last] of each impact
    times_s: list[list[float]] = field(default_factory=list)
    _push: float = 0.0
    _last: float = 0.0

    def __call__(self, world: World, state: State) -> bool:
        push = float(np.abs(state.wall_push_ns).sum())
        touching = push != self._push  # at the end of contact the plate may pull
        if touching:
            if self.times_s and self._last - self.times_s[-1][1] < ONE_IMPACT_S:
                self.times_s[-1][1] = state.time_s
            else:
                self.times_s.append([self._last, state.time_s])
                self.watch(
                    "falling and bouncing", min(len(self.times_s) / self.most, 1.0)
                )
        self._push, self._last = push, state.time_s
        x, y, z = state.positions[0]
        gone = (
            abs(x) > self.plate_m[0]
            or abs(y) > self.plate_m[1]
            or z + self.slope * x < -0.02
        )
        # it rolls or lies
        longest = touching and state.time_s - self.times_s[-1][0] > 10 * ONE_IMPACT_S
        return gone or longest or (len(self.times_s) >= self.most and not touching)


def _held(columns: Columns, frames: int, step_s: float) -> Columns:
    """The same with `frames` frames of the seed at rest in front."""

    def waited(values: np.ndarray) -> np.ndarray:
        return np.concatenate([np.repeat(values[:1], frames, axis=0), values])

    x, q = waited(columns["positions_m"]), waited(columns["orientations"])
    v, w = waited(columns["velocities_m_s"]), waited(columns["spins_rad_s"])
    v[:frames] = w[:frames] = 0.0
    t_s = np.arange(len(x)) * step_s
    return Columns(
        t_s=t_s, positions_m=x, orientations=q, velocities_m_s=v, spins_rad_s=w
    )


def _truth(
    motion: Motion, seed: Seed, rig: Drop, over: Impacts, begin_s: float
) -> dict[str, float]:
    """Rise of the centre of mass from where it was at contact, as bench and measuring
    code mean it: flights before and after an impact are continued as parabolas until
    they meet."""
    t = motion.t_s - begin_s
    z = motion.positions_m[:, 0, 2]
    v = motion.velocities_m_s[:, 0, 2]
    first = over.times_s[0] if over.times_s else [np.inf, np.inf]
    second = (over.times_s[1:2] or [[t[-1], t[-1]]])[0]
    before = np.flatnonzero((t <= first[0]) & (t >= 0))
    after = np.flatnonzero((t >= first[1]) & (t <= second[0]))
    if not len(before) or not len(after):
        return {}
    a, b = before[-1], after[0]
    h, g = t[b] - t[a], G_M_S2
    # z_a + v_a s − g s²/2 = z_b + v_b (s − h) − g (s − h)²/2, linear in s
    s = (z[b] - z[a] - v[b] * h - g * h * h / 2) / (v[a] - v[b] - g * h)
    contact = z[a] + v[a] * s - g * s * s / 2
    top = int(after[np.argmin(np.abs(v[after]))])
    rise = z[top] + v[top] ** 2 / (2 * g) - contact
    fall = z[np.flatnonzero(t >= 0)[0]] - contact
    speeds = {"impact_speed_m_s": g * s - v[a], "rebound_speed_m_s": v[b] + g * (h - s)}
    upper = (
        z[top]
        + v[top] ** 2 / (2 * g)
        + reach(seed, motion.orientations[top, 0], (0, 0, 1))
    )  # as one who reads a ruler may take it
    restitution = float(np.sqrt(max(rise, 0) / fall))
    return {
        "rebound_height_mm": 1e3 * rise,
        "top_mm": 1e3 * upper,
        "fall_mm": 1e3 * fall,
        "restitution": restitution,
        **speeds,
    }
