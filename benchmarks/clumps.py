"""Clumps of n balls for four seed shapes: surface error and time by method, and whether
they bounce as the shape does.

python benchmarks/clumps.py [--most 20] [--orientations 200]

The bounce is a frictionless impact on a plate with restitution e at the contact: the
centre of mass leaves with (1 + e)/(1 + κ) − 1 of its speed, κ = m (r × n)·I⁻¹(r × n), r
from the centre of mass to the lowest point, in the same random orientations for shape
and clump; mass and inertia are the shape's in both."""

import argparse
import os
import time

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np
import pandas as pd
import seed_forms
from scipy.spatial.transform import Rotation

from benchtwin.sim.seed.clump import fit_clump
from benchtwin.sim.seed.shape import Shape

SHAPES = {
    "ellipsoid 8.72 x 6.84 x 5.98": seed_forms.ellipsoid(8.72e-3, 6.84e-3, 5.98e-3),
    "bean with a flat": seed_forms.flattened_ellipsoid(12e-3, 8e-3, 7e-3, 0.75),
    "maize wedge": seed_forms.superquadric(
        11e-3, 7.5e-3, 5e-3, across=0.85, along=0.85, taper=0.3
    ),
    "wheat grain with crease": seed_forms.creased_ellipsoid(
        6.5e-3, 3.3e-3, 3.0e-3, depth=0.2, half_width_deg=20.0
    ),
}
COUNTS = (1, 3, 5, 8, 12, 16, 20)
RESTITUTION = 0.6


def surfaces(most: int) -> pd.DataFrame:
    """A row a shape and number of balls: errors in percent of the mean radius,
    seconds."""
    rows = []
    for name, shape in SHAPES.items():
        for n in (n for n in COUNTS if n <= most):
            start = time.process_time()
            try:
                error = fit_clump(shape, n)[2]
            except ValueError:
                continue  # the balls do not make one piece
            took = time.process_time() - start
            rows.append(
                {
                    "shape": name,
                    "balls": n,
                    "rms": 100 * error.surface_rms,
                    "max": 100 * error.surface_max,
                    "volume": 100 * error.volume,
                    "s": took,
                }
            )
    return pd.DataFrame(rows)


def rebounds(own: Shape, lowest: np.ndarray) -> np.ndarray:
    """Share of its speed with which the centre of mass leaves; lowest (k, 3, 2): lever
    arms and upward normals, principal frame."""
    arms, up = lowest[..., 0], lowest[..., 1]
    turning = np.cross(arms, up)
    inverse = np.linalg.inv(own.solid.inertia(1.0))
    kappa = own.volume_m3 * np.einsum("ki,ij,kj->k", turning, inverse, turning)
    return (1 + RESTITUTION) / (1 + kappa) - 1


def bounces(orientations: int, balls: int) -> pd.DataFrame:
    """A row a shape: mean and scatter of the rebound of the shape and of its clump, and
    their difference with its error."""
    up = Rotation.random(orientations, rng=np.random.default_rng(1)).apply(
        [0.0, 0.0, 1.0]
    )
    rows = []
    for name, shape in SHAPES.items():
        own = shape.principal()[0]
        centres, radii, _ = fit_clump(own, balls)
        at = own.vertices_m[np.argmin(own.vertices_m @ up.T, axis=0)]
        ball = np.argmin(centres @ up.T - radii[:, None], axis=0)
        true, found = (
            rebounds(own, np.stack([p, up], axis=-1))
            for p in (at, centres[ball] - radii[ball, None] * up)
        )
        error = np.hypot(true.std(ddof=1), found.std(ddof=1)) / orientations**0.5
        spread = np.sqrt(true.var(ddof=1) + found.var(ddof=1)) / np.sqrt(
            2 * orientations
        )
        rows.append(
            {
                "shape": name,
                "balls": len(radii),
                "mean": true.mean(),
                "clump": found.mean(),
                "difference_sds": (found.mean() - true.mean()) / error,
                "sd": true.std(ddof=1),
                "clump_sd": found.std(ddof=1),
                "sd_difference_sds": (found.std(ddof=1) - true.std(ddof=1)) / spread,
            }
        )
    return pd.DataFrame(rows)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--most", type=int, default=20)
    parser.add_argument("--orientations", type=int, default=200)
    arguments = parser.parse_args()
    table = surfaces(arguments.most)
    for quantity in ("rms", "max", "s"):
        print(f"\n{quantity}{' (% of the mean radius)' if quantity != 's' else ''}")
        print(
            table.pivot(index="shape", columns="balls", values=quantity)
            .round(2)
            .to_string()
        )
    for balls in (1, 5, 8, 20):
        print(
            f"\n{arguments.orientations} bounces, restitution {RESTITUTION}, {balls}"
            " balls"
        )
        print(bounces(arguments.orientations, balls).round(3).to_string(index=False))


if __name__ == "__main__":
    main()
