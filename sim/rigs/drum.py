"""Rotating drum: seeds flow down in a drum that turns, and their surface stands at the
dynamic angle of repose."""

from dataclasses import dataclass

import numpy as np

from benchtwin.bench.constants import G_M_S2
from benchtwin.sim.engine.step import Every
from benchtwin.sim.engine.walls import Cylinder, Mesh, Rectangle, Turn, Wall
from benchtwin.sim.engine.world import Placed, World
from benchtwin.sim.laws import LAWS
from benchtwin.sim.material import Contact, Material
from benchtwin.sim.motion import Motion
from benchtwin.sim.rigs.bench import Bench, Frames, Watch, no_watch
from benchtwin.sim.rigs.engine import OURS, SETTLED_BED, Engine, Ours, Way
from benchtwin.sim.rigs.filling import RAIN_OVERLAP, Chute, Filled, count_for, rain
from benchtwin.sim.rigs.parts import ring
from benchtwin.sim.rigs.pile import GLASS
from benchtwin.sim.rigs.profile import balls, upper_edge

# of the surface from wall to wall: between these the line is fitted, as in the picture
WINDOW = (0.25, 0.75)
FACETS = 96  # of the trough in which the drum is filled: within 0.03 % of its radius
CORNER = 0.7  # of the radius: half the square, within the drum, into which seeds rain


@dataclass(frozen=True)
class Drum:
    """drum_m: inside diameter and width; its ends are smooth, a slice out of a long
    drum. fill_share: of its cross-section, before it turns. speed_rpm: turns a minute,
    clockwise as the camera sees it: the surface falls towards +x. lining_friction:
    static friction of its inside, None: that of the plate. wait_s: how long it turns
    before the film begins; film_s: how long that is."""

    drum_m: tuple[float, float] = (0.120, 0.030)
    fill_share: float = 0.40
    speed_rpm: float = 10.0
    lining_friction: float | None = 0.9
    wait_s: float = 2.0
    film_s: float = 3.0

    def __post_init__(self) -> None:
        if not all(
            v > 0 for v in (*self.drum_m, self.speed_rpm, self.wait_s, self.film_s)
        ):
            raise ValueError(f"every length, speed and time must be above 0 in {self}")
        if not 0.1 <= self.fill_share <= 0.6:
            raise ValueError(f"fill_share = {self.fill_share:g}: must be 0.1 to 0.6")
        if (2 * np.pi * self.speed_rpm / 60) ** 2 * self.drum_m[0] / 2 >= G_M_S2:
            raise ValueError(
                f"speed_rpm = {self.speed_rpm:g}: the seeds would be thrown round with"
                " the drum"
            )


def run_drum(
    rig: Drum,
    bench: Bench,
    rng: np.random.Generator,
    *,
    fps: float = 25.0,
    watch: Watch = no_watch,
    engine: Engine = OURS,
) -> Motion:
    """Fill the drum, let it turn, film it. Truth: flowing_angle_deg, the mean over the
    film. The trough in which it is filled is a mesh, which only our engine has; what
    lies there is forgotten as the drum turns."""
    filling = engine if isinstance(engine, Ours) else OURS
    filled = _fill(rig, bench, rng, filling, watch)
    world = bench.world(
        filled.placed(bench), _walls(rig, bench), contacts=_contacts(rig, bench)
    )
    frames = Frames(len(filled.shape_of), fps, rig.wait_s)
    whole = rig.wait_s + rig.film_s

    def report(world: World, state) -> None:
        watch("turning", min(state.time_s / whole, 0.99))

    def seen(world: World, state) -> bool:
        if state.time_s >= rig.wait_s - 0.5 / fps:
            frames(world, state)
        # the last frame; a hundredth of one is more than a moment is off by
        return state.time_s + 0.99 / fps > whole

    looks = [Every(1 / fps, seen), Every(0.05, report)]
    way = Way("drum", "turning", whole, overlap=SETTLED_BED)
    engine.follow(world, rng, way, looks, watch)
    motion = Motion(
        shapes=filled.shapes,
        shape_of=filled.shape_of,
        parts=(_rim(rig),),
        **frames.columns(),
    )
    radius = rig.drum_m[0] / 2
    motion.truth["flowing_angle_deg"] = float(
        np.mean([flowing_angle(motion, radius, k) for k in range(motion.frames)])
    )
    return motion


def flowing_angle(motion: Motion, radius_m: float, frame: int) -> float:
    """Inclination [deg] of the least-squares line through the surface in the middle of
    its way from wall to wall, falling to +x."""
    x = np.arange(-radius_m, radius_m, 2e-4)
    height = upper_edge(*balls(motion, frame), x, -np.inf)
    there = np.flatnonzero(np.isfinite(height))
    first, last = x[there[0]], x[there[-1]]
    inside = there[
        (x[there] >= first + WINDOW[0] * (last - first))
        & (x[there] <= first + WINDOW[1] * (last - first))
    ]
    return float(-np.degrees(np.arctan(np.polyfit(x[inside], height[inside], 1)[0])))


