"""Nine rotating drums that another program (LIGGGHTS) simulated, run again by ours.

    git clone https://github.com/JoshuaMayo-vectr/DEM-calibration FOLDER
    python benchmarks/others/drums.py FOLDER [--points 9] [--of 0/1] [--seed 1]

FOLDER's `templates/drum.in` half fills a drum of 150 × 25 mm with 4600 spheres, turns
it and its two covers at 5 rpm and dumps 17 frames; its `valley_check.csv` holds the
surface's mean angle of two runs each at nine points. Ours are measured by their own
code, `calibration/measure.py`. Printed: ours beside theirs, their mean difference with
its 95 % interval, and how many agree within the scatter of one run of ours and the mean
of their two.

As theirs: E = 1e7 Pa, Poisson's ratio 0.25, friction capped by the whole normal force,
rolling friction by epsd2 (`liggghts.py`), meshes, covers' friction. Not as theirs:
filled from a grid, not by a stream; steps of 0.3 of the Rayleigh time (theirs 0.07)."""

import argparse
import sys
from importlib import import_module
from pathlib import Path
from types import ModuleType

import numpy as np
import pandas as pd
from liggghts import GRAIN, RADII_M, WALL, balls, contact, rolling, spheres, told

from benchtwin.sim.engine.step import Every, init, run
from benchtwin.sim.engine.walls import Mesh, Turn
from benchtwin.sim.engine.world import Placed, World
from benchtwin.sim.laws import LAWS
from benchtwin.sim.material import Material

COVER = Material("cover", 1400.0, 4e6, 0.25)
COVER_FRICTION, COVER_ROLLING = 0.36, 0.29
RADIUS_M, HALF_WIDTH_M, COUNT = 0.075, 0.0125, 4600
SETTLE_S, SPIN_S, FILM_S, LOOK_S, TURN_S = 0.8, 3.0, 3.2, 0.2, 12.0
PITCH_M = 2.025 * max(RADII_M)
PROBE = Path("results/phase9-drum/valley_check.csv")


def filling(rng: np.random.Generator) -> Placed:
    """4600 grains on a grid inside the drum, lowest first, falling."""
    lines = [
        np.arange(-half + PITCH_M / 2, half, PITCH_M)[: int(2 * half / PITCH_M)]
        for half in (HALF_WIDTH_M, RADIUS_M, RADIUS_M)
    ]
    y, z, x = (line - line.mean() for line in lines)
    grid = np.stack(np.meshgrid(z, y, x, indexing="ij"), -1).reshape(-1, 3)
    inside = np.hypot(grid[:, 0], grid[:, 2]) < RADIUS_M - PITCH_M / 2
    places = grid[inside][:COUNT][:, [2, 1, 0]]
    shapes = balls()
    return Placed(
        shapes,
        GRAIN,
        places,
        velocities=np.tile([0.0, 0.0, -0.3], (COUNT, 1)),
        shape_of=rng.integers(len(shapes), size=COUNT),
    )


def world(folder: Path, at: dict[str, float], rng: np.random.Generator) -> World:
    """Their drum and covers, half full."""
    meshes = folder / "templates" / "meshes"
    turn = LAWS["motion_steady"].use(
        rate=2 * np.pi / TURN_S, start=SETTLE_S, duration=SPIN_S + FILM_S
    )
    turns = (Turn(turn, (0.0, 0.0, 0.0), (0.0, 1.0, 0.0)),)
    walls = [
        Mesh.from_file(meshes / f"{file}_r0.075_l0.025.stl", name, of, moves=turns)
        for file, name, of in (("drum", "drum", WALL), ("drum_caps", "covers", COVER))
    ]
    numbers = (at["fric"], at["rollfric"], at["rest"])
    return World(
        (filling(rng),),
        tuple(walls),
        (
            contact(GRAIN, *numbers),
            contact(WALL, *numbers),
            contact(COVER, COVER_FRICTION, COVER_ROLLING, at["rest"]),
        ),
        laws=(rolling(),),
        cap_damped=True,
        most_overlap=0.3,
        rayleigh_fraction=0.3,
    )


def surface_deg(made: World, rng: np.random.Generator, theirs: ModuleType) -> float:
    """Mean angle [°] of the flowing surface over the film."""
    angles = []

    def look(of: World, state) -> None:
        if state.time_s > SETTLE_S + SPIN_S - LOOK_S / 2:
            angles.append(theirs.measure_drum_frame(spheres(state))["angle_deg"])

    whole_s = SETTLE_S + SPIN_S + FILM_S
    run(made, init(made, rng), whole_s, [Every(LOOK_S, look)])
    return float(np.mean(angles))


def main() -> None:
    """Run and print, point by point."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--points", type=int, default=9)
    parser.add_argument("--of", default="0/1")
    parser.add_argument("--seed", type=int, default=1)
    asked = parser.parse_args()
    sys.path.insert(0, str(asked.folder / "calibration"))
    theirs = import_module("measure")
    table = pd.read_csv(asked.folder / PROBE)
    # sd of one run of theirs: drum_aor_std is that of a population of two
    one = float(np.sqrt(2 * (table["drum_aor_std"] ** 2).mean()))
    first, parts = map(int, asked.of.split("/"))
    print("friction  rolling  restitution   theirs (sd)    ours [deg]")
    apart = []
    for row in table.head(asked.points).iloc[first::parts].to_dict("records"):
        rng = np.random.default_rng(asked.seed)
        angle = surface_deg(world(asked.folder, row, rng), rng, theirs)
        apart.append(angle - row["drum_aor"])
        at = f"{row['fric']:8.3f} {row['rollfric']:8.3f} {row['rest']:12.2f}"
        print(
            f"{at}   {row['drum_aor']:6.1f} ({row['drum_aor_std']:.1f})  {angle:6.1f}",
            flush=True,
        )
    if len(apart) > 1:
        print(told(apart, one * np.sqrt(1.5), "deg"))


if __name__ == "__main__":
    main()
