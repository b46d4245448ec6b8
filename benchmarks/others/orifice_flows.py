"""Nine flows of spheres through an orifice that another program (LIGGGHTS) simulated,
run again by ours.

    git clone https://github.com/JoshuaMayo-vectr/DEM-calibration FOLDER
    python benchmarks/others/orifice_flows.py FOLDER [--points 9] [--seed 1]
        [--spring type_c]

FOLDER's `templates/drawdown.in` fills a cylinder with 4000 spheres, draws a plug out of
the hole in its floor and counts what falls through; its `drawdown_probe.csv` holds the
mass flow of two runs each at nine points, its `templates/meshes` the walls, which are
used as they are. The flow is the slope of mass over time between a fifth and four
fifths of what comes out, as theirs. Printed: ours beside theirs, and the mean
difference with its 95 % interval.

As theirs: E = 1e7 Pa, Poisson's ratio 0.25, friction capped by the whole normal force,
rolling friction by epsd2 (`liggghts.py`; `--spring type_c`: Ai's). Not as theirs:
filled from a grid, not at random; steps of a fifth of the Rayleigh time (theirs
0.07)."""

import argparse
from pathlib import Path

import numpy as np
import pandas as pd
from liggghts import GRAIN, WALL, balls, contact, rolling, told

from benchtwin.sim.engine.step import Every, init, run
from benchtwin.sim.engine.walls import Mesh, Slide
from benchtwin.sim.engine.world import Scattered, World
from benchtwin.sim.laws import LAWS

COUNT, FILL_S, FLOW_S, LOOK_S = 4000, 0.5, 1.4, 0.008
LOW, HIGH = (-0.026, -0.026, 0.004), (0.026, 0.026, 0.13)
COUNTED_M = -0.03  # height of their counting plane
PROBE = Path("results/phase9-drum/drawdown-probe/drawdown_probe.csv")


def world(folder: Path, at: dict[str, float], spring: str) -> World:
    """Their cylinder, floor and plug, and the grains above."""
    meshes = folder / "templates" / "meshes"
    numbers = (at["fric"], at["rollfric"], at["rest"])
    away = LAWS["motion_steady"].use(rate=0.5, start=FILL_S, duration=0.18)
    return World(
        (Scattered(balls(), GRAIN, COUNT, LOW, HIGH, (0.0, 0.0, -0.3)),),
        (
            Mesh.from_file(meshes / "cylinder_r0.040_h0.100.stl", "cylinder", WALL),
            Mesh.from_file(meshes / "floor_annulus_r0.046_o0.011.stl", "floor", WALL),
            Mesh.from_file(
                meshes / "plug_disk_r0.0135.stl",
                "plug",
                WALL,
                moves=(Slide(away, (0, 0, -1)),),
            ),
        ),
        (contact(GRAIN, *numbers), contact(WALL, *numbers)),
        laws=(rolling(spring),),
        domain=((-0.14, -0.14, -0.06), (0.14, 0.14, 0.3)),
        cap_damped=True,
        most_overlap=0.3,
    )


def flow(made: World, seed: int) -> float:
    """Mass flow [g/s] of one run."""
    seen: list[tuple[float, float]] = []

    def look(of: World, state) -> None:
        inside = state.motion[:, 2] > COUNTED_M
        seen.append((state.time_s, 1e3 * float(state.motion[inside, 9].sum())))

    state = init(made, np.random.default_rng(seed))
    run(made, state, FILL_S + FLOW_S, [Every(LOOK_S, look)])
    t, left = np.array(seen).T
    out = left[0] - left
    middle = (out >= 0.2 * out[-1]) & (out <= 0.8 * out[-1])
    return float(np.polyfit(t[middle], out[middle], 1)[0])


def main() -> None:
    """Run and print, point by point."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--points", type=int, default=9)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--spring", choices=("epsd2", "type_c"), default="epsd2")
    asked = parser.parse_args()
    theirs = pd.read_csv(asked.folder / PROBE).head(asked.points)
    print("friction  rolling  restitution   theirs (sd)    ours [g/s]")
    apart = []
    for row in theirs.to_dict("records"):
        ours = flow(world(asked.folder, row, asked.spring), asked.seed)
        apart.append(ours - row["flow_gs"])
        here = f"{row['flow_gs']:6.1f} ({row['flow_gs_std']:.1f})  {ours:6.1f}"
        at = f"{row['fric']:8.3f} {row['rollfric']:8.3f} {row['rest']:12.2f}"
        print(f"{at}   {here}", flush=True)
    if len(apart) > 1:
        one = float(np.sqrt((theirs["flow_gs_std"] ** 2).mean()))
        print(told(apart, one * np.sqrt(1.5), "g/s"))


if __name__ == "__main__":
    main()
