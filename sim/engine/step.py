"""init, step, run: from a world to a state, and from a state to a later one."""

import math
import sys
import threading
import time
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from benchtwin.sim.engine import bodies, kernels, lists, turning
from benchtwin.sim.engine import state as states
from benchtwin.sim.engine.audit import Audit
from benchtwin.sim.engine.compiled import fingerprint, is_kept, kernel
from benchtwin.sim.engine.filling import check_apart, place
from benchtwin.sim.engine.gathering import S_OVERLAP, SUMS
from benchtwin.sim.engine.kernels import (
    DONE,
    LEDGER_NAMES,
    RUNAWAY,
    SQUEEZED,
    STALE,
    View,
)
from benchtwin.sim.engine.lists import relist
from benchtwin.sim.engine.pace import Pace
from benchtwin.sim.engine.state import State
from benchtwin.sim.engine.time_step import farthest_reach_m, time_step
from benchtwin.sim.engine.world import Tables, World, tabulate_world
from benchtwin.sim.laws import LAWS
from benchtwin.sim.rotation import turned

# a quarter of a second or so, after which Ctrl-C gets its turn
BALL_STEPS_A_CALL = 2_000_000


class Stopped(RuntimeError):
    """A watch ended the run; `state` is where it stood."""

    def __init__(self, message: str, state: State):
        super().__init__(message)
        self.state = state


@dataclass(frozen=True)
class Every:
    """Call `look(world, state)` every `seconds` of simulated time (and at the start); a
    true answer ends the run."""

    seconds: float
    look: Callable[[World, State], object]

    def __post_init__(self):
        if not self.seconds > 0:
            raise ValueError(f"Every: seconds = {self.seconds} must be > 0")


@lru_cache(maxsize=8)
def tables_of(world: World) -> Tables:
    """The world's seeds, walls and materials as the tables that kernels read."""
    return tabulate_world(world)


def init(
    world: World, rng: np.random.Generator, *, allowed_overlap: float = 1e-3
) -> State:
    """The state at t = 0: seeds placed, lists made, forces known.

    Seeds that overlap each other or a wall by more than `allowed_overlap` of a radius
    are refused, before anything is compiled; give more for seeds that are placed as a
    settled bed had them."""
    tables, dt = tables_of(world), time_step(world)
    kind, x, q, v, w = place(world, rng)
    _check_inside(world, x)
    n, shape = len(kind), tables.shape[kind]
    motion = np.column_stack([x, v, w, shape[:, bodies.SHAPE_MASS]])
    counts = lists.ball_counts(tables, kind)
    ball_start = np.concatenate([[0], np.cumsum(counts)])
    m = int(ball_start[-1])
    starts = tables.shape_start
    numbers = np.concatenate([np.arange(starts[k], starts[k + 1]) for k in kind])
    owner = np.repeat(np.arange(n, dtype=np.uint32), counts)
    ball = tables.shape_ball[numbers]
    ball[:, :3] = x[owner] + turned(q[owner], ball[:, :3])
    check_apart(world, tables.walls, ball, owner, allowed_overlap)
    walls, columns = tables.walls, kernels.memory_columns(world.active_laws)
    state = State(
        step=0,
        dt=dt,
        skin=lists.choose_skin(ball[:, 3], len(walls.kind), farthest_reach_m(world)),
        ids=np.arange(n),
        motion=motion,
        turn=q,
        spin=np.zeros((n, 3)),
        load=np.zeros((n, bodies.LOAD)),
        calm=np.zeros(n, np.int16),
        shape_of=kind.astype(np.uint32),
        material=tables.shape_material[kind],
        ball=ball,
        owner=owner,
        ball_id=np.arange(m, dtype=np.uint32),
        ball_start=ball_start,
        path=np.zeros(m),
        pair_i=np.zeros(0, np.uint32),
        pair_j=np.zeros(0, np.uint32),
        pair_memory=np.zeros((0, columns)),
        pair_touch=np.zeros(0, np.uint8),
        wall_i=np.zeros(0, np.uint32),
        wall_p=np.zeros(0, np.uint32),
        wall_memory=np.zeros((0, columns)),
        wall_touch=np.zeros(0, np.uint8),
        block_body=np.array([0, n]),
        block_pair=np.zeros(2, np.int64),
        block_wall=np.zeros(2, np.int64),
        block_window=np.zeros(2, np.int64),
        sums=np.zeros((1, SUMS)),
        totals=np.zeros((1, kernels.TOTALS)),
        prim=walls.prim.copy(),
        prim_ref=walls.prim.copy(),
        twist=np.zeros((len(world.walls), 6)),
        wall_load=np.zeros((len(world.walls), 3)),
        wall_push_ns=np.zeros((len(world.walls), 3)),
        ledger=np.zeros(len(LEDGER_NAMES)),
        removed=np.zeros(0, np.int64),
    )
    _starter()(
        state.motion,
        state.turn,
        state.spin,
        state.shape_of,
        tables.shape,
        tables.shape_start,
        tables.shape_ball,
        state.ball_start,
        state.ball.ravel(),
        state.path,
    )
    state = relist(tables, state)
    return first_forces(world, state)


