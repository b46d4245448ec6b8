"""Our contact laws against the prescribed motions and analytic forces of ON-DEM's
working group 4.

    git clone https://github.com/ON-DEM/ON-DEM-WG4-testingInteractions FOLDER
    python benchmarks/others/contact_laws.py FOLDER

Motions, laws and results are FOLDER's own: its functions are imported from there, the
numbers of its tests read from its `F_run_test.py`. Two balls of 1 m follow a motion
step by step in our engine, which keeps their contact; printed is the worst difference
of a force (and of a torque) over the largest, test by test. Where the two have other
conventions, theirs is converted, the line says by what, and CONVENTIONS why; a pair
that turns about its normal is shown with and without. Ends with 1 where a difference
is left that is above 1e-6."""

import argparse
import ast
import importlib
import json
import sys
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType

import numpy as np
from scipy.spatial.transform import Rotation

from benchtwin.sim.engine.step import init, run
from benchtwin.sim.engine.world import Placed, World
from benchtwin.sim.laws import LAWS, Chosen, hertz_mindlin
from benchtwin.sim.material import Contact, Material
from benchtwin.sim.seed import Seed

MOST = 1e-6
SOLID = Material("ball", 2500.0, 4e6, 0.3)
# so that motion 1 sticks and motion 2 slides
MU, RESTITUTION = 2.0, 0.6
# of the published results: k_t and mu of test 1, k_n of Yade's
SHEAR_N_M, SHEAR_MU, LINEAR_N_M = 0.5e7, 0.5, 100.0
CONVENTIONS = """Conventions
 sign        their F_i points from i to j, as a pull: what i does to j
 arm         they slide by the rolling speed alone; ours is the slip at the contact, of
             both balls over their arms R - overlap/2
 begin       their published shear has the next step's increment in it already
 turning     a spring turns with the whole pair in theirs; ours is laid across the new
             normal, and a turn about the normal itself leaves it where it is
 memory      their cap forgets: force by the whole displacement, cut off at mu F_n. Ours
             holds in the spring what it still carries, so that a slide turned round
             unloads at once; compared as far as neither has slid and turned
 damping     their eta of k and beta is ours with k = S (2 E* sqrt(R* overlap)); their
             beta of restitution lacks Tsuji's factor sqrt(5/6) for Hertz's spring"""


@dataclass(frozen=True)
class Line:
    """One comparison: force (and torque) by ours and theirs, (n, 3) each."""

    test: str
    law: str
    ours: np.ndarray
    theirs: np.ndarray
    converted: str = ""

    @property
    def worst(self) -> float:
        """Largest difference over the largest of theirs."""
        apart = np.linalg.norm(self.ours - self.theirs, axis=1)
        return float(apart.max() / np.linalg.norm(self.theirs, axis=1).max())


def imported(folder: Path) -> tuple[ModuleType, ModuleType]:
    """Their motions and their laws."""
    sys.path.insert(0, str(folder / "functions"))
    sys.dont_write_bytecode = True
    names = ("A_motion_functions", "C_contact_laws")
    motions, laws = (importlib.import_module(name) for name in names)
    return motions, laws


def prescribed(folder: Path, motions: ModuleType) -> dict[int, dict]:
    """{test: motion} of every call of `my_simulate_motion` in `F_run_test.py`."""
    tree = ast.parse((folder / "functions" / "F_run_test.py").read_text())
    known = {"np": np, "R": 1.0, "R_i": 1.0, "R_j": 1.0}
    known["my_simulate_motion"] = motions.my_simulate_motion
    found = {}
    for branch in (n for n in ast.walk(tree) if isinstance(n, ast.If)):
        call = branch.body[0]
        if isinstance(call, ast.Assign) and isinstance(branch.test, ast.Compare):
            number = ast.literal_eval(branch.test.comparators[0])
            code = compile(ast.Expression(call.value), "F_run_test.py", "eval")
            found[number] = {k: np.array(v) for k, v in eval(code, known).items()}
    return found


def pressed(motions: ModuleType) -> dict:
    """Their motion again, with balls that come nearer, part and meet anew."""
    still, none = [0.0] * 3, [0] * 5
    motion = motions.my_simulate_motion(
        *([still] * 3),
        *([[1.0, 0, 0, 0]] * 2),
        *(0, 0.04, 1.0, 0.5, 0, [0, 0, 1.98]),
        *none,
        *none,
        *none,
        *([1.0, 0, 0], [0, 1.0, 0]),
        *(6 * np.pi, 6 * np.pi / 2000),
        *(1.0, 1.0),
    )
    return {k: np.array(v) for k, v in motion.items()}


