"""What a pile tells and what packings hide: angles by several definitions, and weights,
at two sets of parameters.

python benchmarks/packings.py [PACKINGS]

30 s of CPU a pile; runs are kept in benchmark-runs/packings.

effect: the observable's difference between the two sets, in standard deviations of one
pile; correlation: between piles of the two sets that share a packing; information:
effect² for 100 s of CPU."""

import argparse
import pickle
import time
from pathlib import Path

import numpy as np
import pandas as pd

from benchtwin.sim.rigs.profile import balls, centroid_angle, slope_angle
from benchtwin.twin import Parameters
from benchtwin.twin.job import Job
from benchtwin.twin.run import run

OUT = Path("benchmark-runs/packings")
SETS = {
    "a": Parameters(
        seed_restitution=0.6, seed_static_friction=0.40, seed_rolling_friction=0.02
    ),
    "b": Parameters(
        seed_restitution=0.6, seed_static_friction=0.55, seed_rolling_friction=0.04
    ),
}
SLAB = {
    "box_mm": [105, 30, 200],
    "gate_mm": [30, 200],
    "plate_mm": [200, 30],
    "fill_height_mm": 60,
    "slab": True,
}
X, Y = np.arange(0.0, 0.2, 2e-4), np.arange(-0.03, 0.03, 5e-4)


def pile(which: str, packing: int) -> dict:
    """One pile's balls, weight and CPU seconds, from the store or computed."""
    file = OUT / f"{which}-{packing}.pickle"
    if not file.exists():
        job = Job("pile", SETS[which], {"pile": SLAB}, (7, packing), rendered=False)
        begin = time.process_time()
        motion, _ = run(
            job.recording(Path("pile")),
            job.parameters,
            rng=np.random.default_rng([7, packing]),
            threads=1,
        )
        centres, radii = balls(motion)
        found = {
            "centres": centres,
            "radii": radii,
            "truth": motion.truth,
            "cpu_s": time.process_time() - begin,
        }
        OUT.mkdir(parents=True, exist_ok=True)
        file.write_bytes(pickle.dumps(found))
    return pickle.loads(file.read_bytes())


def surface(centres: np.ndarray, radii: np.ndarray) -> np.ndarray:
    """Height (len(Y), len(X)) of the upper surface [m]."""
    height = np.zeros((len(Y), len(X)))
    for c, r in zip(centres, radii):
        i, j = np.searchsorted(X, [c[0] - r, c[0] + r])
        k, m = np.searchsorted(Y, [c[1] - r, c[1] + r])
        rest = r * r - (X[None, i:j] - c[0]) ** 2 - (Y[k:m, None] - c[1]) ** 2
        top = np.where(rest > 0, c[2] + np.sqrt(np.maximum(rest, 0.0)), 0.0)
        np.maximum(height[k:m, i:j], top, out=height[k:m, i:j])
    return height


def observables(found: dict) -> dict[str, float]:
    height = surface(found["centres"], found["radii"])
    outline, mean = height.max(axis=0), height[(height > 0).any(axis=1)].mean(axis=0)
    return {
        "line, 20–80 % of the outline [°]": slope_angle(X, outline),
        "line, 10–90 % of the outline [°]": slope_angle(X, outline, (0.1, 0.9)),
        "line, 20–80 % of the mean surface [°]": slope_angle(X, mean),
        "centroid angle of the outline [°]": centroid_angle(X, outline, 0.0),
        "centroid angle of the mean surface [°]": centroid_angle(X, mean, 0.0),
        "where the outline is 10 mm high [mm]": (
            1e3 * float(X[np.flatnonzero(outline > 0.01)[-1]])
        ),
        "mass filled in [g]": found["truth"]["filled_mass_g"],
        "cpu_s": found["cpu_s"],
    }


def main(packings: int) -> None:
    rows = [
        {"set": s, "packing": k, **observables(pile(s, k))}
        for k in range(packings)
        for s in SETS
    ]
    table = pd.DataFrame(rows).set_index(["packing", "set"]).unstack("set")
    cpu = (
        float(table.pop("cpu_s").to_numpy().mean())
        if "cpu_s" in table
        else float("nan")
    )
    print(f"{packings} packings, {cpu:.0f} s of CPU a pile")
    print(
        f"{'observable':45} {'a':>8} {'b':>8} {'sd':>7} {'effect':>7}"
        f" {'correlation':>12} {'information':>12}"
    )
    for name in dict.fromkeys(table.columns.get_level_values(0)):
        a, b = table[name]["a"], table[name]["b"]
        sd = float(np.sqrt((a.var() + b.var()) / 2))
        effect = float(b.mean() - a.mean()) / sd
        shown = (
            f"{effect:7.2f} {np.corrcoef(a, b)[0, 1]:12.2f}"
            f" {100 * effect**2 / cpu:12.1f}"
        )
        print(f"{name:45} {a.mean():8.2f} {b.mean():8.2f} {sd:7.2f} {shown}")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("packings", type=int, nargs="?", default=6)
    main(parser.parse_args().packings)
