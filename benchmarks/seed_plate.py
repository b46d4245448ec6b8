"""Plates of seeds: what drops and slides on them tell, and whether the intervals that a
calibration makes of them alone hold the truth.

    python benchmarks/seed_plate.py told
    python benchmarks/seed_plate.py otherwise
    python benchmarks/seed_plate.py benches [BENCHES]

each to its table, benchmarks/tables/seed_plate_….csv. `told`: means and scatter over
the parameters of seed on seed (some minutes). `otherwise`: plates that are not as
stated, and what that would make of restitution and static friction, by the slopes of
`told`. `benches`: of each of BENCHES (default 12) the truths are drawn, its recordings
made by the twin, 40 drops and two cards of 8 slides, and calibrated with `--quick`, all
on one design. Kept in benchmark-runs/seed-plate: the same command goes on where it was
stopped."""

import argparse
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import tomli_w

from benchtwin.calibrate.procedure import parameters
from benchtwin.calibrate.procedure.effort import QUICK
from benchtwin.calibrate.procedure.rigs import RANGES
from benchtwin.calibrate.procedure.simulated import calibrate_simulated
from benchtwin.calibrate.procedure.simulator import campaign
from benchtwin.twin import Parameters
from benchtwin.twin.job import Job

OUT, TABLES = Path("benchmark-runs/seed-plate"), Path("benchmarks/tables")
LOT = {
    "length_mm": 7.5,
    "length_range_mm": [7.1, 7.9],
    "width_mm": 7.1,
    "width_range_mm": [6.7, 7.5],
    "thickness_mm": 6.9,
    "thickness_range_mm": [6.5, 7.3],
    "density_kg_m3": 1250.0,
}
PLATE = {"plate": "seeds", "coverage": 0.78}
DROP = {**PLATE, "height_mm": 310.0}
SLIDE = {**PLATE, "card_mm": [25, 25], "tilt_rate_deg_s": 2.0}
USUAL = {
    "seed_restitution": 0.58,
    "seed_static_friction": 0.50,
    "seed_rolling_friction": 0.045,
}
VARIED = {
    "seed_restitution": (0.45, 0.70),
    "seed_static_friction": (0.30, 0.70),
}
# of √(rise/height) over restitution and of tan(angle) over static friction, by `told`
E_SLOPE, FRICTION_SLOPE = 0.84, 1.88
SEED = 2056


def read(rig: str, section: dict, of: dict, rng: tuple[int, ...], folder: Path):
    """Readings of one run, kept in `folder`; its recording states the section."""
    job = Job(rig, Parameters(**of), {rig: section, "seed": LOT}, rng, rendered=False)
    if not folder.exists():
        folder.parent.mkdir(parents=True, exist_ok=True)
        job.run(folder, threads=1)
    return pd.read_csv(folder / "readings.csv").iloc[:, 0].to_numpy()


def told() -> None:
    """A row a set of parameters: mean, its standard error, and sd of single readings,
    of 60 drops and of 4 cards of 4 slides."""
    sets = [USUAL] + [USUAL | {n: v} for n, ends in VARIED.items() for v in ends]
    rows = []
    for k, of in enumerate(sets):
        rises = read("drop", DROP | {"drops": 60}, of, (SEED, 1), OUT / f"told-{k}-d")
        card, place = SLIDE | {"slides": 4}, OUT / f"told-{k}"
        cards = [
            read("slide", card, of, (SEED, 2, c), place / f"{c}") for c in range(4)
        ]
        means = np.array([card.mean() for card in cards])
        rows.append(
            {
                **of,
                "rise_mm": rises.mean(),
                "rise_se_mm": rises.std(ddof=1) / np.sqrt(len(rises)),
                "rise_sd_mm": rises.std(ddof=1),
                "apparent_restitution": np.sqrt(rises.mean() / DROP["height_mm"]),
                "angle_deg": means.mean(),
                "angle_se_deg": means.std(ddof=1) / np.sqrt(len(means)),
                "angle_sd_deg": np.sqrt(np.mean([c.var(ddof=1) for c in cards])),
                "apparent_friction": np.tan(np.radians(means.mean())),
            }
        )
        print(rows[-1], flush=True)
    pd.DataFrame(rows).round(4).to_csv(TABLES / "seed_plate_told.csv", index=False)


