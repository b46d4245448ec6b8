"""A clump as other DEM codes read it: mass, centre of mass and inertia are those of the
true shape, not of the balls.

Formats read: LAMMPS manual, `molecule`; LIGGGHTS-PUBLIC manual, `fix
particletemplate/multisphere`; YADE class reference, `BodyContainer.appendClumped`;
EDEM's table of spheres, which takes pasted rows."""

from benchtwin.sim.seed import Seed


def files(seed: Seed, source: str) -> dict[str, str]:
    """File name → text. Balls stand about the centre of mass along the principal axes
    [m]; source: what the shape came from."""
    return {
        "clump.csv": _csv(seed),
        "lammps.molecule": _lammps(seed, source),
        "liggghts.multisphere": _rows(seed, " "),
        "liggghts.template": _liggghts(seed, source),
        "yade_clump.py": _yade(seed, source),
        "edem.spheres.tsv": _edem(seed),
    }


def _rows(seed: Seed, between: str, unit: float = 1.0) -> str:
    """x y z r of each ball, a line each."""
    balls = zip(seed.centres_m, seed.radii_m)
    return "".join(
        between.join(f"{unit * v:.9g}" for v in (*centre, radius)) + "\n"
        for centre, radius in balls
    )


def _csv(seed: Seed) -> str:
    return "x_mm,y_mm,z_mm,radius_mm\n" + _rows(seed, ",", 1e3)


def _lammps(seed: Seed, source: str) -> str:
    volume = float((seed.radii_m**3).sum())
    rows = {
        "Coords": [" ".join(f"{v:.9g}" for v in centre) for centre in seed.centres_m],
        "Types": ["1"] * len(seed.radii_m),
        "Diameters": [f"{2 * radius:.9g}" for radius in seed.radii_m],
        "Masses": [
            f"{seed.mass_kg * radius**3 / volume:.9g}" for radius in seed.radii_m
        ],
    }
    lines = [
        (
            f"# {len(seed.radii_m)} balls for {source}; units si; mass and inertia of"
            " the true shape"
        ),
        "# molecule seed lammps.molecule; neigh_modify exclude molecule/intra all",
        (
            "# fix ID all rigid/small molecule mol seed reinit no; fix deposit or pour"
            " ... mol seed rigid ID"
        ),
        "",
        f"{len(seed.radii_m)} atoms",
        f"{seed.mass_kg:.9g} mass",
        "0 0 0 com",
        " ".join(f"{v:.9g}" for v in seed.inertia_kg_m2) + " 0 0 0 inertia",
    ]
    for title, values in rows.items():
        lines += ["", title, "", *(f"{k} {value}" for k, value in enumerate(values, 1))]
    return "\n".join(lines) + "\n"


def _liggghts(seed: Seed, source: str) -> str:
    inertia = " ".join(f"{v:.9g}" for v in seed.inertia_kg_m2)
    return (
        f"# {len(seed.radii_m)} balls for {source}; needs units si and `fix ms all"
        " multisphere`\n# LIGGGHTS counts mass and inertia on the balls' union; the"
        f" true shape has {seed.mass_kg:.9g} kg and {inertia} kg m2:\n# density below"
        " gives the true mass where the union's volume is the shape's\nfix seed all"
        " particletemplate/multisphere 32452843 atom_type 1 density constant"
        f" {seed.density_kg_m3:.9g} nspheres {len(seed.radii_m)} ntry 1000000 spheres"
        " file liggghts.multisphere scale 1.0 type 1\n"
    )


def _yade(seed: Seed, source: str) -> str:
    balls = "".join(
        f"    ({', '.join(row.split())}),\n" for row in _rows(seed, " ").splitlines()
    )
    inertia = ", ".join(f"{v:.9g}" for v in seed.inertia_kg_m2)
    return f'''# {len(seed.radii_m)} balls for {source}: \
x, y, z, r [m] about the centre of mass, along the principal axes
BALLS = (
{balls})
MASS, INERTIA = {seed.mass_kg:.9g}, ({inertia})  # kg, kg m2, of the true shape


def add_seed(material, position=(0.0, 0.0, 0.0), orientation=Quaternion.Identity):
    """Append a seed; returns (clump's id, balls' ids)."""
    at = Vector3(position)
    parts = [utils.sphere(at + orientation * Vector3(x, y, z), r, material=material) \
for x, y, z, r in BALLS]
    clump, balls = O.bodies.appendClumped(parts)
    state = O.bodies[clump].state
    state.mass, state.inertia = MASS, Vector3(INERTIA)
    state.pos, state.ori = at, orientation
    return clump, balls
'''


def _edem(seed: Seed) -> str:
    rows = ["Radius\tPosition X\tPosition Y\tPosition Z\n"]
    rows += [
        f"{r:.9g}\t{x:.9g}\t{y:.9g}\t{z:.9g}\n"
        for (x, y, z), r in zip(seed.centres_m, seed.radii_m)
    ]
    return "".join(rows)
