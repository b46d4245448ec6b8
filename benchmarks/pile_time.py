"""What sleeping seeds and a longer step save of a reduced pile, and whether they change
what is read from it.

    python benchmarks/pile_time.py [PACKINGS] [--first N] [--drawn]

PACKINGS: 24 if not stated; a row a run goes to stdout as it ends.
--drawn: each packing with seed–seed parameters of its own, uniform over RANGE, and only
the first way and the last. One thread. The pile is the slice that calibrations
simulate: 30 mm wide between smooth sides, filled to 60 mm, some 530 seeds of five
balls; without --drawn with the soybean paper's parameters. Step in shares of the
Rayleigh time."""

import argparse
import time

import numpy as np
import pandas as pd

from benchtwin.sim.material import SOYBEAN_SOYBEAN, Contact
from benchtwin.sim.rigs.bench import Bench
from benchtwin.sim.rigs.engine import Ours
from benchtwin.sim.rigs.pile import Pile, run_pile

SLICE = Pile(
    box_m=(0.105, 0.03, 0.2),
    gate_m=(0.03, 0.2),
    plate_m=(0.2, 0.03),
    fill_height_m=0.06,
    slab=True,
)
WAYS = {
    "step 0.2": (0.2, False),
    "step 0.2, sleep": (0.2, True),
    "step 0.3": (0.3, False),
    "step 0.3, sleep": (0.3, True),
}
RANGE = {
    "restitution": (0.45, 0.7),
    "static_friction": (0.2, 0.7),
    "rolling_friction": (0.01, 0.06),
}
READ = {
    "repose_angle_deg": "deg",
    "centroid_angle_deg": "deg",
    "crest_mm": "mm",
    "retained_mass_g": "g",
}


def contact(packing: int, drawn: bool) -> Contact:
    """Seed on seed for a packing: drawn for it, or the paper's optimum."""
    if not drawn:
        return SOYBEAN_SOYBEAN
    rng = np.random.default_rng([8, packing])
    e, mu, mu_r = (rng.uniform(*ends) for ends in RANGE.values())
    return Contact(("soybean", "soybean"), e, mu, mu_r)


def piles(packings: range, drawn: bool) -> pd.DataFrame:
    """A row a pile: way, packing, what is read from it, processor time [s]."""
    rows = []
    ways = dict(list(WAYS.items())[:: len(WAYS) - 1]) if drawn else WAYS
    for packing in packings:
        for way, (step, sleep) in ways.items():
            seeds = contact(packing, drawn)
            bench = Bench(
                seed_seed=seeds,
                shear_modulus_pa=3e6,
                rayleigh_fraction=step,
                sleep=sleep,
            )
            began = time.process_time()
            truth = run_pile(
                SLICE, bench, np.random.default_rng([7, packing]), engine=Ours(1)
            ).truth
            rows.append(
                {
                    "way": way,
                    "packing": packing,
                    **{k: truth[k] for k in READ},
                    "cpu_s": time.process_time() - began,
                }
            )
            print(rows[-1], flush=True)
    return pd.DataFrame(rows)


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("packings", nargs="?", type=int, default=24)
    parser.add_argument(
        "--first", type=int, default=0, help="number of the first packing"
    )
    parser.add_argument(
        "--drawn", action="store_true", help="parameters drawn for each packing"
    )
    asked = parser.parse_args()
    run_pile(
        SLICE,
        Bench(shear_modulus_pa=3e6, rayleigh_fraction=0.3),
        np.random.default_rng(0),
        engine=Ours(1),
    )  # compiled
    table = piles(range(asked.first, asked.first + asked.packings), asked.drawn)
    plain = table[table["way"] == "step 0.2"]
    for way, rows in table.groupby("way", sort=False):
        print(f"{way}: {rows['cpu_s'].median():.1f} s of one core")
        for name, unit in READ.items():
            change = (
                rows.set_index("packing")[name] - plain.set_index("packing")[name]
            )  # of the same packing and parameters
            off, error = change.mean(), change.sem()
            print(
                f"    {name}: {rows[name].mean():.2f} {unit}, sd"
                f" {rows[name].std():.2f}; off by {off:+.2f} ± {error:.2f}"
            )


if __name__ == "__main__":
    main()