def otherwise() -> None:
    """A row a plate: mean rise of 200 drops and angle of 8 cards of 4 slides, and how
    far restitution and friction would be off beside the plate as stated."""
    plates = {
        "as stated": {},
        "a fifth less dense": {"coverage": 0.62},
        "soft glue takes a third": {"glue_loss": 1 / 3},
    }
    found = {}
    for name, keys in plates.items():
        drops = DROP | keys | {"drops": 200}
        rises = read("drop", drops, USUAL, (SEED, 5), OUT / f"other-{name}-d")
        card = SLIDE | {k: v for k, v in keys.items() if k in SLIDE} | {"slides": 4}
        cards = [
            read("slide", card, USUAL, (SEED, 6, c), OUT / f"other-{name}" / f"{c}")
            for c in range(8)
        ]
        angles = np.array([one.mean() for one in cards])
        e, rise_se = np.sqrt(rises.mean() / 310), rises.std(ddof=1) / np.sqrt(200)
        friction = np.tan(np.radians(angles.mean()))
        angle_se = angles.std(ddof=1) / np.sqrt(8)
        found[name] = (rises.mean(), rise_se, angles.mean(), angle_se, e, friction)
        print(name, found[name], flush=True)
    columns = ["rise_mm", "rise_se_mm", "angle_deg", "angle_se_deg"]
    table = pd.DataFrame(found, [*columns, "e", "friction"]).T
    off = table[["e", "friction"]] - table.loc["as stated", ["e", "friction"]]
    table["restitution_off"] = off["e"] / E_SLOPE
    table["friction_off"] = off["friction"] / FRICTION_SLOPE
    file = TABLES / "seed_plate_otherwise.csv"
    table.round(4).to_csv(file, index_label="plate")


def bench(number: int) -> tuple[Path, dict[str, float]]:
    """A bench whose truths are drawn from the middle four fifths of their ranges."""
    rng, folder = np.random.default_rng([SEED, number]), OUT / f"bench-{number:02d}"
    of = {}
    for name, (low, high) in RANGES.items():
        of[name] = float(low + (high - low) * rng.uniform(0.1, 0.9))
    made = {"drops": ("drop", DROP, {"drops": 40})}
    made |= {f"card-{c}": ("slide", SLIDE, {"slides": 8}) for c in (1, 2)}
    for k, (name, (rig, section, many)) in enumerate(made.items()):
        run = OUT / f"runs-{number:02d}" / name
        readings = read(rig, section | many, of, (SEED, number, k), run)
        column = {"drop": "rebound_height_mm", "slide": "slide_angle_deg"}[rig]
        (folder / name).mkdir(parents=True, exist_ok=True)
        stated = {"rig": rig, rig: section, "seed": LOT}
        (folder / name / "recording.toml").write_text(tomli_w.dumps(stated))
        table = pd.DataFrame({column: readings.round(1).clip(0.1)})
        table.to_csv(folder / name / "readings.csv", index=False)
    return folder, of


def benches(count: int) -> None:
    """A row a bench and parameter: truth and interval."""
    rows = []
    effort = replace(QUICK, check=0)
    with campaign(OUT / "store") as simulate:
        for number in range(count):
            folder, of = bench(number)
            found = parameters(calibrate_simulated(folder, simulate, effort=effort))
            for row in found.itertuples():
                held = row.low <= of[row.parameter] <= row.high
                told = {"truth": of[row.parameter], "low": row.low, "high": row.high}
                rows.append(
                    {"bench": number, "parameter": row.parameter, **told, "held": held}
                )
                print(rows[-1], flush=True)
    pd.DataFrame(rows).round(4).to_csv(TABLES / "seed_plate_benches.csv", index=False)


if __name__ == "__main__":
    asked = argparse.ArgumentParser(description=__doc__)
    asked.add_argument("what", choices=["told", "otherwise", "benches"])
    asked.add_argument("count", nargs="?", type=int, default=12)
    options = asked.parse_args()
    if options.what == "told":
        told()
    elif options.what == "otherwise":
        otherwise()
    else:
        benches(options.count)
