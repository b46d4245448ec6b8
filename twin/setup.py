"""How a rig is simulated, filmed and written down."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from benchtwin.bench.rigs import RIGS
from benchtwin.sim.motion import Motion
from benchtwin.sim.picture import Camera, Look, project
from benchtwin.vision.recording import Recording


def as_stated(recording: Recording, given: dict[str, Any]) -> dict[str, Any]:
    """What the recording states, unchanged."""
    return given


def where_it_stands(recording: Recording, camera: Camera) -> Camera:
    """The camera, unchanged."""
    return camera


def nothing_more(rig: Any, camera: Camera, motion: Motion) -> dict[str, Any]:
    """No key."""
    return {}


@dataclass(frozen=True)
class Setup:
    """One kind of rig: its description, what runs it, the frame rate and camera where a
    recording states none, and its look.

    soft_pa: shear modulus to which seeds are softened; step: of the Rayleigh time
    (benchmarks/modulus.py, docs/engine.md: what these change and save). many: a heap or
    bed of seeds, simulated on several threads, all of it in the picture at the end;
    photographed: a photo of what is at rest in the place of a film; filmed: whether
    there is anything to show, else only what the simulation knows is written. begins:
    whether a run can begin with a heap that lies there. one_seed: the recording states
    the very seed, not the lot. in_lammps: whether LAMMPS has all of its walls. truth:
    what the simulation knows, as columns of readings.csv; (): a track, on a line where
    it is `straight`. fitting: completes or refuses what a recording states of it
    (ValueError); besides: keys of no field, for `fitting` or measuring to read; aimed:
    its own camera for a recording; variant: another setup for some recordings."""

    describe: type
    run: Callable
    fps: float
    camera: Camera
    look: Look
    soft_pa: float = 3e7
    step: float = 0.2
    many: bool = False
    photographed: bool = False
    filmed: bool = True
    begins: bool = False
    one_seed: bool = False
    straight: bool = False
    in_lammps: bool = True
    truth: tuple[str, ...] = ()
    fitting: Callable[[Recording, dict[str, Any]], dict[str, Any]] = as_stated
    aimed: Callable[[Recording, Camera], Camera] = where_it_stands
    variant: Callable[[Recording], "Setup | None"] = lambda recording: None
    told: Callable[[Any, Camera, Motion], dict[str, Any]] = nothing_more
    besides: tuple[str, ...] = ()


def of_heaps(describe: type, run: Callable, camera: Camera, **more: Any) -> Setup:
    """A rig of many seeds of which what lies at the end is photographed."""
    return Setup(
        describe,
        run,
        0.0,
        camera,
        Look(),
        soft_pa=3e6,
        step=0.3,
        many=True,
        photographed=True,
        **more,
    )


def level_line(
    camera: Camera, ends_m: tuple[float, float], y_m: float, z_m: float
) -> tuple[float, float, float, float]:
    """Where a level line between two x [m] is seen: x1, y1, x2, y2 [px]."""
    ends = project(camera, np.array([[x, y_m, z_m] for x in ends_m]))
    x1, y1, x2, y2 = (float(f"{v:.6g}") for v in ends.ravel())
    return x1, y1, x2, y2


def setup_for(rig: str) -> Setup:
    """How a rig is simulated where a recording states nothing else; ValueError where it
    cannot be."""
    return RIGS[rig].part("setup")
