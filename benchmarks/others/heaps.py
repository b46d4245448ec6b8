"""Heaps of a lifted cylinder that another program (LIGGGHTS) simulated, run again by
ours, beside Zhou's closed form.

    git clone https://github.com/JoshuaMayo-vectr/DEM-calibration FOLDER
    python benchmarks/others/heaps.py FOLDER [--points 12] [--of 0/1] [--seed 1]
        [--runs 2] [--spring type_c] [--steps 0.07] [--awake]

FOLDER's `templates/aor.in` fills a cylinder of 80 mm with 4000 spheres, lifts it by 55
mm at 10 mm/s and lets the heap come to rest; its `lhs_results.csv` holds angle and bulk
density of 45 points, two runs each. Of those above 10° (below, a layer runs out to the
walls) `--points` are taken, spread evenly over their angles (`--of 1/2`: the second of
two parts, for two processes). Ours are measured
by their own code, `calibration/measure.py`. Printed: ours beside theirs, their mean
difference with its 95 % interval, and how many agree within the scatter of `--runs` of
ours and of their two.

Zhou's form (Zhou, Xu, Yu and Zulli 2002, Powder Technol. 125, 45): angle = 68.61
μ_s,pp^0.27 μ_s,pw^0.22 μ_r,pp^0.06 μ_r,pw^0.12 d^−0.2 [°], rolling friction and
diameter in mm. It is for spheres of 2 to 10 mm with rolling friction up to 0.1 mm;
elsewhere no number is printed. Their rolling friction is a share of the reduced radius.

As theirs: E = 1e7 Pa, Poisson's ratio 0.25, friction capped by the whole normal force,
rolling friction by epsd2 (`liggghts.py`; `--spring type_c`: Ai's). Not as theirs:
filled from a grid, not at random; a round tube in the place of a mesh; steps of 0.3 of
the Rayleigh time (theirs 0.07: `--steps`); seeds at rest sleep (`--awake`: they do
not)."""

import argparse
import sys
from importlib import import_module
from pathlib import Path
from types import ModuleType

import numpy as np
import pandas as pd
from liggghts import GRAIN, WALL, balls, contact, rolling, spheres, told

from benchtwin.sim.engine.step import init, run
from benchtwin.sim.engine.walls import Cylinder, Plane, Slide
from benchtwin.sim.engine.world import Placed, World
from benchtwin.sim.laws import LAWS

SETTLE_S, LIFT_M, LIFT_M_S, RELAX_S = 0.4, 0.055, 0.010, 0.4
COUNT, LOW, HIGH = 4000, (-0.026, -0.026, 0.004), (0.026, 0.026, 0.13)
TUBE_M = (0.040, 0.100)  # radius, height
DIAMETER_MM, MOST_ROLLING_MM = 3.7, 0.1
LAYER_DEG = 10.0
TABLE = Path("results/phase7-lhs/lhs_results.csv")


def filling() -> Placed:
    """4000 grains on a shaken grid, lowest first, falling."""
    rng, shapes = np.random.default_rng(1), balls()
    radius = max(ball.bounding_radius_m for ball in shapes)
    low, high, pitch = np.array(LOW), np.array(HIGH), 2.04 * radius
    lines = ((high - low) / pitch).astype(int)[::-1]
    grid = np.stack(np.unravel_index(np.arange(COUNT), lines), axis=1)[:, ::-1]
    shake = rng.uniform(-0.02, 0.02, grid.shape) * radius
    falling = np.tile((0.0, 0.0, -0.3), (COUNT, 1))
    return Placed(
        shapes,
        GRAIN,
        low + (grid + 0.5) * pitch + shake,
        velocities=falling,
        shape_of=rng.integers(0, len(shapes), COUNT),
    )


def world(at: dict[str, float], spring: str, steps: float, awake: bool) -> World:
    """Their plate and tube, and 4000 grains above."""
    radius, height = TUBE_M
    lift = LAWS["motion_steady"].use(
        rate=LIFT_M_S, start=SETTLE_S, duration=LIFT_M / LIFT_M_S
    )
    end = (0.0, 0.0, height)
    numbers = (at["fric"], at["rollfric"], at["rest"])
    return World(
        (filling(),),
        (
            Plane("plate", WALL, (0.0, 0.0, 0.0), (0.0, 0.0, 1.0)),
            Cylinder("tube", WALL, (0, 0, 0), end, radius, (Slide(lift, (0, 0, 1)),)),
        ),
        (contact(GRAIN, *numbers), contact(WALL, *numbers)),
        laws=(rolling(spring),),
        domain=((-0.14, -0.14, -0.02), (0.14, 0.14, 0.3)),
        cap_damped=True,
        most_overlap=0.3,
        rayleigh_fraction=steps,
        sleep=not awake,
    )