def start_bodies(
    motion, turn, spin, shape_of, shape, shape_start, shape_ball, ball_start, ball, path
):
    """Angular momenta from spins, balls from bodies."""
    for n in range(len(motion)):
        m, s = motion[n], shape[shape_of[n]]
        turned = turning.matrix(turn[n, 0], turn[n, 1], turn[n, 2], turn[n, 3])
        a, b, c, d, e, f, g, h, i = turned
        x, y, z = m[6], m[7], m[8]
        p = (a * x + d * y + g * z) / s[0]
        q = (b * x + e * y + h * z) / s[1]
        r = (c * x + f * y + i * z) / s[2]
        spin[n, 0] = a * p + b * q + c * r
        spin[n, 1] = d * p + e * q + f * r
        spin[n, 2] = g * p + h * q + i * r
        bodies.place_balls(
            ball_start[n],
            m[0],
            m[1],
            m[2],
            turned,
            shape_of[n],
            shape_start,
            shape_ball,
            ball,
            path,
        )


@lru_cache(maxsize=1)
def _starter():
    return kernel(start_bodies, fingerprint("start"))


def _check_inside(world: World, x: np.ndarray) -> None:
    if world.domain is not None:
        outside = np.flatnonzero(
            ~((x >= world.domain[0]) & (x <= world.domain[1])).all(axis=1)
        )
        if len(outside):
            raise ValueError(
                f"seeds: number {outside[0]} at {x[outside[0]]} m is outside the domain"
                f" {world.domain}"
            )


def first_forces(world: World, state: State) -> State:
    """The same state with the forces of its first prediction: a step of next to no
    length, which moves nothing."""
    tables = tables_of(world)
    view = _view(world, tables, state)
    status = np.array([STALE, 0, 0])  # as if the positions had just been predicted
    run = _kernel_of(world, tables)
    before = (0, 1, 1, 0, 1e-30, np.inf, np.inf, np.inf, view)
    counters = np.zeros(8, np.int64)
    scratch = kernels.scratch_for(view)
    run(*before, scratch, counters, status, state.ledger, state.wall_push_ns)
    return state


def _view(world: World, tables: Tables, s: State) -> View:
    """What the kernels see: the arrays of `s` themselves, of its world, and scratch."""
    w, blocks, pairs = tables.walls, len(s.block_body) - 1, len(s.pair_i)
    trait = tables.trait[s.shape_of].ravel()
    seen = {**vars(tables), **vars(s)}  # those that bear the same name
    seen |= {
        "motion": s.motion.ravel(),
        "body": s.motion,
        "trait": trait,
        "ball": s.ball.ravel(),
        "pair_quiet": np.full(pairs, -1.0, np.float32),
        "awake": np.zeros(pairs, np.uint32),
        "awakes": np.full(blocks, -1),
        "sleeps": world.sleep,
        "woken": np.zeros(2, np.int64),
        "window": np.zeros(bodies.FROM_CONTACTS * int(s.block_window[-1])),
        "prim_rest": w.prim,
        "prim_kind": w.kind,
        "prim_wall": w.wall,
        "corners": w.corners,
        "wall_push": np.zeros((blocks, len(world.walls), 6)),
        "moves": w.moves,
        "move_numbers": w.move_numbers,
        "wall_way": np.zeros(1),
        "table": tables.pairs,
        "materials": len(tables.materials),
        "gravity": np.asarray(world.gravity, float),
        "shared": world.share_damping and bool(len(s.ball) > len(s.motion)),
        "single": bool(np.all(trait[1::2] > 0)),
        "pull": np.inf if world.pull_at_end else 0.0,
        "whole": float(world.cap_damped),
    }
    return View(**{name: seen[name] for name in View._fields})


def _kernel_of(world: World, tables: Tables):
    laws = tuple(c.law for c in world.active_laws)
    # one step loop for walls that stand, and for those that also move steadily
    moves = tables.walls.motion_laws or (LAWS["motion_steady"],)
    run, mark = kernels.build(laws, moves, ledger=world.ledger)
    if mark not in _ANNOUNCED and not is_kept("advance", mark):
        print(
            "benchtwin: compiling the step loop for these laws (once; 10 to 20 s) …",
            file=sys.stderr,
            flush=True,
        )
    _ANNOUNCED.add(mark)
    return run


_ANNOUNCED: set[str] = set()


def step(world: World, state: State) -> State:
    """The state one time step later."""
    return run(world, state, steps=1)


