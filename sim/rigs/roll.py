"""Roll: one seed let go on an incline, and how far it runs out on the level plate
behind it."""

from dataclasses import dataclass

import numpy as np

from benchtwin.sim.engine.observe import Settled
from benchtwin.sim.engine.state import State
from benchtwin.sim.engine.step import Every
from benchtwin.sim.engine.walls import Rectangle
from benchtwin.sim.engine.world import Placed, World
from benchtwin.sim.motion import Motion
from benchtwin.sim.rigs.bench import Bench, Frames, Watch, no_watch, reach
from benchtwin.sim.rigs.engine import OURS, Engine, Way
from benchtwin.sim.rigs.parts import prism
from benchtwin.sim.rotation import about, any_turn, product
from benchtwin.sim.seed import Seed

PLATE_THICKNESS_M = 5e-3
RAMP_BEYOND_M = 0.02  # the incline goes on above the place of release
REST_S = 0.15
REST_WAY = 0.01  # of the seed's diameter: what a resting seed may move in REST_S
LONGEST_S = 30.0
BELOW_M = 0.06  # a seed so far below the plate has left it


@dataclass(frozen=True)
class Roll:
    """incline_deg: the incline's slope. incline_length_m: way from the release to the
    junction, of the point that touches. direction: "+x" or "-x", the same plate run the
    other way. plate_m: length of the level plate and width of both. orientation:
    "across", the long axis level and across the way, off by angles that are normal with
    axis_sd_deg; or "any". slope_deg: how far the level plate itself falls towards +x
    (0: level), which is a fault of the bench, not of the seed."""

    incline_deg: float = 15.0
    incline_length_m: float = 0.010
    direction: str = "+x"
    plate_m: tuple[float, float] = (0.450, 0.120)
    orientation: str = "across"
    axis_sd_deg: float = 3.0
    slope_deg: float = 0.0

    def __post_init__(self) -> None:
        if self.direction not in ("+x", "-x"):
            raise ValueError(f"direction = {self.direction!r}: '+x' or '-x'")
        if self.orientation not in ("across", "any"):
            raise ValueError(f"orientation = {self.orientation!r}: 'across' or 'any'")
        if not 0 < self.incline_deg < 60 or not abs(self.slope_deg) < 5:
            raise ValueError(
                f"incline_deg = {self.incline_deg:g} must be 0 to 60, slope_deg ="
                f" {self.slope_deg:g} -5 to 5"
            )
        if (
            not self.incline_length_m > 0
            or not min(self.plate_m) > 0
            or not self.axis_sd_deg >= 0
        ):
            raise ValueError(
                "incline_length_m, plate_m and axis_sd_deg must not be negative"
            )


def run_roll(
    rig: Roll,
    bench: Bench,
    rng: np.random.Generator,
    *,
    fps: float = 200.0,
    watch: Watch = no_watch,
    engine: Engine = OURS,
) -> Motion:
    """Let one seed of the lot roll down and run out; over when it lies still or has
    left the plate."""
    (seed,) = bench.draw(rng, 1)
    sign = 1.0 if rig.direction == "+x" else -1.0
    beta, level = np.radians(rig.incline_deg), np.radians(rig.slope_deg) * sign
    down = np.array([sign * np.cos(beta), 0, -np.sin(beta)])
    across = np.array([0, rig.plate_m[1], 0.0])
    normal = np.array([sign * np.sin(beta), 0, np.cos(beta)])
    ahead = np.array([sign * np.cos(level), 0, -np.sin(level)])
    ramp = -(rig.incline_length_m + RAMP_BEYOND_M) * down
    low, wide = tuple(-across / 2), tuple(across)
    walls = [
        Rectangle("incline", bench.wall, low, tuple(ramp), wide),
        Rectangle("plate", bench.wall, low, tuple(rig.plate_m[0] * ahead), wide),
    ]
    q = _orientation(rig, rng, beta * sign)
    start = -rig.incline_length_m * down + reach(seed, q, -normal) * normal
    world = bench.world(Placed((seed,), bench.grain, start[None], q[None]), walls)
    frames, over = Frames(1, fps), Rest(rig, seed, ahead, watch)
    still = Settled(window_s=2 * REST_S, displacement=REST_WAY / 3, kinetic=1e-3)
    way = Way("roll", "rolling", LONGEST_S, over=f"v_z<-{BELOW_M:g}", still=still)
    looks = [Every(1 / fps, frames), Every(REST_S, over)]
    engine.follow(world, rng, way, looks, watch)
    columns = frames.columns()
    foot, leap = _foot(columns["positions_m"][:, 0], normal, down, ahead)
    series = {"travel_mm": 1e3 * (rig.incline_length_m + foot + leap)}
    truth = {"run_out_mm": 1e3 * float(foot[-1])} if over.rested else {}
    return Motion(
        shapes=(seed,),
        shape_of=np.zeros(1, int),
        parts=_parts(rig, sign),
        truth=truth,
        series=series,
        **columns,
    )


