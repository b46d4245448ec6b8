"""Draw-down: a box of seeds empties through a slot in its floor onto a tray below; a
slope stays above, a heap lies below (Roessler, Richter, Katterfeld & Will 2019, Powder
Technol. 343, 803–812)."""

from dataclasses import dataclass

import numpy as np

from benchtwin.sim.engine.walls import Rectangle, Slide, Wall
from benchtwin.sim.laws import Chosen
from benchtwin.sim.material import Contact, Material
from benchtwin.sim.motion import Motion
from benchtwin.sim.rigs.bench import Bench, Watch, no_watch
from benchtwin.sim.rigs.engine import OURS, Engine
from benchtwin.sim.rigs.filling import RAIN_OVERLAP, Chute, Filled
from benchtwin.sim.rigs.heap import (
    Vessel,
    grams,
    mean_slope,
    run_heap,
    weights,
)
from benchtwin.sim.rigs.parts import slab
from benchtwin.sim.rigs.pile import GLASS, THICKNESS_M
from benchtwin.sim.rigs.profile import balls, centroid_angle, slope_angle, upper_edge

# shares of the mass that comes out, between which the flow is timed: before it the
# slide still opens, after it the slope above runs out seed by seed
TIMED = (0.1, 0.9)
OF_A_FLOW = (
    *("shear_angle_deg", "shear_centroid_deg", "heap_angle_deg", "heap_centroid_deg"),
    "flow_time_s",
)
FLOW_FPS = 100.0  # looks at the flow, for its time
STEP_M = 1e-4  # between columns of an outline


@dataclass(frozen=True)
class Drawdown:
    """Two panes, and between them a box on a shelf, and a tray below.

    box_m: inside length (x, from the back wall to the end wall), width (y, between the
    panes) and height. slot_m: how far the shelf ends before the end wall: the slot is
    as wide as the box. fill_height_m: the seeds are struck off there. fall_m: from the
    shelf's top down to the tray; tray_m: the tray's length, its middle below the
    slot's; seeds run over its ends. slide_speed_m_s: how fast the slide below the slot
    is drawn out. pane_friction: static friction of seed on pane.
    slab: panes without friction, a slice out of a wide box. photo_s: when the picture
    is taken after the slide begins to move, None: when all seeds lie still."""

    box_m: tuple[float, float, float] = (0.105, 0.030, 0.100)
    slot_m: float = 0.025
    fill_height_m: float = 0.060
    fall_m: float = 0.080
    tray_m: float = 0.140
    slide_speed_m_s: float = 0.25
    pane_friction: float = 0.3
    slab: bool = False
    photo_s: float | None = None

    def __post_init__(self) -> None:
        sizes = (*self.box_m, self.slot_m, self.fill_height_m, self.fall_m, self.tray_m)
        if not all(v > 0 for v in (*sizes, self.slide_speed_m_s)):
            raise ValueError(f"every length and speed must be above 0 in {self}")
        if self.fill_height_m > self.box_m[2]:
            raise ValueError(
                f"fill_height_m = {self.fill_height_m:g}: the box is only"
                f" {self.box_m[2]:g} m high"
            )
        if self.slot_m >= self.box_m[0]:
            raise ValueError(
                f"slot_m = {self.slot_m:g}: the box is only {self.box_m[0]:g} m long"
            )

    @property
    def shelf_m(self) -> float:
        """Length of the shelf, from the back wall to the slot."""
        return self.box_m[0] - self.slot_m

    @property
    def tray_ends_m(self) -> tuple[float, float]:
        """Where the tray begins and ends (x)."""
        middle = self.shelf_m + self.slot_m / 2
        return middle - self.tray_m / 2, middle + self.tray_m / 2


def run_drawdown(
    rig: Drawdown,
    bench: Bench,
    rng: np.random.Generator,
    *,
    fps: float = 0.0,
    watch: Watch = no_watch,
    engine: Engine = OURS,
    filled: Filled | None = None,
) -> Motion:
    """Fill, draw the slide, wait, look; fps, filled: as `run_pile`.

    Truth: jammed (1: at the end a seed's middle lies over the outer half of the open
    slot: the slope's last seeds overhang its edge by less, and nothing but an arch to
    the end wall can hold one there); `OF_A_FLOW`, NaN where it jammed: angle and
    centroid's angle of the slope above and of the heap below, time in which `TIMED` of
    the mass that comes out is through; filled_mass_g, retained_mass_g in the box,
    tray_mass_g."""
    box = vessel(rig, bench)
    return run_heap(box, bench, rng, fps=fps, watch=watch, engine=engine, filled=filled)


def vessel(rig: Drawdown, bench: Bench) -> Vessel:
    """The box as something that is filled and opened."""
    x, y, z = rig.box_m
    return Vessel(
        chute=Chute((0.0, -y / 2, 0.0), (x, y / 2, z)),
        volume_m3=x * y * rig.fill_height_m,
        fill_height_m=rig.fill_height_m,
        lift_m_s=rig.slide_speed_m_s,
        lift_m=rig.slot_m,
        photo_s=rig.photo_s,
        walls=lambda tall, lift: _walls(rig, bench, tall, lift),
        domain=(
            (min(0.0, rig.tray_ends_m[0]) - 0.1, -0.5, -rig.fall_m - 0.03),
            (max(x, rig.tray_ends_m[1]) + 0.1, 0.5, 1.5),
        ),
        opening_m=rig.slot_m,
        parts=_parts(rig),
        contacts=_on_panes(rig, bench),
        clear_m=rig.slot_m,
        overlap=RAIN_OVERLAP,
        told=lambda motion: _truth(rig, motion),
        look_fps=FLOW_FPS,
    )


