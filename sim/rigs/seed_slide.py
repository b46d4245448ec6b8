"""Slides on a plate of seeds: a card with seeds glued to its underside lies on a plate
of seeds, which is tilted until the card slides off; the angle tells static friction of
seed on seed."""

from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from benchtwin.sim.engine.world import Placed, World
from benchtwin.sim.motion import Motion
from benchtwin.sim.rigs.bench import Bench, Frames, Watch, no_watch, reach
from benchtwin.sim.rigs.engine import OURS, Ours
from benchtwin.sim.rigs.seed_plate import SeedPlate, laid, on_glued
from benchtwin.sim.rigs.tilt import Tilt
from benchtwin.sim.rotation import about, product, turned
from benchtwin.sim.seed import Seed

ABOVE_M = 1e-4  # where the card is let go above the tops
BESIDE_M = 0.004  # of the plate beside a card that is turned


@dataclass(frozen=True)
class SeedSlide:
    """tilt_rate_deg_s: how fast the plate is raised. travel_m: it has slid off when it
    has gone so far. card_m: length along the plate and width of the card. coverage:
    share of plate and card that seeds cover. slides: of one card, each from another
    place."""

    tilt_rate_deg_s: float = 2.0
    travel_m: float = 0.020
    card_m: tuple[float, float] = (0.025, 0.025)
    coverage: float = 0.78
    slides: int = 2

    def __post_init__(self) -> None:
        if not 0 < self.tilt_rate_deg_s <= 90:
            raise ValueError(
                f"tilt_rate_deg_s = {self.tilt_rate_deg_s:g}: must be above 0 and at"
                " most 90"
            )
        if not (self.travel_m > 0 and min(self.card_m) > 0):
            raise ValueError(f"every length must be above 0 in {self}")
        if self.slides < 1:
            raise ValueError(f"slides = {self.slides}: at least 1 is needed")


def run_seed_slide(
    rig: SeedSlide,
    bench: Bench,
    rng: np.random.Generator,
    *,
    fps: float = 50.0,
    watch: Watch = no_watch,
    engine: Ours = OURS,
) -> Motion:
    """Tilt until the card has slid off, again and again, each time turned another way
    and on a part of the plate that is laid for it; the motion is that of the first, in
    the plate's own axes. Truth, over all slides: slide_angle_deg, the mean of the
    plate's angle when the card had gone `travel_m`, and sd_deg between slides."""
    half = (rig.card_m[0] / 2, rig.card_m[1] / 2)
    card = upside_down(laid(bench, rng, rig.coverage, (-half[0], -half[1]), half))
    angles, films = [], []
    for k in range(rig.slides):
        watch("tilting until it slides", k / rig.slides)
        around = float(np.hypot(*half)) + BESIDE_M
        low, high = (-around - rig.travel_m, -around), (around, around)
        plate = laid(bench, rng, rig.coverage, low, high)
        tilt = Tilt(rig.tilt_rate_deg_s, rig.travel_m, "the card", Frames(1, fps))
        angles.append(tilt.run(_world(bench, plate, card, rng), rng, engine))
        films.append((tilt, plate))
    tilt, plate = films[0]
    motion = Motion(
        shapes=(card,),
        shape_of=np.zeros(1, int),
        parts=plate.parts(),
        series={"tilt_deg": np.array(tilt.seen_deg)},
        **tilt.frames.columns(),
    )
    motion.readings["slide_angle_deg"] = angles
    motion.truth["slide_angle_deg"] = float(np.mean(angles))
    if rig.slides > 1:
        motion.truth["sd_deg"] = float(np.std(angles, ddof=1))
    return motion


def upside_down(plate: SeedPlate) -> Seed:
    """The seeds of a plate turned over, as one rigid body; its board weighs nothing,
    which no angle of sliding depends on."""
    over = about((1, 0, 0), np.pi)
    turns = product(over, plate.orientations)
    places = turned(over, plate.positions_m)
    masses = np.array([seed.mass_kg for seed in plate.seeds])
    middle = masses @ places / masses.sum()
    inertia = np.zeros((3, 3))
    for seed, x, q in zip(plate.seeds, places - middle, turns):
        axes = Rotation.from_quat(q, scalar_first=True).as_matrix()
        inertia += axes @ np.diag(seed.inertia_kg_m2) @ axes.T
        inertia += seed.mass_kg * (x @ x * np.eye(3) - np.outer(x, x))
    moments, axes = np.linalg.eigh(inertia)
    axes[:, 0] *= np.linalg.det(axes)
    balls = [x + turned(q, s.centres_m) for s, x, q in zip(plate.seeds, places, turns)]
    radii = np.concatenate([seed.radii_m for seed in plate.seeds])
    centres = (np.concatenate(balls) - middle) @ axes
    density = plate.seeds[0].density_kg_m3
    return Seed(centres, radii, masses.sum(), moments, density, None, axes, middle)


def _world(
    bench: Bench, plate: SeedPlate, card: Seed, rng: np.random.Generator
) -> World:
    """The card above the plate, turned any way."""
    level = Rotation.from_matrix(card.axes).as_quat(scalar_first=True)
    lying = product(about((0, 0, 1), rng.uniform(0, 2 * np.pi)), level)
    low = reach(card, lying, (0, 0, -1))
    start = np.array([[0.0, 0.0, plate.top_m + ABOVE_M + low]])
    placed = Placed((card,), bench.grain, start, lying[None])
    return bench.world(placed, plate.walls(bench), contacts=[on_glued(bench)])
