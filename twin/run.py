"""simulate: parameters and a description → a recording, as from the bench; observe: a
recording → what is measured on it."""

import json
import os
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np

from benchtwin.bench.rigs import RIGS
from benchtwin.bench.whole_file import new_folder
from benchtwin.measure.observe import (
    observe as observe,
)  # the same call for bench and twin
from benchtwin.sim.engine.state import State
from benchtwin.sim.engine.world import World
from benchtwin.sim.motion import Motion
from benchtwin.sim.ondem import STATE
from benchtwin.sim.ondem.write import write_state
from benchtwin.sim.rigs.bench import no_watch
from benchtwin.sim.rigs.engine import forget
from benchtwin.sim.rigs.filling import Filled
from benchtwin.twin import write
from benchtwin.twin.engine import OWN, Engine, kept_inputs
from benchtwin.twin.parameters import Parameters
from benchtwin.twin.scene import (
    camera_of,
    camera_section,
    rig_of,
    section_of,
    setup_of,
)
from benchtwin.twin.versions import versions
from benchtwin.vision.motion.of_recording import PICTURES
from benchtwin.vision.recording import Recording, read_recording, write_recording

Watch = Callable[[str, float], None]
RECORD = "simulation.json"
# to be raised when the same input gives another outcome: what stores hold of older ones
# is then computed anew
MODEL = 5


def simulate(
    rig: str,
    parameters: Parameters,
    *,
    rng: np.random.Generator,
    out: Path,
    like: Recording | None = None,
    rendered: bool = True,
    watch: Watch = no_watch,
    threads: int = 2,
    engine: Engine = OWN,
    more: dict | None = None,
    save: bool = False,
    lying: Filled | None = None,
) -> Recording:
    """Run a rig, film or photograph it, and write that into the folder `out` as a
    recording with provenance "simulated".

    rig: one of `bench.rigs.RIGS`. like: a recording whose rig, seed,
    air and camera are the twin's too; what it leaves open is the paper's.
    rendered=False writes the track (pile: the angle of the true outline) that the
    simulation knows in place of pictures. Beside the recording stands simulation.json:
    what was assumed, by which versions, what the simulation knows of the answer, and
    `more`. save: how the run ended, in state.vtkhdf, contacts included (of LAMMPS, a
    heap's); lying: a heap to begin with. The folder appears whole or not at all;
    LAMMPS's inputs, in `lammps/`, too. Raises ValueError for a rig, camera or number
    that does not fit; FileExistsError when `out` is there; RuntimeError where an engine
    stops."""
    recording = like or Recording(out.name, out, rig, "", ())
    if recording.rig != rig:
        raise ValueError(
            f"rig = {rig!r}, but the recording to be like is a {recording.rig}"
        )
    if os.path.lexists(out):
        raise FileExistsError(f"{out} is there already")
    ended: list[tuple[World, State]] = []
    scratch, engine = out.with_name(f".{out.name}.lammps"), engine.for_rig(rig)
    motion, told = run(
        recording,
        parameters,
        rng=rng,
        watch=watch,
        threads=threads,
        engine=engine,
        scratch=scratch,
        keep=(lambda *end: ended.append(end)) if save else forget,
        lying=lying,
    )
    with new_folder(out) as part:
        told = replace(told, id=out.name, path=part)
        if rendered and setup_of(recording).filmed:
            kind = write.pictures(motion, told, part, rng, watch)
        else:
            kind = write.numbers(motion, told, part)
        write_recording(told)
        _, converted = engine.bench(parameters, recording)
        computed = {
            "name": engine.name,
            "version": engine.version,
            "ranks": engine.ranks,
            "converted": converted,
        }
        told_of = (
            record(told, parameters, motion, kind) | {"engine": computed} | (more or {})
        )
        kept_inputs(scratch, part / "lammps")
        if save:
            write_state(part / STATE, *ended[-1])
        (part / RECORD).write_text(
            json.dumps(told_of, indent=1, allow_nan=False), encoding="utf8"
        )
    return read_recording(out)


def run(
    recording: Recording,
    parameters: Parameters,
    *,
    rng: np.random.Generator,
    watch: Watch = no_watch,
    threads: int = 2,
    engine: Engine = OWN,
    scratch: Path | None = None,
    keep: Callable[[World, State], object] = forget,
    lying: Filled | None = None,
) -> tuple[Motion, Recording]:
    """The run itself: its motion, and the recording (without evidence) that states all
    that it assumed. scratch: the folder in which LAMMPS works; keep: is told how the
    run ended; lying: a heap to begin with."""
    name = recording.need_rig()
    on_bench, _ = engine.bench(parameters, recording)
    setup = setup_of(recording)
    rate = recording.camera.fps or setup.fps
    filmed = not setup.photographed or recording.evidence in PICTURES
    fps = rate if filmed else 0.0
    motion = engine.run(
        recording,
        on_bench,
        rng,
        fps=fps,
        watch=watch,
        threads=threads,
        scratch=scratch,
        keep=keep,
        lying=lying,
    )
    camera = camera_of(recording)
    rig = rig_of(recording)
    section = section_of(rig, getattr(recording, name))
    if setup.photographed:
        seen = setup.told(rig, camera, motion)
        section = section.model_copy(update={**seen, **weights(name, motion)})
    told = replace(
        recording,
        provenance="simulated",
        evidence="",
        files=(),
        seed=write.seed_section(motion, on_bench, recording),
        camera=camera_section(camera, fps, recording.camera),
        **{name: section},
    )
    return motion, told


def weights(rig: str, motion: Motion) -> dict[str, float]:
    """What scales at the bench would have said of it, to a hundredth of a gram."""
    return {
        name: round(motion.truth[name], 2)
        for name in RIGS[rig].weighed
        if motion.truth.get(name, 0.0) > 0.005
    }


def record(
    recording: Recording, parameters: Parameters, motion: Motion, kind: str
) -> dict:
    """All that is needed to run it again, and what the simulation itself knows of the
    answer."""
    from benchtwin.sim.picture import renderer_name

    return {
        "schema": 1,
        "rig": recording.rig,
        "evidence": kind,
        "parameters": parameters.for_rig(recording.need_rig()).to_dict(),
        "truth": {
            key: (value if np.isfinite(value) else None)
            for key, value in motion.truth.items()
        },
        "versions": versions(),
        "renderer": renderer_name() if kind == "rendered" else None,
    }
