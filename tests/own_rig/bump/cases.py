"""Cases of bumps for `benchtwin prove`: seeds that lose restitution with every bump."""

from typing import Any, NamedTuple

import numpy as np
import pandas as pd

from benchtwin.prove.cases.bench import Recording, Request, Scene
from benchtwin.prove.cases.record import Cases, Effect, world_with
from benchtwin.prove.cases.snr import WHITE, Change, Visibility, fitted

START_DEG, READ_SD_DEG, READINGS = 60.0, 0.5, 12


EFFECTS = {"wear": Effect(("impact",), "1", 0.0005, 0.05, -1)}


class Bump(NamedTuple):
    """One seed, bumped again and again: restitution, what readers miss by [deg]."""

    e: float
    off_deg: tuple[float, ...]


World = world_with(EFFECTS, Bump)


def draw(request: Request, rng: np.random.Generator) -> Scene:
    """Seeds of one restitution."""
    off, e = rng.normal(0, READ_SD_DEG, (4, READINGS)), rng.uniform(0.4, 0.8)
    return Scene(tuple(World(e, tuple(row)) for row in off), request, {})


def simulate(world: Any) -> np.ndarray:
    """How far a seed swings back after each bump [deg]."""
    e = world.e * (1 + world.wear) ** np.arange(READINGS)
    return 2 * np.degrees(np.arcsin(e * np.sin(np.radians(START_DEG / 2))))


def visibility(scene: Scene, name: str) -> Visibility:
    """How visible an effect is beside any restitution."""
    free = {"e": np.full((1, READINGS), 1 / READ_SD_DEG)}
    changes = []
    for world in scene.worlds:
        change = simulate(world) - simulate(world._replace(**{name: 0.0}))
        changes.append(Change(change[None] / READ_SD_DEG, free, {}, {"e": np.inf}))
    return Visibility(fitted(changes, WHITE).snr)


def record(scene: Scene, world: Any, name: str) -> Recording:
    """What is read of one seed."""
    read = (simulate(world) + world.off_deg).round(1)
    table = pd.DataFrame({"swing_back_deg": read})
    return Recording(name, {"bump": {"start_deg": START_DEG}}, readings=table)


CASES = Cases(
    rig="bump",
    share=0.1,
    colour="#555555",
    effects=EFFECTS,
    draw=draw,
    visibility=visibility,
    record=record,
    singles=("wear",),
)
