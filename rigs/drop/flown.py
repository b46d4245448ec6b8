"""The twin's seeds set off as a recording shows them: flights from their own starts,
impacts at their own speeds."""

from dataclasses import dataclass

import numpy as np

from benchtwin.bench.constants import G_M_S2
from benchtwin.rigs.drop import RIG
from benchtwin.sim.engine.step import Every, init, run
from benchtwin.sim.engine.walls import Rectangle
from benchtwin.sim.engine.world import Placed
from benchtwin.sim.motion import Motion
from benchtwin.sim.rigs.bench import Frames, reach
from benchtwin.sim.rotation import about, any_turn, product
from benchtwin.twin.lone_seed import bench_of
from benchtwin.twin.parameters import Parameters

NAME = RIG.name
# between kept states; between them a cubic through places and speeds, good to 1e-9 m
EVERY_S = 1e-3
APART_M = 0.05  # neighbours in one world never meet
ALONGSIDE_M = 2.0  # nor do those that fly towards the camera
ABOVE_S = 1e-3  # before touch, where a seed that is to strike begins
STRIKE_S = 0.012  # after that all have left the plate, or lie on it


@dataclass(frozen=True, eq=False)
class Flown:
    """F seeds at m moments t_s (m,): places and speeds (m, F, 2) in x and z."""

    t_s: np.ndarray
    places: np.ndarray
    speeds: np.ndarray

    def at(self, flight: int, time: np.ndarray) -> np.ndarray:
        """Places (n, 2) of one seed by Hermite's cubic."""
        step = self.t_s[1] - self.t_s[0]
        k = np.clip((time / step).astype(int), 0, len(self.t_s) - 2)
        u = (time / step - k)[:, None]
        p, v = self.places[:, flight], self.speeds[:, flight] * step
        return (
            p[k] * (1 + 2 * u) * (1 - u) ** 2
            + v[k] * u * (1 - u) ** 2
            + p[k + 1] * u**2 * (3 - 2 * u)
            - v[k + 1] * u**2 * (1 - u)
        )


def fly(
    description: dict,
    laws: dict[str, dict],
    starts: np.ndarray,
    spin: np.ndarray,
    longest_s: float,
) -> Flown:
    """F seeds in free flight from starts (F, 5): x, z [m], their speeds and that along
    the line of sight [m/s]; spin (F,) [rad/s] anticlockwise in the picture."""
    made, seed = bench_of(NAME, description, laws, Parameters())
    count = len(starts)
    place, speed, turning = (np.zeros((count, 3)) for _ in range(3))
    place[:, 0], place[:, 2] = starts[:, 0], starts[:, 1]
    place[:, 1] = ALONGSIDE_M * np.arange(count)
    speed[:, 0], speed[:, 2], speed[:, 1], turning[:, 1] = (
        *starts[:, 2:].T,
        -np.asarray(spin),
    )
    depth = (
        float(place[:, 2].min()) - 100.0
    )  # a plate that nothing reaches: worlds without walls are compiled apart
    plate = Rectangle("plate", made.wall, (-1.0, -1.0, depth), (2.0, 0, 0), (0, 2.0, 0))
    world = made.world(
        Placed((seed,), made.grain, place, velocities=speed, spins=turning), [plate]
    )
    frames = Frames(count, 1 / EVERY_S)
    run(
        world,
        init(world, np.random.default_rng(0)),
        longest_s + 2 * EVERY_S,
        [Every(EVERY_S, frames)],
    )
    columns = frames.columns()
    kept = [0, 2]
    return Flown(
        columns["t_s"],
        columns["positions_m"][:, :, kept],
        columns["velocities_m_s"][:, :, kept],
    )


@dataclass(frozen=True, eq=False)
class Struck:
    """Speeds (n, copies, 2) in x and z right after each of n impacts, once for each way
    in which the seed may lie."""

    after: np.ndarray


