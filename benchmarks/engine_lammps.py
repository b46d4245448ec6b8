"""LAMMPS beside the engine: the same bed, the same contact law, as many steps, timed.

Beds settle from a loose grid, which takes minutes the first time (kept in the user's
cache folder):

    # settled, from wherever
    bed = Bed(centres_m, radii_m, seed, mass_kg, box_m, velocity_m_s)
    law = ContactLaw(
        young_pa=…, poisson=…, restitution=…, friction=…, rolling=…, step_s=…
    )
    timing = run(bed, law, steps=500, ranks=1)
    timing.particle_steps_per_s, timing.contacts_per_ball

Contacts are counted here from positions (`contacts_per_ball`), by one rule for both
programs.

What is the same: Hertz–Mindlin with the tangential history and Coulomb's cap, damping
from the restitution, elastic–plastic rolling (LAMMPS's `sds`, our type C), five walls
of the seeds' own material, gravity, step, bed, mass of each seed. What is not: LAMMPS
scales tangential damping with the normal one; it takes a seed's inertia from its balls
one by one (their densities are set so that the masses add up to the seed's); `sds` acts
with R* (so the factor 2 between balls) and a constant spring. There is no
`granular/omp`: two cores are two ranks, side by side along x."""

import os
import re
import subprocess
import tempfile
from dataclasses import dataclass, replace
from hashlib import sha256
from pathlib import Path

import numpy as np
from scipy.spatial import cKDTree

from benchtwin.sim.lammps.program import needed

Array = np.ndarray
GRAVITY = 9.81  # [m/s2], along -z


@dataclass(frozen=True, eq=False)
class Bed:
    """Balls in an open box with walls at 0 and box_m (2,) in x and y and a floor at z =
    0.

    centres_m (n, 3), radii_m (n,), seed (n,) number of the seed that each ball belongs
    to, mass_kg (seeds,), box_m (2,) [m], velocity_m_s (n, 3) of the balls' centres."""

    centres_m: Array
    radii_m: Array
    seed: Array
    mass_kg: Array
    box_m: Array
    velocity_m_s: Array

    @property
    def clumps(self) -> bool:
        return len(self.mass_kg) < len(self.radii_m)


@dataclass(frozen=True)
class ContactLaw:
    """One material for seeds and walls: E [Pa], ν, e, μ, μ_r in the R_i convention
    (EDEM's) [-], and the step [s]."""

    young_pa: float
    poisson: float
    restitution: float
    friction: float
    rolling: float
    step_s: float


@dataclass(frozen=True, eq=False)
class Timing:
    """Ball-steps a second of the timed loop, contacts a ball after it, and the bed it
    left."""

    particle_steps_per_s: float
    contacts_per_ball: float
    bed: Bed


def contacts_per_ball(bed: Bed) -> float:
    """Contacts a ball: overlapping pairs of balls of different seeds (each counted for
    both) and balls on walls, over n."""
    tree = cKDTree(bed.centres_m)
    pairs = tree.query_pairs(2.0 * bed.radii_m.max(), output_type="ndarray")
    i, j = pairs[bed.seed[pairs[:, 0]] != bed.seed[pairs[:, 1]]].T
    gap = (
        np.linalg.norm(bed.centres_m[i] - bed.centres_m[j], axis=1)
        - bed.radii_m[i]
        - bed.radii_m[j]
    )
    x, y, z = bed.centres_m.T
    walls = sum(
        np.count_nonzero(d < bed.radii_m)
        for d in (x, bed.box_m[0] - x, y, bed.box_m[1] - y, z)
    )
    return float((2 * np.count_nonzero(gap < 0.0) + walls) / len(bed.radii_m))


def run(
    bed: Bed,
    law: ContactLaw,
    steps: int,
    *,
    ranks: int = 1,
    warm_up: int = 200,
    skin: float = 0.2,
    damp: float | None = None,
) -> Timing:
    """Run `warm_up` untimed steps, then `steps` timed ones, on 1 or 2 ranks (side by
    side along x).

    skin: neighbour lists reach so many mean radii farther than contact. damp: viscous
    drag [1/s] on every seed, to settle. Raises RuntimeError where LAMMPS is missing
    (with what to install) or stops (with its last lines)."""
    found = needed(ranks)
    with tempfile.TemporaryDirectory() as folder:
        here = Path(folder)
        (here / "bed.data").write_text(data_file(bed))
        (here / "in.bed").write_text(
            input_file(bed, law, steps, ranks, warm_up, skin, damp)
        )
        command = found.command(
            ranks, ["-in", "in.bed", "-log", "log.lammps", "-screen", "none"]
        )
        done = subprocess.run(
            command, cwd=here, env=found.environment, capture_output=True, text=True
        )
        log = (
            (here / "log.lammps").read_text() if (here / "log.lammps").exists() else ""
        )
        loops = re.findall(r"Loop time of (\S+) on \d+ procs for (\d+) steps", log)
        if done.returncode or len(loops) < 2 or not (here / "end.txt").exists():
            raise RuntimeError(
                "LAMMPS stopped: "
                + " / ".join(
                    (log + done.stdout + done.stderr).strip().splitlines()[-6:]
                )
            )
        end = np.loadtxt(here / "end.txt", skiprows=9, ndmin=2)
    end = end[np.argsort(end[:, 0])]
    left = replace(bed, centres_m=end[:, 1:4], velocity_m_s=end[:, 4:7])
    return Timing(
        len(bed.radii_m) * steps / float(loops[-1][0]), contacts_per_ball(left), left
    )


