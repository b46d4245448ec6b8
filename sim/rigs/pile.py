"""Pile: a box of seeds whose gate is lifted; they run out over a plate and its edges,
and what is left has an angle of repose."""

from dataclasses import dataclass, replace

import numpy as np

from benchtwin.sim.engine.walls import Rectangle, Slide, Wall
from benchtwin.sim.laws import Chosen
from benchtwin.sim.material import Contact, Material
from benchtwin.sim.motion import Motion, Part
from benchtwin.sim.rigs.bench import Bench, Watch, no_watch
from benchtwin.sim.rigs.engine import OURS, Engine
from benchtwin.sim.rigs.filling import Chute, Filled
from benchtwin.sim.rigs.heap import Vessel, run_heap
from benchtwin.sim.rigs.parts import slab

THICKNESS_M = 3e-3
SMOOTH = "sides of a slab: nothing but their smoothness matters"
GLASS = Material("glass", 2500.0, 2.5e10, 0.22, SMOOTH)


@dataclass(frozen=True)
class Pile:
    """box_m: inside length (x, gate side at +x), width (y), height (z). gate_m: the
    sliding plate's width and height; what is left of that side of the box, right and
    left of it, stays. plate_m: length (x, from the box's back) and width (y) of the
    bottom plate. fill_height_m: the seeds are struck off there. gate_speed_m_s:
    straight up, until the gate is out of the seeds. photo_s: when the picture is taken,
    from when the gate begins to move; None: when all seeds lie still
    (`engine.FLOWN_S`). side_walls_in_view: whether the box's front and back (y) sides
    stand in the camera's way, or are of glass. slab: sides without friction all along a
    plate as narrow as the box, a slice out of a pile that is very wide. channel_m:
    inside length and width of a channel in whose one end the box is: its floor is the
    plate, its walls, with friction, are the box's sides, and a wall closes its far end;
    None: the plate is open all round."""

    box_m: tuple[float, float, float] = (0.105, 0.105, 0.200)
    gate_m: tuple[float, float] = (0.100, 0.200)
    plate_m: tuple[float, float] = (0.200, 0.200)
    fill_height_m: float = 0.100
    gate_speed_m_s: float = 0.050
    photo_s: float | None = None
    side_walls_in_view: bool = False
    slab: bool = False
    channel_m: tuple[float, float] | None = None

    def __post_init__(self) -> None:
        if self.channel_m is not None:
            self._check_channel(self.channel_m)
        sizes = (*self.box_m, *self.gate_m, *self.plate_m, self.fill_height_m)
        if not all(v > 0 for v in (*sizes, self.gate_speed_m_s)):
            raise ValueError(f"every length and speed must be above 0 in {self}")
        if self.fill_height_m > self.box_m[2]:
            raise ValueError(
                f"fill_height_m = {self.fill_height_m:g}: the box is only"
                f" {self.box_m[2]:g} m high"
            )
        if self.gate_m[0] > self.box_m[1] and not self.slab:
            raise ValueError(
                f"gate_m = {self.gate_m[0]:g} wide: the box's side is only"
                f" {self.box_m[1]:g} m wide"
            )
        if self.gate_m[1] < self.fill_height_m:
            raise ValueError(
                f"gate_m = {self.gate_m[1]:g} high: seeds lie up to"
                f" {self.fill_height_m:g} m behind it"
            )
        if self.plate_m[0] <= self.box_m[0] or (
            self.plate_m[1] < self.box_m[1] and not self.slab
        ):
            raise ValueError(
                f"plate_m = {self.plate_m}: the box ({self.box_m[0]:g} ×"
                f" {self.box_m[1]:g} m) must stand on it"
            )

    def _check_channel(self, channel: tuple[float, float]) -> None:
        if self.slab:
            raise ValueError(
                "channel_m and slab: the walls of a channel rub, the sides of a slab do"
                " not"
            )
        if self.plate_m != channel or self.box_m[1] != channel[1]:
            raise ValueError(
                f"channel_m = {channel}: plate_m = {self.plate_m} must be its floor,"
                f" and the box ({self.box_m[1]:g} m wide) as wide as it"
            )


