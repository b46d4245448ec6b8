"""The compiled step loop for one set of laws: `build` gives `advance`, which every
thread of a run executes."""

from collections import namedtuple
from collections.abc import Callable
from functools import lru_cache

import numpy as np
from numba import njit

from benchtwin.sim.engine import assemble, bodies, gathering, sleeping, tiles
from benchtwin.sim.engine.bodies import correct, predict
from benchtwin.sim.engine.compiled import INNER, fingerprint, kernel
from benchtwin.sim.engine.contacts import block_forces, gather_forces
from benchtwin.sim.engine.gathering import S_OVERLAP
from benchtwin.sim.engine.parallel import barrier, take
from benchtwin.sim.engine.surfaces import place_walls
from benchtwin.sim.engine.view import View
from benchtwin.sim.laws.law import Chosen, Law

# Columns of a block's totals after `correct`, and the slots of `counters` and `status`.
# each thread's own
Scratch = namedtuple("Scratch", "tile active meet share fresh rows early who")

T_KINETIC, T_FASTEST, T_POWER, T_BRAKED, T_BRAKED_AHEAD, T_WAY = range(6)
TOTALS = 6
ARRIVED, PASSED, NEXT_CONTACT, NEXT_BODIES = range(4)
DONE, STALE, SQUEEZED, RUNAWAY = range(4)  # why `advance` came back
# Accounts of the ledger: what the run has turned into what, since it began [J].
LEDGER_NAMES = ("damping", "friction", "rolling", "adhesion", "walls", "body_laws")


LEDGER = False


def advance(
    me,
    threads,
    steps,
    start,
    dt,
    skin,
    most_overlap,
    most_speed,
    s,
    scratch,
    counters,
    status,
    ledger,
    impulse,
):
    """Up to `steps` steps from step number `start`, by thread `me` of `threads`; every
    thread calls this with the same arguments.

    A step is: predict, forces, correct; a block's correction is followed at once by its
    next prediction while its bodies are at hand, and two barriers a step do. Stops
    early when the neighbour lists may no longer hold everything near (STALE: positions
    are predicted, forces are still to come), when an overlap exceeds `most_overlap` of
    a radius (SQUEEZED) or a speed `most_speed` (RUNAWAY; NaN too): a state to look at
    then, its positions a step ahead. status: [why, steps done]. ledger adds up
    works and, where it is kept, dissipated energies, impulse (walls, 3) the seeds' push
    on the walls."""
    blocks = len(s.block_body) - 1
    # forces: of these positions are known; look: also between sleepers
    done = 0
    more = True
    forces = False
    look = False
    while True:
        if forces or status[0] != STALE:
            more = done + forces < steps
            overlap = squeeze(s.sums)
            b = take(counters, NEXT_BODIES, threads, 0)
            while b < blocks:
                first, last = s.block_body[b], s.block_body[b + 1]
                t = s.totals[b]
                t[T_BRAKED] = t[T_BRAKED_AHEAD] = 0.0
                if forces:
                    gather_forces(b, s, scratch.fresh)
                    t[T_KINETIC], t[T_FASTEST], t[T_POWER], t[T_BRAKED] = correct(
                        first,
                        last,
                        dt,
                        look and s.sleeps,
                        (start + done + 1) % 2,
                        s,
                        scratch.fresh,
                    )
                if more:
                    t[T_WAY], t[T_BRAKED_AHEAD] = predict(
                        first, last, dt, s, scratch.tile, scratch.who
                    )
                b = take(counters, NEXT_BODIES, threads, b + 1)
            if me == 0:
                counters[NEXT_CONTACT] = 0
                if forces:
                    add_walls(s.wall_push, s.wall_load, dt, impulse)
                    add_work(s.sums, dt, ledger)
                if more:
                    place_walls((start + done + forces + 1) * dt, s)
            barrier(counters, threads)
            why = DONE
            if me == 0:
                for b in range(blocks):
                    ledger[2] += s.totals[b, T_BRAKED]
                    ledger[5] += dt * s.totals[b, T_POWER] * forces
                # in its own loop: a run that goes on adds it after the step before
                for b in range(blocks):
                    ledger[2] += s.totals[b, T_BRAKED_AHEAD]
            if forces:
                done += 1
                if overlap > most_overlap:
                    why = SQUEEZED
                else:
                    why = runaway(s.totals, most_speed)
            if why == DONE and more and stale(s.totals, s.wall_way, skin):
                why = STALE
            if why != DONE or not more:
                # nobody may change `status` before all have read it
                barrier(counters, threads)
                if me == 0:
                    status[0], status[1] = why, done
                return
        woken = s.woken[(start + done) % 2]
        if me == 0:
            counters[NEXT_BODIES] = 0
            s.woken[(start + done + 1) % 2] = 0
        look = not s.sleeps or (start + done + 1) % sleeping.SLEEP_EVERY == 0
        account = LEDGER or done + 1 == steps
        b = take(counters, NEXT_CONTACT, threads, 0)
        while b < blocks:
            block_forces(b, dt, look, woken, account, s, scratch)
            b = take(counters, NEXT_CONTACT, threads, b + 1)
        barrier(counters, threads)
        forces = True