def _orientation(rig: Roll, rng: np.random.Generator, beta: float) -> np.ndarray:
    """Long axis (x of the principal frame) across the way, not quite; the seed turned
    about it by any angle."""
    if rig.orientation == "any":
        return any_turn(rng)
    yaw, tip = np.radians(rig.axis_sd_deg) * rng.normal(size=2)
    own = about((1, 0, 0), rng.uniform(0, 2 * np.pi))
    lying = product(
        about((0, 0, 1), np.pi / 2 + yaw), product(about((0, 1, 0), tip), own)
    )
    return product(about((0, 1, 0), beta), lying)


def _foot(
    x: np.ndarray, normal: np.ndarray, down: np.ndarray, ahead: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Way [m] past the junction of the point that touches (frames,), negative on the
    incline; and what makes it the centre's.

    In the corner a ball touches both plates: the place of touch leaps by 2 r tan(β/2),
    and its centre, which a camera follows, does not. With that added on the incline the
    way has no leap, and the junction stays where it is."""
    up = np.array([-ahead[2], 0.0, ahead[0]]) * np.sign(ahead[0])
    on_level = x @ up <= x @ normal
    foot = np.where(on_level, x @ ahead, x @ down)
    if not on_level.any():
        return foot, np.zeros(len(foot))
    radius = float(x[np.argmax(on_level)] @ up)
    return foot, np.where(
        on_level, 0.0, 2 * radius * np.tan(np.arccos(np.clip(down @ ahead, -1, 1)) / 2)
    )


@dataclass
class Rest:
    """An observer: true once the seed has lain still for REST_S, or has left the
    plate, which goes `ahead`."""

    rig: Roll
    seed: Seed
    ahead: np.ndarray
    watch: Watch
    place: np.ndarray | None = None
    rested: bool = False

    def __call__(self, world: World, state: State) -> bool:
        before, self.place = self.place, state.positions[0]
        way, still = self.place @ self.ahead, REST_WAY * 2 * self.seed.radii_m.max()
        self.watch("rolling", min(state.time_s / LONGEST_S, 0.99))
        gone = (
            way > self.rig.plate_m[0]
            or abs(self.place[1]) > self.rig.plate_m[1] / 2
            or self.place[2] < -0.05
        )
        self.rested = (
            before is not None
            and not gone
            and bool(np.linalg.norm(self.place - before) < still)
        )
        return gone or self.rested


def _parts(rig: Roll, sign: float):
    """The wedge and the level plate, seen from the side, sharing the junction's
    edge."""
    beta, slope = np.radians(rig.incline_deg), np.radians(rig.slope_deg)
    length = rig.incline_length_m + RAMP_BEYOND_M
    thick = PLATE_THICKNESS_M
    half = rig.plate_m[1] / 2
    top = (-sign * length * np.cos(beta), length * np.sin(beta))
    far = (
        sign * rig.plate_m[0] * np.cos(slope),
        -rig.plate_m[0] * np.sin(slope) * sign,
    )
    outline = [top, (top[0], -thick), (0.0, -thick), (0.0, 0.0)]
    level = [(0.0, 0.0), (0.0, -thick), (far[0], far[1] - thick), far]
    if sign < 0:
        outline, level = outline[::-1], level[::-1]
    return (prism("incline", outline, -half, half), prism("plate", level, -half, half))
