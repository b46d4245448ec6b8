"""Lifting cylinder: an open tube full of seeds is lifted off a plate, and a heap with
slopes all round is left."""

from dataclasses import dataclass

import numpy as np

from benchtwin.sim.engine.walls import Cylinder, Rectangle, Slide, Wall
from benchtwin.sim.laws import Chosen
from benchtwin.sim.motion import Motion
from benchtwin.sim.rigs.bench import Bench, Watch, no_watch
from benchtwin.sim.rigs.engine import OURS, Engine
from benchtwin.sim.rigs.filling import Chute, Filled
from benchtwin.sim.rigs.heap import Vessel, run_heap
from benchtwin.sim.rigs.parts import slab

THICKNESS_M = 3e-3


@dataclass(frozen=True)
class LiftedCylinder:
    """cylinder_m: inside diameter and height; fill_height_m: where the seeds are struck
    off; plate_m: length and width of the plate; gate_speed_m_s: how fast the cylinder
    goes up; photo_s: when the picture is taken, as for the box."""

    cylinder_m: tuple[float, float] = (0.070, 0.150)
    plate_m: tuple[float, float] = (0.300, 0.300)
    fill_height_m: float = 0.100
    gate_speed_m_s: float = 0.050
    photo_s: float | None = None

    def __post_init__(self) -> None:
        sizes = (*self.cylinder_m, *self.plate_m, self.fill_height_m)
        if not all(v > 0 for v in (*sizes, self.gate_speed_m_s)):
            raise ValueError(f"every length and speed must be above 0 in {self}")
        if self.fill_height_m > self.cylinder_m[1]:
            raise ValueError(
                f"fill_height_m = {self.fill_height_m:g}: the cylinder is only"
                f" {self.cylinder_m[1]:g} m high"
            )
        if min(self.plate_m) <= self.cylinder_m[0]:
            raise ValueError(
                f"plate_m = {self.plate_m}: the cylinder ({self.cylinder_m[0]:g} m)"
                " must stand on it"
            )


def run_cylinder(
    rig: LiftedCylinder,
    bench: Bench,
    rng: np.random.Generator,
    *,
    fps: float = 0.0,
    watch: Watch = no_watch,
    engine: Engine = OURS,
    lying: Filled | None = None,
) -> Motion:
    """Fill, lift the cylinder, wait, look: as `run_pile`."""
    return run_heap(
        vessel(rig, bench),
        bench,
        rng,
        fps=fps,
        watch=watch,
        engine=engine,
        lying=lying,
    )


def vessel(rig: LiftedCylinder, bench: Bench) -> Vessel:
    """The cylinder as something that is filled and lifted."""
    (diameter, tall), radius = rig.cylinder_m, rig.cylinder_m[0] / 2
    x, y = rig.plate_m[0] / 2, rig.plate_m[1] / 2
    return Vessel(
        chute=Chute((-radius, -radius, 0.0), (radius, radius, tall), round=True),
        volume_m3=np.pi * radius**2 * rig.fill_height_m,
        fill_height_m=rig.fill_height_m,
        lift_m_s=rig.gate_speed_m_s,
        lift_m=tall,
        photo_s=rig.photo_s,
        walls=lambda tall, lift: _walls(rig, bench, tall, lift),
        domain=((-x - 0.1, -y - 0.1, -0.03), (x + 0.1, y + 0.1, 2.0)),
        opening_m=diameter,
        parts=(slab("plate", (-x, -y, -THICKNESS_M), (x, y, 0.0)),),
    )


def _walls(rig: LiftedCylinder, bench: Bench, tall: float, lift: Chosen) -> list[Wall]:
    x, y, high = rig.plate_m[0] / 2, rig.plate_m[1] / 2, max(tall, rig.cylinder_m[1])
    return [
        Rectangle("plate", bench.wall, (-x, -y, 0), (2 * x, 0, 0), (0, 2 * y, 0)),
        Cylinder(
            "cylinder",
            bench.wall,
            (0, 0, 0),
            (0, 0, high),
            rig.cylinder_m[0] / 2,
            (Slide(lift, (0, 0, 1)),),
        ),
    ]
