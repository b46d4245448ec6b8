"""Seeds as LAMMPS's rigid bodies: a data file of their balls, a file of masses,
inertias and speeds.

Every seed has one ball at its centre of mass, by which it is followed and on which drag
acts: one of its own where there is one, else a small one of a type that touches
nothing. LAMMPS carries no body of a single ball, so a round seed has both."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from benchtwin.sim.engine.world import Placed
from benchtwin.sim.rotation import turned
from benchtwin.sim.seed import Seed

# types: a ball; a ball at the centre of mass; one there that touches nothing
TOUCHING = 1
CENTRE = 2
INNER = 3
INNER_SHARE = 0.05  # its radius, of the smallest ball's
APART = 1e-6  # of a radius: LAMMPS refuses bodies whose balls all lie in one point

# least over greatest moment of inertia: below a tenth of this LAMMPS takes the least
# for none
THINNEST = 1e-6


@dataclass(frozen=True, eq=False)
class Balls:
    """One seed's balls as LAMMPS has them: centres (n, 3) [m] in the principal frame,
    radii (n,) [m], types (n,)."""

    centres_m: np.ndarray
    radii_m: np.ndarray
    types: np.ndarray


def balls_of(shape: Seed) -> Balls:
    """The balls of a `Seed`, one at its centre of mass added where there is none;
    ValueError for one that LAMMPS cannot carry."""
    moments = np.asarray(shape.inertia_kg_m2, float)
    if not moments.min() > THINNEST * moments.max():
        shown = ", ".join(f"{v:.3g}" for v in moments)
        raise ValueError(
            f"seed: moments of inertia {shown} kg m²: LAMMPS's fix rigid/small carries"
            " no body without all three"
        )
    centres = np.asarray(shape.centres_m, float).reshape(-1, 3)
    radii = np.atleast_1d(np.asarray(shape.radii_m, float))
    off = np.linalg.norm(centres, axis=1)
    types = np.full(len(radii), TOUCHING)
    nearest = int(np.argmin(off))
    central = off[nearest] <= 1e-9 * radii[nearest]
    if central:
        types[nearest] = CENTRE
    if central and len(radii) > 1:
        return Balls(centres, radii, types)
    added = np.array([[APART * radii.min() * central, 0.0, 0.0]])
    radii_m = np.r_[radii, INNER_SHARE * radii.min()]
    return Balls(np.r_[centres, added], radii_m, np.r_[types, INNER])


def write_seeds(folder: Path, name: str, placed: Placed) -> None:
    """Write NAME.data (balls) and NAME.bodies (seeds: mass, place, inertia, speed,
    angular momentum) into the folder."""
    x = np.asarray(placed.positions, float)
    n = len(x)
    kind = np.zeros(n, int) if placed.shape_of is None else np.asarray(placed.shape_of)
    if placed.orientations is None:
        q = np.tile([1.0, 0, 0, 0], (n, 1))
    else:
        q = np.asarray(placed.orientations, float)
    v, w = (
        np.zeros((n, 3)) if given is None else np.asarray(given, float)
        for given in (placed.velocities, placed.spins)
    )
    made = [balls_of(shape) for shape in placed.shapes]
    atoms, speeds, sizes, bodies = [], [], [], []
    k = 0
    for seed in range(n):
        shape, own = placed.shapes[kind[seed]], made[kind[seed]]
        arms = turned(q[seed][None], own.centres_m)
        around = x[seed] + arms
        density = shape.mass_kg / (4.0 / 3.0 * np.pi * float((own.radii_m**3).sum()))
        moving = v[seed] + np.cross(w[seed], arms)
        diameter = (6.0 * shape.volume_m3 / np.pi) ** (1 / 3)
        for ball in range(len(own.radii_m)):
            k += 1
            place = " ".join(f"{c:.15g}" for c in around[ball])
            atoms.append(
                f"{k} {own.types[ball]} {place} {2 * own.radii_m[ball]:.15g}"
                f" {density:.9g} {seed + 1}"
            )
            speeds.append(
                f"{k} " + " ".join(f"{c:.15g}" for c in moving[ball]) + " 0 0 0"
            )
            sizes.append(f"{k} {diameter:.12g}")
        axes = turned(q[seed][None], np.eye(3)).T  # columns: the principal axes
        inertia = axes @ np.diag(shape.inertia_kg_m2) @ axes.T
        upper = [
            inertia[i, j] for i, j in ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))
        ]
        numbers = (shape.mass_kg, *x[seed], *upper, *v[seed], *(inertia @ w[seed]))
        bodies.append(
            f"{seed + 1} " + " ".join(f"{c:.15g}" for c in numbers) + " 0 0 0"
        )
    reach = max(shape.bounding_radius_m for shape in placed.shapes)
    low, high = x.min(axis=0) - 4 * reach, x.max(axis=0) + 4 * reach
    box = [
        f"{a:.9g} {b:.9g} {axis}lo {axis}hi"
        for a, b, axis in zip(low, high, "xyz", strict=True)
    ]
    head = [f"# {n} seeds, {k} balls", "", f"{k} atoms", f"{INNER} atom types", *box]
    sections = [("Atoms # hybrid", atoms), ("Velocities", speeds), ("Sizes", sizes)]
    text = "\n".join(
        head + [line for title, rows in sections for line in ("", title, "", *rows)]
    )
    (folder / f"{name}.data").write_text(text + "\n")
    (folder / f"{name}.bodies").write_text("\n".join([f"{n}", *bodies]) + "\n")