def strike(
    description: dict,
    laws: dict[str, dict],
    parameters: Parameters,
    before: np.ndarray,
    lying: np.ndarray,
    rng: np.random.Generator,
    *,
    tilt_deg: float = 0.0,
    copies: int = 8,
) -> Struck:
    """n impacts with speeds before (n, 3): v_x, v_z [m/s], ω [rad/s] anticlockwise in
    the picture, on a plate that falls by tilt_deg towards +x. lying (n,): whether the
    seed lands flat, as it was let go, or any way. The same generator gives the same
    ways of lying, so that two twins differ by their laws alone."""
    made, seed = bench_of(NAME, description, laws, parameters)
    count, slope = len(before) * copies, np.radians(tilt_deg)
    turns = np.array(
        [_flat(rng) if flat else any_turn(rng) for flat in np.repeat(lying, copies)]
    )
    v = np.repeat(before, copies, axis=0)
    speed = np.column_stack([v[:, 0], np.zeros(count), v[:, 1] + G_M_S2 * ABOVE_S])
    turning = np.column_stack(
        [np.zeros(count), -np.nan_to_num(v[:, 2]), np.zeros(count)]
    )
    normal = (np.sin(slope), 0.0, np.cos(slope))
    clear = np.array([reach(seed, q, tuple(-c for c in normal)) for q in turns])
    place = np.column_stack(
        [
            np.zeros(count),
            APART_M * np.arange(count),
            clear / normal[2] - speed[:, 2] * ABOVE_S,
        ]
    )
    half = APART_M * count
    along = (2 * np.cos(slope), 0.0, -2 * np.sin(slope))
    plate = Rectangle(
        "plate",
        made.wall,
        (-np.cos(slope), -half, np.sin(slope)),
        along,
        (0.0, 3 * half, 0.0),
    )
    world = made.world(
        Placed(
            (seed,),
            made.grain,
            place,
            orientations=turns,
            velocities=speed,
            spins=turning,
        ),
        [plate],
    )
    frames = Frames(count, 1 / STRIKE_S)
    run(
        world,
        init(world, np.random.default_rng(0)),
        ABOVE_S + STRIKE_S,
        [Every(STRIKE_S, frames)],
    )
    last = frames.columns()["velocities_m_s"][-1]
    last = last + np.array([0.0, 0.0, G_M_S2 * (STRIKE_S - ABOVE_S)])
    return Struck(last[:, [0, 2]].reshape(len(before), copies, 2))


def _flat(rng: np.random.Generator) -> np.ndarray:
    """As a seed hangs in tweezers: long axis level, tipped by 6° or so."""
    heading, own = rng.uniform(0, 2 * np.pi, 2)
    tip = np.radians(6.0) * rng.normal()
    return product(
        about((0, 0, 1), heading), product(about((0, 1, 0), tip), about((1, 0, 0), own))
    )


def motion_of(
    description: dict,
    time: np.ndarray,
    places: np.ndarray,
    angle: np.ndarray,
    plate_z: float,
) -> Motion:
    """A seed as it is at `time` (n,), its centre at `places` (n, 2) [m], turned by
    `angle` (n,) [rad] anticlockwise in the picture, above a level plate whose surface
    is at plate_z [m]."""
    from benchtwin.sim.rigs.parts import slab

    _, seed = bench_of(NAME, description, {}, Parameters())
    n = len(time)
    position = np.zeros((n, 1, 3))
    position[:, 0, 0], position[:, 0, 2] = places[:, 0], places[:, 1]
    turn = np.array([about((0, -1, 0), a) for a in angle])[:, None]
    middle = float(places[:, 0].mean())
    plate = slab(
        "plate", (middle - 0.15, -0.1, plate_z - 5e-3), (middle + 0.15, 0.1, plate_z)
    )
    nothing = np.zeros((n, 1, 3))
    return Motion(
        time, (seed,), np.zeros(1, int), position, turn, nothing, nothing, (plate,)
    )