def followed(
    motion: dict, mu: float = MU, laws: tuple[Chosen, ...] = (), solid: Material = SOLID
) -> tuple[np.ndarray, np.ndarray]:
    """Force and torque (n, 3) on ball i in our engine, without damping."""
    ball = Seed.from_spheres(np.zeros((1, 3)), np.ones(1), solid.density_kg_m3)
    places = np.stack([motion["x_i"], motion["x_j"]], axis=1)
    speeds = np.stack([motion["v_i"], motion["v_j"]], axis=1)
    spins = np.stack([motion["omega_i"], motion["omega_j"]], axis=1)
    dt = float(motion["dt"][0])
    world = World(
        (Placed((ball,), solid, places[0], shape_of=np.zeros(2, int)),),
        contacts=(Contact((solid.name, solid.name), 1.0, mu, 0.0),),
        laws=laws,
        gravity=(0.0, 0.0, 0.0),
        time_step_s=dt,
        most_overlap=1.0,
    )
    state = init(world, np.random.default_rng(0), allowed_overlap=1.0)
    inertia, loads = 0.4 * ball.mass_kg, []
    for x, v, w in zip(places, speeds, spins):
        # so that the step ends there, with these speeds, whatever the forces
        of = state.ids
        state.motion[:, :9] = np.hstack([x - dt * v, v, w])[of]
        state.spin[:] = inertia * w[of]
        state.load[:] = 0.0
        state = run(world, state, steps=1)
        loads.append(state.load[np.argsort(state.ids)[0], :6].copy())
    return np.array(loads)[:, :3], np.array(loads)[:, 3:]


def slid(motion: dict, turned: bool) -> np.ndarray:
    """Slip (n, 3) at the contact, summed up; turned: with the pair, about any axis."""
    n, dt = motion["n_ij"], motion["dt"]
    arm = 1.0 - motion["u_n"] / 2
    spin = motion["omega_i"] + motion["omega_j"] - 2 * motion["omega_b"]
    slip, total, out = np.cross(spin, n) * arm, np.zeros(3), []
    for k, step in enumerate(slip):
        axis = motion["omega_b"][k]
        if not turned:  # the part across the normal alone
            axis = axis - (axis @ n[k]) * n[k]
        if k:
            total = Rotation.from_rotvec(axis * dt[k]).apply(total)
        total = total + step * dt[k]
        out.append(total)
    return np.array(out)


def hertz_and_mindlin(motion: dict, laws: ModuleType, test: str) -> list[Line]:
    """Both forces along a motion, and the torque, as far as the cap's memory does not
    count."""
    young, poisson = SOLID.young_modulus_pa, SOLID.poisson_ratio
    one = {"E": young, "nu": poisson, "R": 1.0}
    of = {f"{k}_{side}": v for k, v in one.items() for side in "ij"} | {"mu": MU}
    force, torque = followed(motion)
    seen = {**motion, "u_n": motion["u_n"].reshape(-1)}
    pull = laws.Fn_hertzian(of, seen)
    lines: list[Line] = []
    whole = slid(motion, True)
    for slip in (whole, slid(motion, False)):
        if lines and np.allclose(slip, whole):
            break
        shear = laws.Fs_full_mindlin(of, {**seen, "u_t": slip}, pull)
        last = _until_turned_round(slip, shear, pull)
        how = "sign, arm" + (", turning" if lines else "")
        if last < len(slip):
            how += f", memory: first {last} of {len(slip)} steps"
        theirs = (shear - pull)[:last]
        lines.append(Line(test, "Hertz, Mindlin", force[:last], theirs, how))
        arm = (1.0 - motion["u_n"] / 2) * motion["n_ij"]
        turning = np.cross(arm, shear)[:last]
        if np.abs(turning).max() > 0:
            lines.append(Line(test, "torque of it", torque[:last], turning, how))
    return lines


def _until_turned_round(slip: np.ndarray, shear: np.ndarray, pull: np.ndarray) -> int:
    """How many steps there are before a slip that has slid goes back."""
    way, held = (np.linalg.norm(v, axis=1) for v in (slip, pull))
    slides = np.flatnonzero(np.linalg.norm(shear, axis=1) > (1 - 1e-9) * MU * held)
    back = np.flatnonzero(np.diff(way) < -1e-12)
    later = back[back >= slides[0]] if len(slides) else back[:0]
    return int(later[0]) + 1 if len(later) else len(slip)


