"""Cases of bumps for `benchtwin prove`: seeds that lose restitution with every bump."""

from dataclasses import dataclass

import numpy as np
import pandas as pd

from benchtwin.prove.cases.bench import Bench, Recording, Request
from benchtwin.prove.cases.record import Cases, Effect
from benchtwin.prove.cases.snr import Visibility, scatter_snr

START_DEG, READ_SD_DEG, READINGS = 60.0, 0.5, 12


@dataclass(frozen=True)
class Run:
    """One seed, bumped again and again: what readers miss by [deg]."""

    off_deg: tuple[float, ...]


@dataclass(frozen=True)
class Scene:
    """Seeds of one restitution."""

    e: float
    runs: tuple[Run, ...]
    request: Request


def draw(request: Request, rng: np.random.Generator) -> Scene:
    """A scene of the requested effects."""
    off = rng.normal(0, READ_SD_DEG, (4, READINGS))
    runs = tuple(Run(tuple(row)) for row in off)
    return Scene(rng.uniform(0.4, 0.8), runs, request)


def angles(scene: Scene, sizes: dict[str, float]) -> np.ndarray:
    """How far a seed swings back after each bump [deg]."""
    e = scene.e * (1 + sizes.get("wear", 0.0)) ** np.arange(READINGS)
    return 2 * np.degrees(np.arcsin(e * np.sin(np.radians(START_DEG / 2))))


def visibility(scene: Scene, sizes: dict[str, float], name: str) -> Visibility:
    """How visible the wear is beside any restitution."""
    change = angles(scene, sizes) - angles(scene, sizes | {name: 0.0})
    sd = np.full(READINGS, READ_SD_DEG / np.sqrt(len(scene.runs)))
    return Visibility(scatter_snr(change, sd, np.ones((READINGS, 1))))


def bench(scene: Scene, sizes: dict[str, float]) -> Bench:
    """The bench folder of a scene with this wear."""
    toml = {"rig": "bump", "bump": {"start_deg": START_DEG}}
    recordings = []
    for k, run in enumerate(scene.runs, 1):
        read = (angles(scene, sizes) + run.off_deg).round(1)
        table = pd.DataFrame({"swing_back_deg": read})
        recordings.append(Recording(f"bump-{k:02d}", toml, readings=table))
    return Bench({}, tuple(recordings))


CASES = Cases(
    rig="bump",
    share=0.1,
    colour="#555555",
    effects={"wear": Effect(("impact",), "1", 0.0005, 0.05, -1)},
    draw=draw,
    visibility=visibility,
    bench=bench,
    singles=("wear",),
)
