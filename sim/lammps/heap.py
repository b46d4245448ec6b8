"""A heap in LAMMPS: the vessel that our engine fills and lifts, from the same seeds in
the same places, with the same end."""

from dataclasses import replace

import numpy as np
from benchtwin.sim.engine.observe import Settled
from benchtwin.sim.engine.world import World
from benchtwin.sim.lammps.run import Lammps
from benchtwin.sim.lammps.stage import Stage
from benchtwin.sim.motion import Motion
from benchtwin.sim.rigs import filling, heap
from benchtwin.sim.rigs.bench import Bench, Watch
from benchtwin.sim.rigs.heap import Vessel

LOOK_S = 0.01
FRAME_S = 0.05  # of the seeds' places where no film is asked for


def run_heap(
    vessel: Vessel,
    bench: Bench,
    rng: np.random.Generator,
    *,
    fps: float,
    watch: Watch,
    lammps: Lammps,
) -> Motion:
    """As `sim.rigs.heap.run_heap`, in three stages: fill, rest, and pile, in which part
    of the vessel is lifted.

    bench: with a law that LAMMPS has (`sim.lammps.contact.in_lammps_law`), the vessel
    made with it."""
    filled = _fill(vessel, bench, rng, lammps, watch)
    placed = filled.placed(bench)
    standing = vessel.walls(0.0, vessel.lift(None))
    rest_world = bench.world(
        placed, standing, domain=vessel.domain, contacts=vessel.contacts
    )
    rest = Stage(
        "rest",
        rest_world,
        None,
        FRAME_S,
        LOOK_S,
        filling.LONGEST_S,
        still=filling.QUIET,
    )
    lain = lammps.run(rest, "coming to rest", watch)
    placed = replace(placed, orientations=lain.rows[-1, :, 3:7])
    lifted = vessel.walls(0.0, vessel.lift(0.0))
    world = bench.world(placed, lifted, domain=vessel.domain, contacts=vessel.contacts)
    out_s = (vessel.fill_height_m + 0.01) / vessel.lift_m_s
    frame_s = 1 / fps if fps > 0 else FRAME_S
    look_s = max(round(LOOK_S / frame_s), 1) * frame_s if fps > 0 else LOOK_S
    if vessel.photo_s is not None:
        pile = Stage("pile", world, "rest", frame_s, look_s, vessel.photo_s)
    else:
        pile = Stage(
            "pile",
            world,
            "rest",
            frame_s,
            look_s,
            out_s + heap.LONGEST_S,
            least_s=out_s,
            still=Settled(**heap.REST),
        )
    way = lammps.run(pile, "lifting and settling", watch)
    motion = Motion(
        shapes=filled.shapes,
        shape_of=filled.shape_of,
        parts=vessel.parts,
        **way.columns(pile.step_s),
    )
    heap.tell(motion, vessel, filled, still=lammps.still(pile))
    return motion


def _fill(
    vessel: Vessel, bench: Bench, rng: np.random.Generator, lammps: Lammps, watch: Watch
) -> filling.Filled:
    """Rain seeds into the standing vessel and strike them off, as
    `sim.rigs.heap.fill`."""

    def lay(standing: World) -> tuple[np.ndarray, np.ndarray]:
        stage = Stage(
            "fill",
            standing,
            None,
            FRAME_S,
            LOOK_S,
            filling.LONGEST_S,
            still=filling.POURED,
        )
        last = lammps.run(stage, "filling", watch).rows[-1]
        return last[:, :3], last[:, 3:7]

    return heap.fill_with(vessel, bench, rng, lay)
