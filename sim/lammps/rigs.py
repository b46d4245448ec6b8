"""Every rig that LAMMPS can run: the same geometry, seeds, placing and end as ours,
from the same random numbers."""

import math
from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np
from benchtwin.bench.constants import G_M_S2
from benchtwin.sim.engine.observe import Settled
from benchtwin.sim.lammps.alone import Alone
from benchtwin.sim.lammps.heap import run_heap
from benchtwin.sim.lammps.run import Lammps
from benchtwin.sim.motion import Motion
from benchtwin.sim.rigs import roll
from benchtwin.sim.rigs.bench import Bench, Watch, no_watch
from benchtwin.sim.rigs.cylinder import LiftedCylinder, run_cylinder
from benchtwin.sim.rigs.drop import Drop, run_drop
from benchtwin.sim.rigs.pile import Pile, run_pile
from benchtwin.sim.rigs.roll import Roll, run_roll
from benchtwin.sim.rigs.slide import Slide, run_slide

AIR_SLOWS = 1.2  # a fall through air lasts so much longer at most than one through none
BELOW_M = 0.06  # a seed so far below the plate's end has left it
BEYOND_M = 0.005  # the block slides so much farther than it has to


def run_rig(
    rig: Any,
    bench: Bench,
    rng: np.random.Generator,
    *,
    fps: float,
    lammps: Lammps,
    watch: Watch = no_watch,
) -> Motion:
    """Run a rig in LAMMPS. bench: with a law that LAMMPS has
    (`sim.lammps.contact.in_lammps_law`).

    ValueError names a rig that LAMMPS is not written for; RuntimeError what LAMMPS
    stopped with."""
    need_rig(type(rig))
    return RUNS[type(rig)](rig, bench, rng, fps=fps, lammps=lammps, watch=watch)


def need_rig(kind: type) -> None:
    """ValueError for a kind of rig that LAMMPS is not written for."""
    if kind not in RUNS:
        known = ", ".join(k.__name__ for k in RUNS)
        raise ValueError(
            f"--engine lammps: its inputs are not written for a {kind.__name__}; they"
            f" are for {known}"
        )


def _heap(run: Callable[..., Motion]) -> Callable[..., Motion]:
    def run_in_lammps(rig, bench, rng, *, fps, lammps, watch) -> Motion:
        return run(
            rig,
            bench,
            rng,
            fps=fps,
            watch=watch,
            engine=partial(run_heap, lammps=lammps),
        )

    return run_in_lammps


def _drop(
    rig: Drop, bench: Bench, rng, *, fps: float, lammps: Lammps, watch: Watch
) -> Motion:
    """For as long as the flights would last if nothing were lost, or until the seed has
    fallen off the plate."""
    fall_s = math.sqrt(2 * rig.height_m / G_M_S2)
    longest_s = 0.1 + AIR_SLOWS * fall_s * (1 + 2 * rig.bounces)
    low = BELOW_M + rig.plate_m[0] * math.tan(math.radians(abs(rig.tilt_deg)))
    title = "falling and bouncing"
    over = f"v_z<-{low:.9g}"
    engine = Alone(lammps, "drop", title, watch, longest_s=longest_s, over=over)
    return run_drop(rig, bench, rng, fps=fps, watch=watch, engine=engine)


def _slide(
    rig: Slide, bench: Bench, rng, *, fps: float, lammps: Lammps, watch: Watch
) -> Motion:
    """Until the block is nearer to the hinge, the y axis, than its travel asks for."""
    near = rig.start_m - rig.travel_m - BEYOND_M
    title = "tilting until they slide"
    over = f"sqrt(v_x*v_x+v_z*v_z)<{near:.9g}"
    engine = Alone(lammps, "slide", title, watch, over=over)
    return run_slide(rig, bench, rng, fps=fps, watch=watch, engine=engine)


def _roll(
    rig: Roll, bench: Bench, rng, *, fps: float, lammps: Lammps, watch: Watch
) -> Motion:
    """Until the seed has lain still for twice as long as `sim.rigs.roll.Rest` looks, or
    has fallen off the plate."""
    still = Settled(
        window_s=2 * roll.REST_S, displacement=roll.REST_WAY / 3, kinetic=1e-3
    )
    engine = Alone(
        lammps, "roll", "rolling", watch, still=still, over=f"v_z<-{BELOW_M:g}"
    )
    return run_roll(rig, bench, rng, fps=fps, watch=watch, engine=engine)


RUNS: dict[type, Callable[..., Motion]] = {
    Pile: _heap(run_pile),
    LiftedCylinder: _heap(run_cylinder),
    Drop: _drop,
    Slide: _slide,
    Roll: _roll,
}
