"""Drop 500 soybeans into a box of Q235 steel and say how high they lie, how dense, and
how hard they press on the floor."""

import numpy as np

from benchtwin.sim.engine.observe import Settled
from benchtwin.sim.engine.step import init, run
from benchtwin.sim.engine.walls import box
from benchtwin.sim.engine.world import Scattered, World
from benchtwin.sim.material import Q235, SOYBEAN, SOYBEAN_Q235, SOYBEAN_SOYBEAN
from benchtwin.sim.seed import Seed


def drop(count: int = 500, side_m: float = 0.07):
    bean = Seed.from_dimensions(8.72e-3, 6.84e-3, 5.98e-3)
    soft = SOYBEAN.softened(1e7)  # longer contacts, overlaps below 2 %; they lie alike
    low, high = (0, 0, 0), (side_m, side_m, 0.3)
    beans = Scattered((bean,), soft, count, low=low, high=high)
    steel = box("box", Q235, low, high)
    world = World((beans,), steel, (SOYBEAN_Q235, SOYBEAN_SOYBEAN))
    at_rest = Settled(window_s=0.05, displacement=1e-2, kinetic=1e-5)
    state = run(world, init(world, np.random.default_rng(1)), at_rest, threads=2)
    height = np.quantile(state.positions[:, 2], 0.98)
    density = count * bean.volume_m3 / (side_m**2 * height)
    return state, height, density, -state.wall_load[world.wall_index("box-floor"), 2]


if __name__ == "__main__":
    state, height, density, push = drop()
    print(f"{state.count} soybeans at rest after {state.time_s:.2f} s,")
    print(f"{1e3 * height:.0f} mm high, {density:.2f} of it filled; the floor carries")
    print(f"{push:.2f} N of {9.80665 * state.masses.sum():.2f} N, the sides the rest")
