"""Nine flows of spheres through an orifice that another program (LIGGGHTS) simulated,
run again by ours.

    git clone https://github.com/JoshuaMayo-vectr/DEM-calibration FOLDER
    python benchmarks/others/orifice_flows.py FOLDER [--points 9] [--seed 1]

FOLDER's `templates/drawdown.in` fills a cylinder with 4000 spheres, draws a plug out of
the hole in its floor and counts what falls through; its `drawdown_probe.csv` holds the
mass flow of two runs each at nine points, its `templates/meshes` the walls, which are
used as they are. The flow is the slope of mass over time between a fifth and four
fifths of what comes out, as theirs. Printed: ours beside theirs, and the mean
difference with its 95 % interval.

As theirs: E = 1e7 Pa, Poisson's ratio 0.25, friction capped by the whole normal force.
Not as theirs: filled from a grid, not at random; rolling friction by Ai's type C
without dashpot, whose cap is that of LIGGGHTS's epsd2, but whose spring is softer;
steps of a fifth of the Rayleigh time (theirs 0.07)."""

import argparse
from pathlib import Path

import numpy as np
import pandas as pd
from benchtwin.sim.engine.step import Every, init, run
from benchtwin.sim.engine.walls import Mesh, Slide
from benchtwin.sim.engine.world import Scattered, World
from benchtwin.sim.laws import LAWS
from benchtwin.sim.material import Contact, Material
from benchtwin.sim.seed import Seed
from scipy import stats

GRAIN = Material("grain", 1400.0, 4e6, 0.25)
WALL = Material("wall", 1400.0, 4e6, 0.25)
# of 3.4, 3.7 and 4.0 mm: 25, 50 and 25 % of the mass are 32, 49 and 19 % of the grains
RADII_M, SHARES = (1.7e-3, 1.85e-3, 2.0e-3), (32, 49, 19)
COUNT, FILL_S, FLOW_S, LOOK_S = 4000, 0.5, 1.4, 0.008
LOW, HIGH = (-0.026, -0.026, 0.004), (0.026, 0.026, 0.13)
COUNTED_M = -0.03  # height of their counting plane
PROBE = Path("results/phase9-drum/drawdown-probe/drawdown_probe.csv")


def grains() -> Scattered:
    """4000 of theirs, falling."""
    middle, density = np.zeros((1, 3)), GRAIN.density_kg_m3
    balls = [Seed.from_spheres(middle, np.array([r]), density) for r in RADII_M]
    seeds = tuple(b for b, n in zip(balls, SHARES) for _ in range(n))
    return Scattered(seeds, GRAIN, COUNT, LOW, HIGH, (0.0, 0.0, -0.3))


def contacts(at: dict[str, float]) -> tuple[Contact, Contact]:
    """Grain on grain and on the walls, alike."""
    law = (at["rest"], at["fric"], at["rollfric"], "type_c")
    return (
        Contact((GRAIN.name, GRAIN.name), *law),
        Contact((GRAIN.name, WALL.name), *law),
    )


def world(folder: Path, at: dict[str, float]) -> World:
    """Their cylinder, floor and plug, and the grains above."""
    meshes = folder / "templates" / "meshes"
    away = LAWS["motion_steady"].use(rate=0.5, start=FILL_S, duration=0.18)
    return World(
        (grains(),),
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
        contacts(at),
        laws=(LAWS["rolling_type_c"].use(damping=0.0),),
        domain=((-0.14, -0.14, -0.06), (0.14, 0.14, 0.3)),
        cap_damped=True,
        most_overlap=0.3,
    )


def flow(folder: Path, at: dict[str, float], seed: int) -> float:
    """Mass flow [g/s] of one run."""
    seen: list[tuple[float, float]] = []

    def look(of: World, state) -> None:
        inside = state.motion[:, 2] > COUNTED_M
        seen.append((state.time_s, 1e3 * float(state.motion[inside, 9].sum())))

    made = world(folder, at)
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
    asked = parser.parse_args()
    theirs = pd.read_csv(asked.folder / PROBE).head(asked.points)
    print("friction  rolling  restitution   theirs (sd)    ours [g/s]")
    apart = []
    for row in theirs.to_dict("records"):
        ours = flow(asked.folder, row, asked.seed)
        apart.append(ours - row["flow_gs"])
        told = f"{row['flow_gs']:6.1f} ({row['flow_gs_std']:.1f})  {ours:6.1f}"
        at = f"{row['fric']:8.3f} {row['rollfric']:8.3f} {row['rest']:12.2f}"
        print(f"{at}   {told}", flush=True)
    if len(apart) > 1:
        mean, error = np.mean(apart), stats.sem(apart)
        half = stats.t.ppf(0.975, len(apart) - 1) * error
        print(f"ours less theirs: {mean:+.2f} ± {half:.2f} g/s (95 %)")


if __name__ == "__main__":
    main()
