"""The sections of result.json on materials and the seed's balls: written from a
calibration, weighed again for an export."""

from pathlib import Path

import numpy as np

from benchtwin.bench.rigs import RIGS
from benchtwin.sim.material import Q235
from benchtwin.sim.seed import Seed
from benchtwin.twin.parameters import Parameters, bench
from benchtwin.vision.evidence.read_keys import validate


def materials_and_shape(description: dict, parameters: Parameters) -> tuple[dict, dict]:
    """`materials` and `seed_shape` of result.json, for a recording's sections.
    ValueError for sections that do not fit."""
    content = {k: v for k, v in description.items() if k in ("seed", "air")}
    known = validate(content, Path("bench.toml"))
    simulated = (name for name, rig in RIGS.items() if rig.setup)
    of = bench(parameters, next(simulated), known.seed, known.air)
    seed, whole = of.mean_seed(), of.mean_dimensions_m
    spheres = [
        [1e3 * float(v) for v in (*centre, radius)]
        for centre, radius in zip(seed.centres_m, seed.radii_m)
    ]
    materials = {"seed": _material(of.seed), "wall": _material(Q235)}
    materials["seed"]["shear_modulus_pa_simulated"] = {
        name: parameters.for_rig(name).shear_modulus_pa
        for name, rig in RIGS.items()
        if rig.setup
    }
    sides = ("length_mm", "width_mm", "thickness_mm")
    sizes = dict(zip(sides, (float(f"{1e3 * v:.9g}") for v in whole)))
    return materials, {**sizes, "spheres": spheres}


def _material(material) -> dict:
    keys = ("name", "density_kg_m3", "shear_modulus_pa", "poisson_ratio", "source")
    return {key: getattr(material, key) for key in keys}


def weighed(
    spheres_m: list[list[float]], density_kg_m3: float
) -> tuple[list[list[float]], float, list[float]]:
    """Balls [x, y, z, r] [m] about their centre of mass along the principal axes, mass
    [kg], principal moments [kg m2].

    Mass and moments are those of the balls' union (`sim.seed.Seed.from_spheres`);
    ValueError says what is wrong with the balls."""
    balls_m = np.array(spheres_m, dtype=float)
    seed = Seed.from_spheres(balls_m[:, :3], balls_m[:, 3], density_kg_m3)
    balls = [
        [*map(float, centre), float(radius)]
        for centre, radius in zip(seed.centres_m, seed.radii_m)
    ]
    return balls, float(seed.mass_kg), [float(moment) for moment in seed.inertia_kg_m2]
