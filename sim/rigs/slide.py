"""Slide: seeds taped together on a plate that is tilted about its hinge until they
slide."""

from dataclasses import dataclass, field

import numpy as np
from scipy.spatial.transform import Rotation

from benchtwin.sim.engine.state import State
from benchtwin.sim.engine.step import Every
from benchtwin.sim.engine.walls import Rectangle, Turn
from benchtwin.sim.engine.world import Placed, World
from benchtwin.sim.laws import LAWS
from benchtwin.sim.motion import Motion, Part
from benchtwin.sim.rigs.bench import Bench, Frames, Watch, no_watch, reach
from benchtwin.sim.rigs.engine import OURS, Engine, Way
from benchtwin.sim.rigs.parts import slab
from benchtwin.sim.rotation import about, product, turned
from benchtwin.sim.seed import MOST_SPHERES, Seed

PLATE_THICKNESS_M = 5e-3
LIE_S = 0.2  # the block lies on the level plate before the tilting begins
# of a seed's size: how far neighbours are pulled into each other
PULLED = (0.01, 0.03, 0.06, 0.10, 0.15)
# turned by more against the plate, the block rolls and does not slide
TIPPED_DEG = 20.0
BEYOND_M = 5e-3  # where an engine asks seldom, it slides so much farther
SEEN_M = 5e-3  # a way that nobody overlooks
SLIDES_M_S = 2e-3  # faster than this along the plate, a block slides for certain


@dataclass(frozen=True)
class Slide:
    """tilt_rate_deg_s: how fast the plate is raised. travel_m: how far the block slides
    before the recording ends. plate_m: length from the hinge and width. start_m: from
    the hinge to the block's middle. count: seeds taped together, 1, 2 or 4, side by
    side and end to end, long axes along the plate. start_deg: where the tilting
    begins."""

    tilt_rate_deg_s: float = 2.0
    travel_m: float = 0.080
    plate_m: tuple[float, float] = (0.200, 0.100)
    start_m: float = 0.150
    count: int = 4
    start_deg: float = 0.0

    def __post_init__(self) -> None:
        if self.count not in (1, 2, 4):
            raise ValueError(
                f"count = {self.count}: 1, 2 or 4 seeds can be taped together"
            )
        if not 0 < self.tilt_rate_deg_s <= 90:
            raise ValueError(
                f"tilt_rate_deg_s = {self.tilt_rate_deg_s:g}: must be above 0 and at"
                " most 90"
            )
        if not 0 <= self.start_deg < 80:
            raise ValueError(f"start_deg = {self.start_deg:g}: must be 0 to 80")
        if not 0 < self.travel_m < self.start_m < self.plate_m[0]:
            given = f"{self.travel_m:g}, {self.start_m:g}, {self.plate_m[0]:g}"
            raise ValueError(
                f"0 < travel_m < start_m < the plate's length is needed, not {given}"
            )


def run_slide(
    rig: Slide,
    bench: Bench,
    rng: np.random.Generator,
    *,
    fps: float = 100.0,
    watch: Watch = no_watch,
    engine: Engine = OURS,
) -> Motion:
    """Tilt the plate until the block has slid its travel; ValueError when it tips over,
    or has not slid by 80°."""
    block = taped(bench.draw(rng, rig.count))
    rate, first = np.radians(rig.tilt_rate_deg_s), np.radians(rig.start_deg)
    steady = LAWS["motion_steady"].use(rate=rate, start=LIE_S)
    width = rig.plate_m[1]
    along = np.array([np.cos(first), 0, np.sin(first)])
    up = np.array([-np.sin(first), 0, np.cos(first)])
    lift = Turn(steady, (0.0, 0.0, 0.0), (0.0, -1.0, 0.0))  # the far end rises
    uphill = tuple(rig.plate_m[0] * along)
    plate = Rectangle(
        "plate", bench.wall, (0, -width / 2, 0), uphill, (0, width, 0), (lift,)
    )
    # as on the table where it was taped
    lying = Rotation.from_matrix(block.axes).as_quat(scalar_first=True)
    origin = block.origin_m
    start = (rig.start_m + origin[0]) * along + origin[2] * up + (0, origin[1], 0)
    placed = Placed(
        (block,),
        bench.grain,
        start[None],
        product(about((0, -1, 0), first), lying)[None],
    )
    world = bench.world(placed, [plate])
    frames = Frames(1, fps)
    end = LIE_S + (np.radians(80.0) - first) / rate
    over = Sliding(rig, end, rate, first, watch)
    # nearer to the hinge, the y axis, than its travel asks for
    near = rig.start_m - rig.travel_m - BEYOND_M
    title, gone = "tilting until they slide", f"sqrt(v_x*v_x+v_z*v_z)<{near:.9g}"
    looks = [Every(1 / fps, frames), Every(min(1e-3, 1 / fps), over)]
    engine.follow(world, rng, Way("slide", title, end, over=gone), looks, watch)
    if over.travel_m[-1] < rig.travel_m:
        friction = bench.seed_wall.static_friction
        raise ValueError(
            f"the block has not slid {1e3 * rig.travel_m:g} mm by 80°: static_friction"
            f" = {friction:g}"
        )
    columns = frames.columns()
    tilt = first + rate * np.clip(columns["t_s"] - LIE_S, 0, None)
    poses = np.array([[0, 0, 0, *about((0, -1, 0), angle)] for angle in tilt])
    ends = (rig.plate_m[0], width / 2, 0)
    seen = slab("", (0, -width / 2, -PLATE_THICKNESS_M), ends).mesh
    parts = (Part("plate", seen, "steel", poses),)
    series = {
        "tilt_deg": np.degrees(tilt),
        "travel_mm": 1e3 * _travel(columns["positions_m"][:, 0], tilt),
    }
    return Motion(
        shapes=(block,),
        shape_of=np.zeros(1, int),
        parts=parts,
        series=series,
        truth=over.truth(),
        **columns,
    )


