"""The way of every heap: a vessel is filled, part of it is lifted, the seeds flow, come
to rest and are looked at."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from benchtwin.sim.engine.observe import Settled
from benchtwin.sim.engine.state import State
from benchtwin.sim.engine.step import Every, init, run
from benchtwin.sim.engine.walls import Vector, Wall
from benchtwin.sim.engine.world import Placed, World
from benchtwin.sim.laws import LAWS, Chosen
from benchtwin.sim.material import Contact
from benchtwin.sim.motion import Motion, Part
from benchtwin.sim.rigs.bench import Bench, Frames, Watch
from benchtwin.sim.rigs.filling import (
    POURED,
    Filled,
    Lay,
    chute_height,
    count_for,
    rain,
    settle,
)
from benchtwin.sim.rigs.profile import centroid_angle, outline, slope_angle

# of a radius, for an instant where rain meets the floor: forgotten once the seeds lie
RAIN_OVERLAP = 0.25
LONGEST_S = 6.0
REST = {"window_s": 0.05, "displacement": 1e-2, "kinetic": 1e-5}


@dataclass(frozen=True)
class Vessel:
    """low, high: corners of what is filled [m]; volume_m3 up to fill_height_m.
    lift_m_s: how fast the part that moves goes up; lift_m: how far. photo_s: when the
    picture is taken after the lift began, None: when all lie still. walls(tall, lift):
    the vessel with walls up to `tall` [m] and its moving part under the law `lift`.
    domain: what leaves it is gone. opening_m: the narrowest way out. parts: what the
    camera sees at the end. wall_m: where the wall stands (x) that the heap leans on,
    None: it has two slopes."""

    low: Vector
    high: Vector
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

    def lift(self, begin_s: float | None) -> Chosen:
        """The law of the lift; None: it stands (by the same law, which then need not be
        compiled twice)."""
        rate = 0.0 if begin_s is None else self.lift_m_s
        return LAWS["motion_steady"].use(
            rate=rate, start=begin_s or 0.0, duration=self.lift_m / self.lift_m_s
        )


# what runs a heap in place of `run_heap`: (vessel, bench, rng, *, fps, watch)
Engine = Callable[..., Motion]


def fill(
    vessel: Vessel,
    bench: Bench,
    rng: np.random.Generator,
    *,
    threads: int,
    watch: Watch,
) -> Filled:
    """Rain seeds into the standing vessel and strike them off at the fill height;
    ValueError where they would jam."""

    def lay(world: World) -> tuple[np.ndarray, np.ndarray]:
        state = settle(
            world,
            init(world, rng),
            "filling",
            threads=threads,
            watch=watch,
            quiet=POURED,
        )
        return state.positions, state.orientations

    return fill_with(vessel, bench, rng, lay)


def fill_with(
    vessel: Vessel, bench: Bench, rng: np.random.Generator, lay: Lay
) -> Filled:
    """The same, whichever engine lets the seeds fall."""
    seeds = count_for(bench, rng, vessel.volume_m3)
    widest = max(2 * float(s.radii_m.max()) for s in seeds)
    if vessel.opening_m < 1.5 * widest:
        raise ValueError(
            f"seeds {1e3 * widest:.1f} mm wide jam in an opening of"
            f" {1e3 * vessel.opening_m:g} mm"
        )
    tall = chute_height(seeds, vessel.low, vessel.high)

    def standing(placed: Placed) -> World:
        walls = vessel.walls(tall, vessel.lift(None))
        return bench.world(
            placed,
            walls,
            contacts=vessel.contacts,
            most_overlap=RAIN_OVERLAP,
            sleep=bench.sleep,
        )

    return rain(
        bench, rng, seeds, vessel.low, vessel.high, standing, vessel.fill_height_m, lay
    )


def run_heap(
    vessel: Vessel,
    bench: Bench,
    rng: np.random.Generator,
    *,
    fps: float,
    watch: Watch,
    threads: int,
    filled: Filled | None,
) -> Motion:
    """Fill (or take a filling that was made before), lift, wait, look; with fps > 0 the
    frames before the photo are its film."""
    filled = filled or fill(vessel, bench, rng, threads=threads, watch=watch)

    def world(begin_s: float | None) -> World:
        walls = vessel.walls(0.0, vessel.lift(begin_s))
        return bench.world(
            filled.placed(bench),
            walls,
            domain=vessel.domain,
            contacts=vessel.contacts,
            sleep=bench.sleep,
        )

    still = world(None)
    state = settle(
        still,
        init(still, rng, allowed_overlap=0.2),
        "coming to rest",
        threads=threads,
        watch=watch,
    )
    begin = state.time_s
    frames = Frames(len(filled.shape_of), fps or 1.0, begin)
    flow = Flow(vessel, begin, watch)
    filmed = [Every(1 / fps, frames)] if fps > 0 else []
    state = run(world(begin), state, flow, filmed, threads=threads, every_s=0.01)
    frames.take(state, state.time_s)
    motion = Motion(
        shapes=filled.shapes,
        shape_of=filled.shape_of,
        parts=vessel.parts,
        **frames.columns(),
    )
    tell(motion, vessel, filled, still=flow.still)
    return motion


def tell(motion: Motion, vessel: Vessel, filled: Filled, *, still: bool) -> None:
    """Add what the simulation knows of the heap's outcome to its truth. still: whether
    it lay still at the end."""
    retained = float(np.isfinite(motion.positions_m[-1, :, 0]).sum())
    told = {"lies_still": float(still), "retained_seeds": retained}
    motion.truth.update(_truth(motion, vessel.wall_m) | told)
    motion.truth.update(_weights(motion, filled))


class Flow:
    """An observer that ends the run at the time of the photo, or when nothing moves any
    more behind the lift."""

    def __init__(self, vessel: Vessel, begin_s: float, watch: Watch) -> None:
        self.vessel, self.begin_s, self.watch = vessel, begin_s, watch
        self.settled, self.still = Settled(**REST), False
        self.out_s = (vessel.fill_height_m + 0.01) / vessel.lift_m_s

    def __call__(self, world: World, state: State) -> bool:
        since = state.time_s - self.begin_s
        lifting = since < self.out_s
        stage, share = (
            ("lifting", since / self.out_s)
            if lifting
            else ("settling", (since - self.out_s) / 1.0)
        )
        self.watch(stage, min(share, 0.99))
        self.still = self.settled(world, state)
        if self.vessel.photo_s is not None:
            return since >= self.vessel.photo_s
        return not lifting and (self.still or since > self.out_s + LONGEST_S)


def _weights(motion: Motion, filled: Filled) -> dict[str, float]:
    """Mass of what was filled in, and of what lies there at the end: a bench weighs
    both."""
    grams = 1e3 * np.array([seed.mass_kg for seed in filled.shapes])[filled.shape_of]
    there = np.isfinite(motion.positions_m[-1]).all(axis=1)
    return {
        "filled_mass_g": float(grams.sum()),
        "retained_mass_g": float(grams[there].sum()),
    }


def _truth(motion: Motion, wall_m: float | None) -> dict[str, float]:
    """Angle of repose (mean of both flanks where there are two), centroid's angle and
    crest's height of the true outline, and when it was read."""
    places = motion.positions_m[-1, :, 0]
    x = np.arange(
        np.nanmin(places) - 0.01 if wall_m is None else wall_m,
        np.nanmax(places) + 0.01,
        1e-4,
    )
    height = outline(motion, x)
    flanks = np.array([slope_angle(x, height), slope_angle(-x[::-1], height[::-1])])
    there = flanks[np.isfinite(flanks)]
    angle = float(there.mean()) if len(there) else float("nan")
    crest = 1e3 * float(height.max())
    of_centroid = centroid_angle(x, height, wall_m)
    return {
        "repose_angle_deg": angle,
        "centroid_angle_deg": of_centroid,
        "crest_mm": crest,
        "photo_s": float(motion.t_s[-1]),
    }