def run(
    world: World,
    state: State,
    until: float | Callable[[World, State], object] | None = None,
    observers: Iterable[Every] = (),
    *,
    steps: int | None = None,
    threads: int = 1,
    every_s: float = 0.01,
) -> State:
    """Move on to time `until` [s], or until `until(world, state)` is true (asked every
    `every_s` of simulated time), or by `steps` steps.

    The given state is left as it is. The result does not depend on `threads`,
    observers, or on stops and restarts on the way. Raises `Stopped` when seeds overlap
    by more than `most_overlap`, run away, or make energy."""
    if (until is None) == (steps is None):
        raise ValueError("run: give either until or steps")
    if threads < 1:
        raise ValueError(f"run: threads = {threads} must be 1 or more")
    looks = list(observers)
    last = state.step + steps if steps is not None else None
    if callable(until):
        looks.append(Every(every_s, until))
    elif until is not None:
        last = math.ceil(until / state.dt - 1e-9)
    if last is not None and last < state.step:
        raise ValueError(
            f"run: until = {until} s lies before the state's t = {state.time_s:g} s"
        )
    state = state.copy()
    if not world.sleep:
        state.calm[:] = 0  # who slept in another world is awake in this one
    due, pace = [_next_look(look, state) for look in looks], Pace(threads)
    audit = Audit(world, tables_of(world), state) if steps is None else None
    over = False
    while True:
        for k, look in enumerate(looks):
            if not over and state.step >= due[k]:
                over = bool(look.look(world, state))
                due[k] = _next_look(look, state, after=True)
        if over or (last is not None and state.step >= last):
            if audit is not None and not world.sleep:
                _check(audit, state)
            return state
        goal = min([*due, last] if last is not None else due)
        state = _advance(world, state, goal - state.step, pace, audit)


def _check(audit: Audit, state: State) -> None:
    if why := audit.look(state):
        raise Stopped(why, state)


def _next_look(look: Every, state: State, *, after: bool = False) -> int:
    """The step at or after this one (after it) at which an observer is due: multiples
    of its interval since t = 0."""
    per_look = look.seconds / state.dt
    k = math.ceil(state.step / per_look - 1e-9)
    due = round(k * per_look)
    while due < state.step + after:
        k += 1
        due = round(k * per_look)
    return due


def _advance(
    world: World, state: State, steps: int, pace: Pace, audit: Audit | None
) -> State:
    """The same state `steps` steps later (its arrays are used up)."""
    tables = tables_of(world)
    loop = _kernel_of(world, tables)
    view, scratch = _room(world, tables, state, pace.numbers[0])
    status, most = np.array([DONE, 0, 0]), 1 + BALL_STEPS_A_CALL // len(state.ball)
    while steps > 0:
        threads, share = pace.next_call()
        began = time.perf_counter()
        most_steps = min(steps, max(1, int(share * most)))
        if audit is not None:
            most_steps = min(most_steps, audit.until_next(state))
        _in_threads(loop, scratch[:threads], most_steps, state, world, view, status)
        pace.took(
            threads, time.perf_counter() - began, int(status[1]) * len(state.ball)
        )
        steps -= int(status[1])
        state = state.changed(step=state.step + int(status[1]))
        if status[0] in (SQUEEZED, RUNAWAY):
            raise Stopped(_why(world, state, int(status[0])), state)
        if audit is not None and state.step % audit.interval == 0 and not status[0]:
            _check(audit, state)
        if status[0] == STALE:
            before, state = state, relist(tables, state, world.domain)
            if audit is not None:
                audit.gone(before, state)
            view, scratch = _room(world, tables, state, pace.numbers[0])
    return state


def _room(
    world: World, tables: Tables, state: State, threads: int
) -> tuple[View, list[kernels.Scratch]]:
    view = _view(world, tables, state)
    useful = min(threads, len(state.block_body) - 1)
    return view, [kernels.scratch_for(view) for _ in range(useful)]


def _in_threads(
    loop,
    scratch: list[kernels.Scratch],
    steps: int,
    state: State,
    world: World,
    view: View,
    status: np.ndarray,
) -> None:
    limits = (world.most_overlap, world.most_speed_m_s)
    before = (len(scratch), steps, state.step, state.dt, state.skin, *limits, view)
    after = (np.zeros(8, np.int64), status, state.ledger, state.wall_push_ns)
    others = [
        threading.Thread(target=loop, args=(me, *before, scratch[me], *after))
        for me in range(1, len(scratch))
    ]
    for other in others:
        other.start()
    loop(0, *before, scratch[0], *after)
    for other in others:
        other.join()


def _why(world: World, state: State, status: int) -> str:
    now = f"at t = {state.time_s:.6g} s"
    if status == SQUEEZED:
        worst = 100.0 * float(state.sums[:, S_OVERLAP].max())
        return (
            f"largest overlap {worst:.0f} % of the radius {now}: reduce dt or stiffen"
            f" (most_overlap = {world.most_overlap:g})"
        )
    speed = math.sqrt(
        float(np.max(np.nan_to_num(state.totals[:, kernels.T_FASTEST], nan=np.inf)))
    )
    limit = f"most_speed_m_s = {world.most_speed_m_s:g}"
    return (
        f"a seed at {speed:.4g} m/s {now}, above {limit}: reduce dt, or look for"
        " overlapping walls"
    )


save, load = states.save, states.load