def heap(made: World, seed: int, theirs: ModuleType) -> tuple[float, float]:
    """Angle of the heap [°] and bulk density in the tube [kg/m³] of one run."""
    state = run(made, init(made, np.random.default_rng(seed)), SETTLE_S)
    density = theirs.measure_bulk_density(spheres(state))["bulk_density_kgm3"]
    state = run(made, state, SETTLE_S + LIFT_M / LIFT_M_S + RELAX_S)
    return theirs.measure_angle(spheres(state))["angle_deg"], density


def zhou_deg(friction: float, rolling: float) -> float:
    """Zhou's angle [°] with one friction of grain and wall; NaN where it does not claim
    to hold."""
    rolling_mm = rolling * DIAMETER_MM / 4
    if rolling_mm > MOST_ROLLING_MM:
        return float("nan")
    return 68.61 * friction**0.49 * rolling_mm**0.18 * DIAMETER_MM**-0.2


def beside_zhou(heaps: pd.DataFrame) -> str:
    """Zhou's angle less theirs, where it claims to hold."""
    formed = [zhou_deg(mu, mu_r) for mu, mu_r in zip(heaps["fric"], heaps["rollfric"])]
    apart = (pd.Series(formed, index=heaps.index) - heaps["aor"]).dropna()
    told = f"{apart.mean():+.1f}°, sd {apart.std():.1f}°"
    return f"Zhou less theirs, {len(apart)} heaps: {told}"


def chosen(table: pd.DataFrame, points: int, part: str) -> pd.DataFrame:
    """Points spread over the angles, and of these one part."""
    heaps = table[table["aor"] > LAYER_DEG]
    ranked = heaps.sort_values("aor", ascending=False, ignore_index=True)
    spread = ranked.iloc[np.linspace(0, len(ranked) - 1, points).round().astype(int)]
    first, parts = map(int, part.split("/"))
    return spread.iloc[first::parts]


def main() -> None:
    """Run and print, point by point."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--points", type=int, default=12)
    parser.add_argument("--of", default="0/1")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--runs", type=int, default=2)
    parser.add_argument("--spring", choices=("epsd2", "type_c"), default="epsd2")
    parser.add_argument("--steps", type=float, default=0.3)
    parser.add_argument("--awake", action="store_true")
    asked = parser.parse_args()
    sys.path.insert(0, str(asked.folder / "calibration"))
    theirs = import_module("measure")
    table = pd.read_csv(asked.folder / TABLE)
    # sd of one run of theirs: aor_std is that of a population of two
    one = float(np.sqrt(2 * (table["aor_std"] ** 2).mean()))
    print(beside_zhou(table[table["aor"] > LAYER_DEG]))
    print("friction  rolling  restitution   theirs (sd)    ours   Zhou [deg]   kg/m³")
    apart, scatter = [], []
    for row in chosen(table, asked.points, asked.of).to_dict("records"):
        made = world(row, asked.spring, asked.steps, asked.awake)
        runs = [heap(made, asked.seed + k, theirs) for k in range(asked.runs)]
        angle, density = np.mean(runs, axis=0)
        apart.append(angle - row["aor"])
        scatter.append(np.var(runs, axis=0, ddof=1)[0] if asked.runs > 1 else one**2)
        zhou = zhou_deg(row["fric"], row["rollfric"])
        at = f"{row['fric']:8.3f} {row['rollfric']:8.3f} {row['rest']:12.2f}"
        here = f"{row['aor']:6.1f} ({row['aor_std']:.1f})  {angle:6.1f}  {zhou:6.1f}"
        print(f"{at}   {here}    {row['bulk_density']:.0f}, {density:.0f}", flush=True)
    if len(apart) > 1:
        sd = float(np.sqrt(one**2 / 2 + np.mean(scatter) / asked.runs))
        print(told(apart, sd, "deg"))


if __name__ == "__main__":
    main()