def run_pile(
    rig: Pile,
    bench: Bench,
    rng: np.random.Generator,
    *,
    fps: float = 0.0,
    watch: Watch = no_watch,
    engine: Engine = OURS,
    filled: Filled | None = None,
    lying: Filled | None = None,
) -> Motion:
    """Fill, lift the gate, wait, look. The motion's last frame is the photo; with fps >
    0 the frames before it are the film. filled: a filling to use in place of a new one
    (the same packing for other parameters); lying: a heap to begin with."""
    motion = run_heap(
        vessel(rig, bench),
        bench,
        rng,
        fps=fps,
        watch=watch,
        engine=engine,
        filled=filled,
        lying=lying,
    )
    if motion.frames == 1 or lying is not None:
        return motion
    return replace(motion, parts=(*motion.parts, _gate(rig, motion.t_s)))


def vessel(rig: Pile, bench: Bench) -> Vessel:
    """The box as something that is filled and lifted."""
    x, y, z = rig.box_m
    smooth = Contact(
        (bench.seed.name, GLASS.name),
        bench.seed_seed.restitution,
        0.0,
        0.0,
        bench.seed_seed.rolling_convention,
    )
    return Vessel(
        chute=Chute((0.0, -y / 2, 0.0), (x, y / 2, z)),
        volume_m3=x * y * rig.fill_height_m,
        fill_height_m=rig.fill_height_m,
        lift_m_s=rig.gate_speed_m_s,
        lift_m=rig.gate_m[1],
        photo_s=rig.photo_s,
        walls=lambda tall, lift: _walls(rig, bench, tall, lift),
        domain=((-0.05, -0.5, -0.03), (rig.plate_m[0] + 0.1, 0.5, 1.5)),
        opening_m=y if rig.slab else rig.gate_m[0],
        parts=_parts(rig),
        contacts=(smooth,) if rig.slab else (),
        wall_m=0.0,
    )


def _walls(rig: Pile, bench: Bench, tall: float, lift: Chosen) -> list[Wall]:
    """Bottom plate, box without floor, gate."""
    x, width, z = rig.box_m
    high, y = max(tall, z), width / 2
    deep = y if rig.slab else rig.plate_m[1] / 2
    side = GLASS if rig.slab else bench.wall
    along = rig.plate_m[0] if rig.slab or rig.channel_m else x
    gap = 0.0 if rig.slab else (width - rig.gate_m[0]) / 2
    up = (0.0, 0.0, high)
    made: list[Wall] = [
        Rectangle(
            "plate", bench.wall, (0, -deep, 0), (rig.plate_m[0], 0, 0), (0, 2 * deep, 0)
        ),
        Rectangle("back", bench.wall, (0, -y, 0), (0, width, 0), up),
        Rectangle("near side", side, (0, -y, 0), (along, 0, 0), up),
        Rectangle("far side", side, (0, y, 0), (along, 0, 0), up),
        Rectangle(
            "gate",
            bench.wall,
            (x, -y + gap, 0),
            (0, width - 2 * gap, 0),
            up,
            (Slide(lift, (0, 0, 1)),),
        ),
    ]
    if rig.channel_m:
        end = (rig.plate_m[0], -y, 0)
        made.append(Rectangle("end", bench.wall, end, (0, width, 0), up))
    if gap > 0:
        made += [
            Rectangle("near post", bench.wall, (x, -y, 0), (0, gap, 0), up),
            Rectangle("far post", bench.wall, (x, y - gap, 0), (0, gap, 0), up),
        ]
    return made


def _gate(rig: Pile, t_s: np.ndarray) -> Part:
    """The gate on its way up, which begins with the film."""
    x, (wide, high) = rig.box_m[0], rig.gate_m
    gate = slab("gate", (x, -wide / 2, 0.0), (x + THICKNESS_M, wide / 2, high))
    poses = np.tile(gate.poses, (len(t_s), 1))
    poses[:, 2] = np.minimum(rig.gate_speed_m_s * (t_s - t_s[0]), high)
    return replace(gate, poses=poses)


def _parts(rig: Pile):
    """What is seen in the photo; the gate has been taken away."""
    x, width, z = rig.box_m
    y, t = width / 2, THICKNESS_M
    deep = width / 2 if rig.slab else rig.plate_m[1] / 2
    parts = [
        slab("plate", (-t, -deep, -2 * t), (rig.plate_m[0], deep, 0.0)),
        slab("back", (-t, -y - t, 0.0), (0.0, y + t, z)),
    ]
    if rig.channel_m:
        end = rig.plate_m[0]
        parts.append(slab("end", (end, -y - t, -2 * t), (end + t, y + t, z)))
    if rig.side_walls_in_view:
        parts += [
            slab("near side", (0, -y - t, 0), (x, -y, z)),
            slab("far side", (0, y, 0), (x, y + t, z)),
        ]
    return tuple(parts)