@njit(**INNER)
def stale(totals, wall_way, skin):
    """Whether a ball, or a ball and a wall together, may have come nearer than the
    lists know."""
    way = 0.0
    for b in range(len(totals)):
        way = max(way, totals[b, T_WAY])
    return not (2.0 * way < skin and way + wall_way[0] < skin)


@njit(**INNER)
def squeeze(sums):
    """Largest overlap over the smaller ball's radius."""
    overlap = 0.0
    for b in range(len(sums)):
        overlap = max(overlap, sums[b, S_OVERLAP])
    return overlap


@njit(**INNER)
def runaway(totals, most_speed):
    """RUNAWAY where a body is faster than `most_speed` [m/s] or its speed is not a
    number, else DONE."""
    for b in range(len(totals)):
        if not totals[b, T_FASTEST] <= most_speed * most_speed:  # NaN too
            return RUNAWAY
    return DONE


@njit(**INNER)
def add_walls(wall_push, wall_load, dt, impulse):
    """Total push of the seeds on each wall, block by block, and its time integral."""
    for w in range(len(wall_load)):
        for k in range(3):
            total = 0.0
            for b in range(len(wall_push)):
                total += wall_push[b, w, k]
            wall_load[w, k] = total
            impulse[w, k] += total * dt


def add_work(sums, dt, ledger):
    """Add the work that laws and moving walls did in one step of `dt` [s] to the energy
    ledger [J]."""
    for b in range(len(sums)):
        ledger[3] += dt * sums[b, gathering.S_EXTRA]
        ledger[4] += dt * sums[b, gathering.S_WALLS]
        if LEDGER:
            ledger[0] += dt * sums[b, gathering.S_DAMPED]
            ledger[1] += dt * sums[b, gathering.S_SLIPPED]
            ledger[2] += dt * sums[b, gathering.S_ROLLED]


def memory_columns(laws: tuple[Chosen, ...]) -> int:
    """How many numbers a contact must remember under these laws."""
    kinds = {c.law.kind for c in laws}
    if "spring" in kinds or any(c.law.memory for c in laws):
        return gathering.OWN_FIRST + sum(len(c.law.memory) for c in laws)
    return 7 if "rolling_spring" in kinds else 4 if "restitution" in kinds else 3


def scratch_for(view: View) -> Scratch:
    """Room for one thread to work in."""
    most = int(np.max(np.diff(view.block_pair) + np.diff(view.block_wall))) + 1
    rows = tiles.FIXED_ROWS + view.table.shape[1] - tiles.COLUMNS
    rows += max(view.pair_memory.shape[1] - gathering.OWN_FIRST, 0)
    bodies_a_block = int(np.max(np.diff(view.block_body)))
    return Scratch(
        np.zeros(rows * tiles.STRIDE),
        np.zeros(most, np.uint32),
        np.zeros((most, 6)),
        np.zeros(most),
        np.zeros((bodies_a_block, bodies.FROM_CONTACTS)),
        np.full(tiles.LANES, -1),
        np.zeros(tiles.LANES, np.int64),
        np.zeros(tiles.LANES, np.int64),
    )


@lru_cache(maxsize=32)
def build(
    laws: tuple[Law, ...], motion_laws: tuple[Law, ...], *, ledger: bool
) -> tuple[Callable, str]:
    """`advance` for these laws and wall motions; only which laws there are counts,
    their numbers are read from tables. Also its mark, by which it is kept on disk."""
    body = assemble.body_laws(tuple(law for law in laws if law.kind == "body"))
    motion = assemble.motions(motion_laws)
    used = [law.function for law in (*laws, *motion_laws)] + [
        law.reach for law in laws if law.reach
    ]
    sizes = [(law.kind, len(law.parameters), len(law.memory)) for law in laws]
    mark = fingerprint(*used, sizes, ledger)
    bound = assemble.contact_laws(assemble.places(laws)) | {"LEDGER": ledger}
    if body:
        bound |= {"HAS_BODY": True, "body_law": body}
    if motion:
        bound["motion"] = motion
    return kernel(advance, mark, **bound), mark