def published_shear(folder: Path) -> Line:
    """The published forces of test 1, by our law of shear alone: it takes any
    stiffness."""
    told = _results(folder / "output_ANA" / "theoretical_output_test_01.json")
    force, spring = [], (0.0, 0.0, 0.0)
    cap = SHEAR_MU * np.abs((told["F_i"] * told["n_ij"]).sum(axis=1))
    for n, v, dt, limit in zip(told["n_ij"], told["v_s"], told["dt"], cap):
        known = [*spring, *n, *v, dt, SHEAR_N_M, 1.0, 0.0, limit]
        *shear, a, b, c = hertz_mindlin.tangential_force(*known)
        spring = (a, b, c)
        force.append(shear)
    across = told["F_i"] - (told["F_i"] * told["n_ij"]).sum(1)[:, None] * told["n_ij"]
    return Line(
        "published 1", "linear shear", np.array(force)[1:], across[:-1], "begin"
    )


def published_approach(folder: Path) -> Line:
    """The published forces of two balls that meet: a linear spring, in the place of
    Hertz's."""
    told = _results(folder / "dem-codes" / "yade" / "theoreticalResult.json")
    linear = LAWS["spring_linear"].use(stiffness=LINEAR_N_M)
    soft = Material("ball", 2500.0, 1e3, 0.3)
    force, _ = followed(told, 0.0, (linear,), soft)
    return Line("published Yade", "linear spring", force, -told["F_i"], "sign")


def _results(file: Path) -> dict:
    return {k: np.array(v, float) for k, v in json.loads(file.read_text()).items()}


def viscous(laws: ModuleType) -> list[Line]:
    """Dashpots at some overlaps and speeds: by a damping ratio, and by restitution."""
    rng, young = np.random.default_rng(1), SOLID.young_modulus_pa
    modulus = young / 2 / (1 - SOLID.poisson_ratio**2)
    gamma = hertz_mindlin.damping_factor(RESTITUTION)
    n, mass = np.array([0.0, 0.0, 1.0]), 0.5
    rows: dict[str, list] = {"n": [], "t": []}
    of = {f"{k}_{s}": v for k, v in (("m", 1.0), ("R", 1.0)) for s in "ij"}
    of |= {f"{k}_{s}": v for k, v in (("E", young), ("nu", 0.3)) for s in "ij"}
    for overlap, speed in zip(rng.uniform(0.01, 0.1, 50), rng.uniform(-1, 1, 50)):
        s_n = hertz_mindlin.normal_stiffness(overlap, 0.5, modulus)
        damped = hertz_mindlin.damping_force(s_n, speed, mass, gamma)
        across = np.array([speed, 0.0, 0.0])
        known = [0.0, 0.0, 0.0, *n, *across, 0.0, s_n, mass, gamma, np.inf]
        shear = hertz_mindlin.tangential_force(*known)[:3]
        of |= {"k_n": s_n, "k_t": s_n, "restitution": RESTITUTION}
        of |= {"beta_n": gamma / 2, "beta_t": gamma / 2}
        seen = {"v_n": np.array([-speed]), "v_t": across[None], "n_ij": n[None]}
        both = laws.Fn_viscous_const(of, seen), laws.Fn_viscous_veldep(of, seen)
        rows["n"].append((damped * n, *(f[0] for f in both)))
        both = laws.Fs_viscous_const(of, seen), laws.Fs_viscous_veldep(of, seen)
        rows["t"].append((shear, *(f[0] for f in both)))
    lines = []
    for name, values in zip(("normal", "tangential"), rows.values()):
        ours, ratio, restitution = np.array(values).transpose(1, 0, 2)
        lines.append(Line("dashpot", f"{name}, by beta", ours, ratio, "damping"))
        tsuji = np.sqrt(5 / 6) * restitution
        lines.append(Line("dashpot", f"{name}, by e", ours, tsuji, "damping"))
    return lines


def main() -> int:
    """Print the table; 1 where anything differs."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path)
    folder = parser.parse_args().folder
    motions, laws = imported(folder)
    lines = [published_shear(folder), published_approach(folder)]
    for number, motion in sorted(prescribed(folder, motions).items()):
        lines += hertz_and_mindlin(motion, laws, f"motion {number}")
    lines += hertz_and_mindlin(pressed(motions), laws, "pressed")
    lines += viscous(laws)
    for line in lines:
        print(f"{line.test:15s} {line.law:20s} {line.worst:8.1e}  {line.converted}")
    print(CONVENTIONS)
    # of a test's lines the last has all that is converted
    last = {(line.test, line.law): line.worst for line in lines}
    return int(any(worst > MOST for worst in last.values()))


if __name__ == "__main__":
    sys.exit(main())