def data_file(bed: Bed) -> str:
    """The bed as LAMMPS reads it; each ball's density such that the balls' masses add
    up to their seed's."""
    volume = np.bincount(bed.seed, 4.0 / 3.0 * np.pi * bed.radii_m**3)
    density = (bed.mass_kg / volume)[bed.seed]
    n, margin = len(bed.radii_m), 2.0 * bed.radii_m.max()
    top = bed.centres_m[:, 2].max() + 10.0 * margin
    kind = "hybrid" if bed.clumps else "sphere"
    lines = [
        f"# {n} balls in {len(bed.mass_kg)} seeds\n",
        f"{n} atoms\n1 atom types\n",
        (
            f"0 {bed.box_m[0]:.12g} xlo xhi\n0 {bed.box_m[1]:.12g} ylo"
            f" yhi\n{-margin:.12g} {top:.12g} zlo zhi\n"
        ),
        f"Atoms # {kind}\n",
    ]
    for k, ((x, y, z), r, rho, seed) in enumerate(
        zip(bed.centres_m, bed.radii_m, density, bed.seed), 1
    ):
        place = f"{x:.12g} {y:.12g} {z:.12g}"
        shape = f"{2 * r:.12g} {rho:.12g}"
        lines.append(
            f"{k} 1 {place} {shape} {seed + 1}"
            if bed.clumps
            else f"{k} 1 {shape} {place}"
        )
    lines.append("\nVelocities\n")
    lines += [
        f"{k} {u:.12g} {v:.12g} {w:.12g} 0 0 0"
        for k, (u, v, w) in enumerate(bed.velocity_m_s, 1)
    ]
    return "\n".join(lines) + "\n"


def input_file(
    bed: Bed,
    law: ContactLaw,
    steps: int,
    ranks: int,
    warm_up: int,
    skin: float,
    damp: float | None,
) -> str:
    """LAMMPS's commands: warm up, run, dump positions and velocities."""
    radius = bed.radii_m.mean()
    # sds rolls with R*: between equal balls twice the coefficient makes the same torque
    # as with R_i, at a wall the same one.
    contact, at_wall = (contact_text(bed, law, k * law.rolling) for k in (2.0, 1.0))
    walls = [("x", 0.0, bed.box_m[0]), ("y", 0.0, bed.box_m[1]), ("z", 0.0, None)]
    lines = [
        "units si",
        "atom_style hybrid sphere molecular" if bed.clumps else "atom_style sphere",
        "dimension 3\nboundary f f fm\nnewton off\ncomm_modify vel yes",
        f"processors {ranks} 1 1",
        "read_data bed.data",
        "neigh_modify every 1 delay 0 check yes"
        + (" exclude molecule/intra all" if bed.clumps else ""),
        f"neighbor {skin * radius:.8g} bin",
        "pair_style granular",
        f"pair_coeff * * {contact}",
        f"timestep {law.step_s:.8g}",
        (
            "fix move all rigid/small molecule"
            if bed.clumps
            else "fix move all nve/sphere"
        ),
        f"fix weight all gravity {GRAVITY} vector 0 0 -1",
    ]
    for axis, low, high in walls:
        ends = f"{low:.12g} {'NULL' if high is None else format(high, '.12g')}"
        lines.append(
            f"fix wall{axis} all wall/gran granular {at_wall} {axis}plane {ends}"
        )
    if damp is not None:
        lines.append(
            f"fix drag all viscous {damp * bed.mass_kg.sum() / len(bed.radii_m):.8g}"
        )
    # `thermo` at the ends only: its sums are no part of the loop.
    lines += [
        (
            f"thermo_style custom step\nthermo {max(steps, warm_up, 1)}\nthermo_modify"
            " lost error"
        ),
        f"run {warm_up}",
        f"run {steps}",
        (
            "write_dump all custom end.txt id x y z vx vy vz modify sort id format"
            ' float "%.12g"'
        ),
    ]
    return "\n".join(lines) + "\n"