def taped(seeds: list[Seed]) -> Seed:
    """Seeds side by side and end to end on a level table, as one rigid body; its
    underside is level, so all of them touch.

    The tape pulls them together until they are one piece: unequal seeds need more of
    it. ValueError when PULLED[-1] does not do."""
    balls = sum(len(seed.radii_m) for seed in seeds)
    if balls > MOST_SPHERES:
        raise ValueError(
            f"spheres: {len(seeds)} taped seeds have {balls} balls; {MOST_SPHERES} at"
            " most"
        )
    for pull in PULLED:
        try:
            return _pulled_together(seeds, pull)
        except ValueError as error:
            apart = error
    raise ValueError(f"the seeds are too unequal to be taped together: {apart}")


def _pulled_together(seeds: list[Seed], pull: float) -> Seed:
    """The block with its seeds nearer by a share `pull` of their size than where equal
    ones would just touch."""
    centres = []
    for k, seed in enumerate(seeds):
        row, column = divmod(k, 2)
        half_width = seed.radii_m.max()
        half_length = reach(seed, np.array([1.0, 0, 0, 0]), (1, 0, 0))
        side = (
            (1 - pull) * half_width * (1 if column else -1) if len(seeds) > 1 else 0.0
        )
        ahead = (1 - pull) * half_length * (1 if row else -1) if len(seeds) > 2 else 0.0
        low = float(np.min(seed.centres_m[:, 2] - seed.radii_m))
        centres.append(seed.centres_m + np.array([ahead, side, -low]))
    radii_m = np.concatenate([s.radii_m for s in seeds])
    return Seed.from_spheres(np.vstack(centres), radii_m, seeds[0].density_kg_m3)


def _travel(positions: np.ndarray, tilt: np.ndarray) -> np.ndarray:
    """Way down the plate [m], in the plate's own axes."""
    along = positions[:, 0] * np.cos(tilt) + positions[:, 2] * np.sin(tilt)
    return along[0] - along


@dataclass
class Sliding:
    """An observer of the way down the plate: ends the run once the block has slid far
    enough, and finds when it let go. rate [rad/s] and first angle of the plate."""

    rig: Slide
    end_s: float
    rate: float
    first: float
    watch: Watch
    t_s: list[float] = field(default_factory=list)
    place: list[np.ndarray] = field(default_factory=list)
    travel_m: list[float] = field(default_factory=list)
    upright: np.ndarray | None = None

    def __call__(self, world: World, state: State) -> bool:
        self.t_s.append(state.time_s)
        self.place.append(state.positions[0])
        ends = np.array([self.place[0], self.place[-1]])
        self.travel_m.append(
            float(_travel(ends, self._tilt(np.array([0.0, state.time_s])))[1])
        )
        tilt = float(self._tilt(np.array(state.time_s)))
        normal = turned(
            state.orientations[0] * (1, -1, -1, -1),
            np.array([-np.sin(tilt), 0.0, np.cos(tilt)]),
        )  # in its own axes
        self.upright = normal if self.upright is None else self.upright
        if normal @ self.upright < np.cos(np.radians(TIPPED_DEG)):
            raise ValueError(
                f"the block tips over at {np.degrees(tilt):.1f}° before it slides"
                f" {1e3 * self.rig.travel_m:g} mm"
            )
        if len(self.t_s) % 200 == 0:
            self.watch(
                "tilting until they slide",
                max(state.time_s / self.end_s, self.travel_m[-1] / self.rig.travel_m),
            )
        return self.travel_m[-1] >= self.rig.travel_m

    def _tilt(self, t_s: np.ndarray) -> np.ndarray:
        return self.first + self.rate * np.clip(t_s - LIE_S, 0, None)

    def truth(self) -> dict[str, float]:
        """The plate's angle when sliding began. From then on the speed grows as (t −
        t₀)², so its root, a straight line in t while the block is slow, is continued
        back to zero."""
        t, travel = np.array(self.t_s), np.array(self.travel_m)
        speed = np.gradient(travel, t)
        lying = t <= LIE_S
        if speed[lying].max() > SLIDES_M_S:
            raise ValueError(
                f"the block slides from the start: start_deg = {self.rig.start_deg:g}"
                " is too steep for its friction"
            )
        crawling = np.flatnonzero(speed < SLIDES_M_S / 4)[-1]
        fast = int(np.argmax(speed[crawling + 1 :] > 10 * SLIDES_M_S))
        slow = slice(crawling + 1, crawling + 1 + max(fast, 3))
        slope, offset = np.polyfit(t[slow], np.sqrt(np.clip(speed[slow], 0, None)), 1)
        angle = float(np.degrees(self._tilt(-offset / slope)))
        seen = float(np.degrees(self._tilt(t[np.argmax(travel >= SEEN_M)])))
        return {
            "slide_angle_deg": angle,
            "static_friction": float(np.tan(np.radians(angle))),
            "angle_at_5_mm_deg": seen,
        }
