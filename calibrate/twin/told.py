"""What a result states of the materials and the seed, as the twin takes them."""

from pathlib import Path

from calibrate.twin.parameters import SOFT_PA, Parameters, bench
from sim.material import Q235
from vision.evidence.keys import validate


def materials_and_shape(description: dict, parameters: Parameters) -> tuple[dict, dict]:
    """`materials` and `seed_shape` of result.json, for a recording's sections. ValueError for sections that do not fit."""
    known = validate({k: v for k, v in description.items() if k in ("seed", "air")}, Path("bench.toml"))
    of = bench(parameters, "pile", known.seed, known.air)
    seed, whole = of.mean_seed(), of.mean_dimensions_m
    spheres = [[1e3 * float(v) for v in (*centre, radius)] for centre, radius in zip(seed.centres_m, seed.radii_m)]
    materials = {"seed": _material(of.seed), "wall": _material(Q235)}
    materials["seed"]["shear_modulus_pa_simulated"] = {rig: parameters.shear_modulus_pa or soft for rig, soft in SOFT_PA.items()}
    sizes = dict(zip(("length_mm", "width_mm", "thickness_mm"), (float(f"{1e3 * v:.9g}") for v in whole)))
    return materials, {**sizes, "spheres": spheres}


def _material(material) -> dict:
    keys = ("name", "density_kg_m3", "shear_modulus_pa", "poisson_ratio", "source")
    return {key: getattr(material, key) for key in keys}