def _pane(rig: Drawdown, bench: Bench) -> Material:
    """What the panes are of: as hard as the plate, under a name of their own."""
    if rig.slab:
        return GLASS
    of = bench.wall
    return Material(
        "pane",
        of.density_kg_m3,
        of.shear_modulus_pa,
        of.poisson_ratio,
        "a pane, as the plate but for friction",
    )


def _on_panes(rig: Drawdown, bench: Bench) -> tuple[Contact, ...]:
    pane, on = _pane(rig, bench), bench.seed_wall
    both, convention = (bench.seed.name, pane.name), on.rolling_convention
    if rig.slab:
        return (Contact(both, bench.seed_seed.restitution, 0.0, 0.0, convention),)
    friction, rolling = rig.pane_friction, on.rolling_friction
    return (Contact(both, on.restitution, friction, rolling, convention),)


def _walls(rig: Drawdown, bench: Bench, tall: float, lift: Chosen) -> list[Wall]:
    """Shelf, slide, tray, back and end wall, panes from the tray's foot to the top."""
    x, width, z = rig.box_m
    high, y, fall = max(tall, z), width / 2, rig.fall_m
    first, last = rig.tray_ends_m
    left, right = min(0.0, first), max(x, last)
    of, pane = bench.wall, _pane(rig, bench)
    across, up = (0, width, 0), (0, 0, high)
    along, whole = (right - left, 0, 0), (0, 0, high + fall)
    return [
        Rectangle("shelf", of, (0, -y, 0), (rig.shelf_m, 0, 0), across),
        Rectangle(
            "slide",
            of,
            (rig.shelf_m, -y, 0),
            (rig.slot_m, 0, 0),
            across,
            (Slide(lift, (1, 0, 0)),),
        ),
        Rectangle("tray", of, (first, -y, -fall), (rig.tray_m, 0, 0), across),
        Rectangle("back", of, (0, -y, 0), across, up),
        Rectangle("end", of, (x, -y, 0), across, up),
        Rectangle("near pane", pane, (left, -y, -fall), along, whole),
        Rectangle("far pane", pane, (left, y, -fall), along, whole),
    ]


def _parts(rig: Drawdown):
    """What is seen in the photo: the panes are clear, the slide has been drawn out."""
    (x, width, z), t = rig.box_m, THICKNESS_M
    y, (first, last) = width / 2, rig.tray_ends_m
    return (
        slab("shelf", (-t, -y, -t), (rig.shelf_m, y, 0.0)),
        slab("back", (-t, -y, 0.0), (0.0, y, z)),
        slab("end", (x, -y, 0.0), (x + t, y, z)),
        slab("tray", (first, -y, -rig.fall_m - t), (last, y, -rig.fall_m)),
    )


def _truth(rig: Drawdown, motion: Motion) -> dict[str, float]:
    at, nan = motion.positions_m[-1], float("nan")
    above = at[:, 2] > 0  # NaN, of a seed that is gone: neither above nor below
    arched = above & (at[:, 0] > rig.shelf_m + rig.slot_m / 2)
    below = at[:, 2] < 0
    told = weights(motion, above)
    told["tray_mass_g"] = float(grams(motion)[below].sum())
    if arched.any():
        return told | dict.fromkeys(OF_A_FLOW, nan) | {"jammed": 1.0}
    first, last = rig.tray_ends_m
    slope = _outline(motion, 0.0, rig.box_m[0], 0.0)
    heap = _outline(motion, first, last, -rig.fall_m)
    found = (
        slope_angle(*slope),
        centroid_angle(*slope, wall_m=0.0),
        mean_slope(*heap),
        centroid_angle(*heap),
        flow_time(motion),
    )
    return told | dict(zip(OF_A_FLOW, found, strict=True)) | {"jammed": 0.0}


def _outline(
    motion: Motion, low_m: float, high_m: float, floor_m: float
) -> tuple[np.ndarray, np.ndarray]:
    """x [m] and height [m] over a floor of the seeds on it: those above the shelf where
    that is the floor, else those below."""
    centres, radii = balls(motion)
    there = (centres[:, 2] > 0) == (floor_m == 0)
    x = np.arange(low_m, high_m, STEP_M)
    centres = centres[there] - (0.0, 0.0, floor_m)
    return x, upper_edge(centres, radii[there], x, 0.0)


def flow_time(motion: Motion) -> float:
    """Time [s] from when the first of `TIMED` of the mass that comes out is through the
    shelf's height, to when the last is; NaN where nothing comes out."""
    mass, height = grams(motion), motion.positions_m[:, :, 2]
    out = ((~(height > 0)) * mass).sum(axis=1)
    if not out[-1] > 0:
        return float("nan")
    share = np.maximum.accumulate(out / out[-1])
    first, last = (float(np.interp(s, share, motion.t_s)) for s in TIMED)
    return last - first