def _fill(
    rig: Drum, bench: Bench, rng: np.random.Generator, engine: Engine, watch: Watch
) -> Filled:
    """Seeds at rest in the drum's lower part, up to the level of `fill_share`."""
    radius, width = rig.drum_m[0] / 2, rig.drum_m[1]
    level = _level(rig.fill_share) * radius
    seeds = count_for(bench, rng, rig.fill_share * np.pi * radius**2 * width)
    low = (-CORNER * radius, -width / 2, -CORNER * radius)
    high = (CORNER * radius, width / 2, radius)
    chute = Chute(low, high)
    tall = chute.top_m(seeds)
    walls = [_trough(rig, bench, tall), *_ends(rig, tall)]

    def standing(placed: Placed) -> World:
        return bench.world(
            placed, walls, contacts=_contacts(rig, bench), most_overlap=RAIN_OVERLAP
        )

    return rain(bench, rng, seeds, chute, standing, level, engine, watch)


def _level(share: float) -> float:
    """Height over the axis, in radii, below which a share of a circle's area lies: (π/2
    + h √(1 - h²) + asin h)/π, by Newton."""
    h = 0.0
    for _ in range(30):
        h += (
            (share - (np.pi / 2 + h * np.sqrt(1 - h * h) + np.arcsin(h)) / np.pi)
            * np.pi
            / (2 * np.sqrt(1 - h * h))
        )
    return float(h)


def _lining(rig: Drum, bench: Bench) -> Material:
    """What the drum is lined with: as hard as the plate, under a name of its own where
    its friction is."""
    if rig.lining_friction is None:
        return bench.wall
    of = bench.wall
    return Material(
        "lining",
        of.density_kg_m3,
        of.shear_modulus_pa,
        of.poisson_ratio,
        "the drum's inside, as the plate but for friction",
    )


def _contacts(rig: Drum, bench: Bench) -> tuple[Contact, ...]:
    on = bench.seed_wall
    seed, convention = bench.seed.name, on.rolling_convention
    made = [Contact((seed, GLASS.name), on.restitution, 0.0, 0.0, convention)]
    if rig.lining_friction is not None:
        friction, rolling = rig.lining_friction, on.rolling_friction
        made.append(
            Contact((seed, "lining"), on.restitution, friction, rolling, convention)
        )
    return tuple(made)


def _walls(rig: Drum, bench: Bench) -> list[Wall]:
    radius, width = rig.drum_m[0] / 2, rig.drum_m[1]
    law = LAWS["motion_steady"].use(rate=2 * np.pi * rig.speed_rpm / 60)
    turn = Turn(law, (0.0, 0.0, 0.0), (0.0, 1.0, 0.0))
    material = _lining(rig, bench)
    start = (0.0, -width / 2, 0.0)
    drum = Cylinder("drum", material, start, (0.0, width / 2, 0.0), radius, (turn,))
    return [drum, *_ends(rig, radius)]


def _ends(rig: Drum, tall: float) -> list[Wall]:
    """Smooth ends, so that the slice is as one out of a long drum."""
    radius, y = rig.drum_m[0] / 2, rig.drum_m[1] / 2
    across, up = (2 * radius, 0.0, 0.0), (0.0, 0.0, radius + tall)
    return [
        Rectangle(name, GLASS, (-radius, where, -radius), across, up)
        for name, where in (("near end", -y), ("far end", y))
    ]


def _trough(rig: Drum, bench: Bench, tall: float) -> Mesh:
    """The drum's lower half with straight walls above it, into which the seeds rain."""
    radius, y = rig.drum_m[0] / 2, rig.drum_m[1] / 2
    turn = np.linspace(np.pi, 2 * np.pi, FACETS // 2 + 1)
    x = np.concatenate([[-radius], radius * np.cos(turn), [radius]])
    z = np.concatenate([[tall], radius * np.sin(turn), [tall]])
    vertices = np.concatenate(
        [np.column_stack([x, np.full(len(x), side), z]) for side in (-y, y)]
    )
    n = len(x)
    faces = [(k, k + 1, n + k) for k in range(n - 1)] + [
        (k + 1, n + k + 1, n + k) for k in range(n - 1)
    ]
    return Mesh("trough", _lining(rig, bench), vertices, np.array(faces))


def _rim(rig: Drum):
    radius, y = rig.drum_m[0] / 2, rig.drum_m[1] / 2
    return ring("drum", radius, radius + 3e-3, -y, y, "board")
