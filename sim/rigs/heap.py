"""The way of every heap: a vessel is filled, part of it is lifted, the seeds flow, come
to rest and are looked at."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from benchtwin.sim.engine.walls import Wall
from benchtwin.sim.engine.world import Placed, World
from benchtwin.sim.laws import LAWS, Chosen
from benchtwin.sim.material import Contact
from benchtwin.sim.motion import Motion, Part
from benchtwin.sim.rigs.bench import Bench, Watch, reach
from benchtwin.sim.rigs.engine import Engine, Lift
from benchtwin.sim.rigs.filling import RAIN_OVERLAP, Chute, Filled, count_for, rain
from benchtwin.sim.rigs.profile import centroid_angle, outline, slope_angle

# of a radius: else a run is stopped (`World.most_overlap`)
MOST_OVERLAP = 0.1
CLEAR_M = 0.01  # so far above the seeds, what was lifted is out of them


@dataclass(frozen=True)
class Vessel:
    """chute: what is filled; volume_m3 up to fill_height_m.
    lift_m_s: how fast the part that moves goes up; lift_m: how far. photo_s: when the
    picture is taken after the lift began, None: when all lie still. walls(tall, lift):
    the vessel with walls up to `tall` [m] and its moving part under the law `lift`.
    domain: what leaves it is gone. opening_m: the narrowest way out. parts: what the
    camera sees at the end. wall_m: where the wall stands (x) that the heap leans on,
    None: it has two slopes. clear_m: how far the part moves until it is out of the
    seeds, None: over the filling. overlap: of a radius, allowed in the flow. told: what
    the simulation then knows of the answer, None: of a heap; look_fps: looks at the
    flow that this needs, where it is not filmed."""

    chute: Chute
    volume_m3: float
    fill_height_m: float
    lift_m_s: float
    lift_m: float
    photo_s: float | None
    walls: Callable[[float, Chosen], list[Wall]]
    domain: tuple
    opening_m: float
    parts: tuple[Part, ...]
    contacts: tuple[Contact, ...] = ()
    wall_m: float | None = None
    clear_m: float | None = None
    overlap: float = MOST_OVERLAP
    told: Callable[[Motion], dict[str, float]] | None = None
    look_fps: float = 0.0

    @property
    def out_m(self) -> float:
        """How far the part has moved when it is out of the seeds."""
        filled = self.fill_height_m + CLEAR_M
        return filled if self.clear_m is None else self.clear_m

    def lift(self, begin_s: float | None) -> Chosen:
        """The law of the lift; None: it stands (by the same law, which then need not be
        compiled twice)."""
        rate = 0.0 if begin_s is None else self.lift_m_s
        return LAWS["motion_steady"].use(
            rate=rate, start=begin_s or 0.0, duration=self.lift_m / self.lift_m_s
        )


def fill(
    vessel: Vessel,
    bench: Bench,
    rng: np.random.Generator,
    engine: Engine,
    watch: Watch,
) -> Filled:
    """Rain seeds into the standing vessel and strike them off at the fill height;
    ValueError where they would jam."""
    seeds = count_for(bench, rng, vessel.volume_m3)
    widest = max(2 * float(s.radii_m.max()) for s in seeds)
    if vessel.opening_m < 1.5 * widest:
        raise ValueError(
            f"seeds {1e3 * widest:.1f} mm wide jam in an opening of"
            f" {1e3 * vessel.opening_m:g} mm"
        )
    walls = vessel.walls(vessel.chute.top_m(seeds), vessel.lift(None))

    def standing(placed: Placed) -> World:
        return bench.world(
            placed,
            walls,
            contacts=vessel.contacts,
            most_overlap=RAIN_OVERLAP,
            sleep=bench.sleep,
        )

    level = vessel.fill_height_m
    return rain(bench, rng, seeds, vessel.chute, standing, level, engine, watch)


def run_heap(
    vessel: Vessel,
    bench: Bench,
    rng: np.random.Generator,
    *,
    fps: float,
    watch: Watch,
    engine: Engine,
    filled: Filled | None = None,
    lying: Filled | None = None,
) -> Motion:
    """Fill (or take a filling that was made before), lift, wait, look; with fps > 0 the
    frames before the photo are its film. lying: seeds that lie there already, what is
    lifted having been taken away."""
    if lying is not None:
        vessel = opened(vessel)
        check_stands(vessel, lying)
    filled = lying or filled or fill(vessel, bench, rng, engine, watch)
    looks = fps or vessel.look_fps
    motion = let_go(vessel, bench, filled, rng, looks, watch, engine)
    told = vessel.told or (lambda motion: of_heap(motion, vessel.wall_m))
    motion.truth.update(told(motion))
    if fps or not looks:
        return motion
    return replace(
        motion,
        t_s=motion.t_s[-1:],
        positions_m=motion.positions_m[-1:],
        orientations=motion.orientations[-1:],
        velocities_m_s=motion.velocities_m_s[-1:],
        spins_rad_s=motion.spins_rad_s[-1:],
    )


def check_stands(vessel: Vessel, lying: Filled) -> None:
    """ValueError, with the shift that would help, for a heap that does not stand on the
    rig: its lowest seed is farther from the floor than it is wide, or some lie where
    they would be gone."""
    seeds = [lying.shapes[k] for k in lying.shape_of]
    turns, at = lying.orientations, lying.positions_m
    down = [reach(seed, q, (0, 0, -1)) for seed, q in zip(seeds, turns, strict=True)]
    low, high = at.min(axis=0), at.max(axis=0)
    low[2] = float((at[:, 2] - down).min())
    of_rig = np.array([vessel.chute.low, vessel.chute.high])
    shift = of_rig.mean(axis=0) - (low + high) / 2
    if vessel.wall_m is not None:  # it leans there
        shift[0] = vessel.wall_m + max(down) - low[0]
    shift[2] = of_rig[0, 2] - low[2]
    gone = (low < vessel.domain[0]) | (high > vessel.domain[1])
    gone[2] = abs(shift[2]) > 2 * max(seed.bounding_radius_m for seed in seeds)
    if gone.any():
        x, y, z = 1e3 * np.where(gone, shift, 0.0)
        raise ValueError(
            "the heap does not stand on the rig; moved by"
            f" ({x:.1f}, {y:.1f}, {z:.1f}) mm it may"
        )


def opened(vessel: Vessel) -> Vessel:
    """The vessel after the lift: without the part that moves."""

    def standing(tall: float, lift: Chosen) -> list[Wall]:
        return [wall for wall in vessel.walls(tall, lift) if not wall.moves]

    return replace(vessel, walls=standing, clear_m=0.0)


def let_go(
    vessel: Vessel,
    bench: Bench,
    filled: Filled,
    rng: np.random.Generator,
    fps: float,
    watch: Watch,
    engine: Engine,
) -> Motion:
    """What was filled in comes to rest, is let go and lies. Truth: lies_still, and
    photo_s."""
    placed = filled.placed(bench)

    def world(begin_s: float | None) -> World:
        return bench.world(
            placed,
            vessel.walls(0.0, vessel.lift(begin_s)),
            domain=vessel.domain,
            contacts=vessel.contacts,
            most_overlap=vessel.overlap,
            sleep=bench.sleep,
        )

    lift = Lift(vessel.out_m / vessel.lift_m_s, vessel.photo_s)
    columns, still = engine.flow(world, lift, rng, fps, watch)
    motion = Motion(
        shapes=filled.shapes,
        shape_of=filled.shape_of,
        parts=vessel.parts,
        **columns,
    )
    motion.truth.update(lies_still=float(still), photo_s=float(motion.t_s[-1]))
    return motion


def grams(motion: Motion) -> np.ndarray:
    """Mass (n,) [g] of every seed."""
    return 1e3 * np.array([seed.mass_kg for seed in motion.shapes])[motion.shape_of]


def weights(motion: Motion, there: np.ndarray) -> dict[str, float]:
    """Mass of what was filled in, and of the seeds that are `there` (n,) at the end: a
    bench weighs both."""
    mass = grams(motion)
    return {
        "filled_mass_g": float(mass.sum()),
        "retained_mass_g": float(mass[there].sum()),
    }


def of_heap(motion: Motion, wall_m: float | None) -> dict[str, float]:
    """Angle of repose (mean of both flanks where there are two), centroid's angle and
    crest's height of the true outline; seeds and weights that are left."""
    there = np.isfinite(motion.positions_m[-1]).all(axis=1)
    places = motion.positions_m[-1, :, 0]
    x = np.arange(
        np.nanmin(places) - 0.01 if wall_m is None else wall_m,
        np.nanmax(places) + 0.01,
        1e-4,
    )
    height = outline(motion, x)
    angle = mean_slope(x, height)
    crest = 1e3 * float(height.max())
    of_centroid = centroid_angle(x, height, wall_m)
    return {
        "repose_angle_deg": angle,
        "centroid_angle_deg": of_centroid,
        "crest_mm": crest,
        "retained_seeds": float(there.sum()),
        **weights(motion, there),
    }


def mean_slope(x: np.ndarray, height: np.ndarray) -> float:
    """Mean angle [deg] of those flanks of an outline that can be measured; NaN where
    none can."""
    flanks = np.array([slope_angle(x, height), slope_angle(-x[::-1], height[::-1])])
    there = flanks[np.isfinite(flanks)]
    return float(there.mean()) if len(there) else float("nan")
