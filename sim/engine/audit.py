"""No run makes energy: at intervals what is there is held against what was there before
and what walls and body laws put in."""

import math

import numpy as np

from benchtwin.sim.engine.bodies import DIAMETER, MASS, SHAPE_MASS, V
from benchtwin.sim.engine.gathering import (
    S_CONTACTS,
    S_EXTRA,
    S_NORMAL,
    S_TANGENTIAL,
    S_WALLS,
)
from benchtwin.sim.engine.kernels import LEDGER_NAMES, T_POWER
from benchtwin.sim.engine.sleeping import SLEEP_EVERY
from benchtwin.sim.engine.state import State, free_energies
from benchtwin.sim.engine.time_step import held_j, longest_steps
from benchtwin.sim.engine.world import Tables, World

# An audit costs some hundred steps of one seed, and one step of many. At a multiple of
# SLEEP_EVERY sleepers' contacts are known too.
LEAST_STEPS, BALL_STEPS = 64 * SLEEP_EVERY, 30_000
ADHESION, WALLS, BODY_LAWS = (
    LEDGER_NAMES.index(name) for name in ("adhesion", "walls", "body_laws")
)


class Audit:
    """Of one run. A gain: kinetic, potential and stored energy, less what walls and
    body laws put in, above the least that it has been (friction and damping only take);
    or normal laws that gave more than the contacts that there are can hold. What is
    there: the most that ever moved and was stored, how far potential energy went, and
    all seeds' weight times a diameter."""

    def __init__(self, world: World, tables: Tables, state: State) -> None:
        steps = max(LEAST_STEPS, BALL_STEPS // len(state.ball))
        self.interval = steps // SLEEP_EVERY * SLEEP_EVERY
        self.world, self.given_before = world, float(state.ledger[ADHESION])
        sizes = tables.shape[state.shape_of]
        weight = np.linalg.norm(world.gravity) * sizes[:, SHAPE_MASS]
        self.at_rest = float(weight @ sizes[:, DIAMETER])
        self.held, self.least, self.moving = held_j(world), math.inf, 0.0
        self.low, self.high = math.inf, -math.inf
        if not world.sleep or state.step % SLEEP_EVERY == 0:
            self.look(state)  # else sleepers' stored energy is not in the sums

    def until_next(self, state: State) -> int:
        """Steps until it is due."""
        return self.interval - state.step % self.interval

    def gone(self, before: State, after: State) -> None:
        """Seeds have left, and took their energy with them."""
        if after.count < before.count:
            was, now = (free_energies(s, self.world.gravity) for s in (before, after))
            self.least -= sum(was) - sum(now)

    def look(self, state: State) -> str:
        """What is wrong, in words; "": nothing."""
        sums, ledger = state.sums.sum(axis=0), state.ledger
        half = 0.5 * state.dt  # the ledger counts a step's end for the whole of it
        put_in = float(ledger[WALLS] + ledger[BODY_LAWS])
        put_in -= half * float(sums[S_WALLS] + state.totals[:, T_POWER].sum())
        taken = float(ledger[ADHESION] - half * sums[S_EXTRA]) - self.given_before
        kinetic, potential = free_energies(state, self.world.gravity)
        stored = float(sums[S_NORMAL] + sums[S_TANGENTIAL])
        now = kinetic + potential + stored + taken - put_in
        self.moving = max(self.moving, kinetic + stored)
        self.low, self.high = min(self.low, potential), max(self.high, potential)
        there = self.at_rest + self.moving + self.high - self.low
        gain, given = now - self.least, -taken - self.held * float(sums[S_CONTACTS])
        self.least = min(self.least, now)
        if max(gain, given) <= self.world.most_gain * there:
            return ""
        return self._said(state, max(gain, given), there, given > gain)

    def _said(self, state: State, gain: float, there: float, by_normal: bool) -> str:
        m, laws = state.motion, self.world.active_laws
        fastest = state.ids[np.argmax(m[:, MASS] * (m[:, V : V + 3] ** 2).sum(axis=1))]
        steps = longest_steps(self.world)
        stiffest = min(steps, key=lambda name: steps[name])
        names = [c.law.name for c in laws if c.law.kind == "normal" or not by_normal]
        why = f"{', '.join(names) or 'a law'} gives more than it takes"
        if not by_normal:
            why += (
                f", or the step of {state.dt:.3g} s is too long ({stiffest} allows"
                f" {steps[stiffest]:.3g} s)"
            )
        return (
            f"energy is made: {gain:.3g} J by step {state.step} (t ="
            f" {state.time_s:.6g} s), {100 * gain / there:.2g} % of what is there, most"
            f" of it in seed {fastest}: {why}"
        )