def contact_text(bed: Bed, law: ContactLaw, rolling: float) -> str:
    """The contact as LAMMPS's `granular` styles take it, with this coefficient of
    rolling friction (R* convention)."""
    radius, mass = bed.radii_m.mean(), bed.mass_kg.mean()
    # sds wants one spring constant: type C's 2.25 k_n μ_r² at the overlap of a ball
    # under ten others' weight.
    modulus = law.young_pa / (2.0 * (1.0 - law.poisson**2))
    overlap = (
        10.0 * mass * GRAVITY * 3.0 / (4.0 * modulus * np.sqrt(radius / 2.0))
    ) ** (2.0 / 3.0)
    spring = 2.25 * 2.0 * modulus * np.sqrt(radius / 2.0 * overlap) * rolling**2
    dashpot = 0.3 * 2.0 * np.sqrt(0.4 * mass * spring)
    return (
        f"hertz/material {law.young_pa:.8g} {law.restitution:.8g} {law.poisson:.8g}"
        f" tangential mindlin NULL 1.0 {law.friction:.8g} rolling sds {spring:.8g}"
        f" {dashpot:.8g} {rolling:.8g} damping coeff_restitution"
    )


SOFT_SOYBEAN = ContactLaw(
    young_pa=1.0e7,
    poisson=0.4,
    restitution=0.65,
    friction=0.55,
    rolling=0.04,
    step_s=2.0e-5,
)


def loose_spheres(
    rng: np.random.Generator,
    count: int,
    radius_m: float = 3.5e-3,
    density_kg_m3: float = 1250.0,
) -> Bed:
    """`count` equal-mean balls (±10 % in size) on a loose grid in a box about as wide
    as the bed is high, shaken a little."""
    side = max(round(count ** (1 / 3)), 1)
    radii = radius_m * rng.uniform(0.9, 1.1, count)
    pitch = 2.25 * radius_m
    k = np.arange(count)
    grid = np.c_[k % side, k // side % side, k // side**2]
    centres = (grid + 0.5) * pitch + rng.uniform(-0.02, 0.02, (count, 3)) * radius_m
    mass = density_kg_m3 * 4.0 / 3.0 * np.pi * radii**3
    return Bed(
        centres, radii, k, mass, np.array([side * pitch] * 2), np.zeros((count, 3))
    )


def loose_clumps(rng: np.random.Generator, count: int) -> Bed:
    """`count` mean soybeans of five balls, turned at random, on a loose grid."""
    from scipy.spatial.transform import Rotation

    from benchtwin.sim.seed import Seed

    seed = Seed.from_dimensions(8.72e-3, 6.84e-3, 5.98e-3)
    balls, side, pitch = (
        len(seed.radii_m),
        max(round(count ** (1 / 3)), 1),
        2.05 * seed.bounding_radius_m,
    )
    k = np.arange(count)
    middle = (np.c_[k % side, k // side % side, k // side**2] + 0.5) * pitch
    turned = np.einsum(
        "kij,bj->kbi",
        Rotation.random(count, random_state=rng).as_matrix(),
        seed.centres_m,
    )
    centres = (middle[:, None] + turned).reshape(-1, 3)
    whose = np.repeat(k, balls)
    masses = np.full(count, seed.mass_kg)
    return Bed(
        centres,
        np.tile(seed.radii_m, count),
        whose,
        masses,
        np.array([side * pitch] * 2),
        np.zeros_like(centres),
    )


def settled(
    name: str, loose: Bed, law: ContactLaw, *, ranks: int = 2, fall_s: float = 0.3
) -> Bed:
    """The bed at rest, from LAMMPS itself (`fall_s` seconds, the last third in
    treacle), kept in the user's cache folder."""
    folder = (
        Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache")
        / "benchtwin"
        / "beds"
    )
    what = sha256(
        loose.centres_m.tobytes() + loose.radii_m.tobytes() + repr(law).encode()
    ).hexdigest()[:12]
    kept = folder / f"{name}-{len(loose.mass_kg)}-{what}.npz"
    if kept.exists():
        stored = np.load(kept)
        return replace(
            loose, centres_m=stored["centres_m"], velocity_m_s=stored["velocity_m_s"]
        )
    steps = int(fall_s / law.step_s)
    fallen = run(
        loose, law, 2 * steps // 3, ranks=ranks, warm_up=1, skin=0.5, damp=3.0
    ).bed
    still = run(
        fallen, law, steps // 3, ranks=ranks, warm_up=1, skin=0.3, damp=60.0
    ).bed
    folder.mkdir(parents=True, exist_ok=True)
    np.savez(kept, centres_m=still.centres_m, velocity_m_s=still.velocity_m_s)
    return still
