"""Parameters calibrated on drop, slide, roll and box pile, checked on two systems that
they were not calibrated on: a heap left by a lifted cylinder, and a rotating drum.

    .venv/bin/python benchmarks/other_system.py [BENCH ...]
        → benchmarks/tables/other_system.csv

Each bench is made by the twin with parameters drawn at random, calibrated with
`--quick`, and both systems are predicted from the posterior. The twin that made the
bench then runs the same systems, PACKINGS times each. Benches: drawn-1, drawn-2; and
sloped, whose plate for the rolls falls by SLOPE_DEG, calibrated with that stated
(sloped-stated) and left out (sloped-left-out). All are kept in
benchmark-runs/other_system: the same command goes on where it was stopped."""

import argparse
import tomllib
from pathlib import Path

import numpy as np
import pandas as pd
import tomli_w
from loop_truth import SEEDS, SLAB, STEEL

from benchtwin import calibrate, predict
from benchtwin.calibrate.procedure.simulator import Run, campaign, seed_numbers
from benchtwin.calibrate.statistics.predictive import NORMAL_95
from benchtwin.twin import Parameters
from benchtwin.twin.job import Job, rig_named

OUT, TABLE = (
    Path("benchmark-runs/other_system"),
    Path("benchmarks/tables/other_system.csv"),
)
BENCHES = {
    "drawn-1": 1,
    "drawn-2": 2,
    "sloped-stated": 3,
    "sloped-left-out": 3,
}  # the number that its parameters are drawn with
SLOPE_DEG = 0.6
LOT = {
    "length_mm": 7.5,
    "length_range_mm": [7.1, 7.9],
    "width_mm": 7.1,
    "width_range_mm": [6.7, 7.5],
    "thickness_mm": 6.9,
    "thickness_range_mm": [6.5, 7.3],
    "density_kg_m3": 1250.0,
}
FROM_RUN_TO_RUN = {
    "restitution": 0.01,
    "static_friction": 0.003,
    "rolling_friction": 0.0006,
}  # sd of single seeds' parameters
COUNT = {"drop": 8, "slide": 4, "roll": 8, "pile": 3}
FPS = {"drop": 1000.0, "slide": 100.0, "roll": 200.0}
SYSTEMS: dict[str, dict] = {
    "cylinder": {
        "cylinder_mm": [46, 90],
        "fill_height_mm": 45,
        "plate_mm": [220, 220],
        "gate_speed_mm_s": 200,
    },
    "drum": {"drum_mm": [90, 20], "fill_share": 0.35, "wait_s": 1.0, "film_s": 1.5},
}
SEED, PACKINGS = 2032, 4


def truth(number: int) -> dict[str, float]:
    """Parameters of a bench, uniform."""
    rng = np.random.default_rng([SEED, number])
    return {
        name: float(f"{rng.uniform(*ends):.4f}")
        for name, ends in (STEEL | SEEDS).items()
    }


def make(bench: Path, name: str) -> None:
    """All recordings of a bench that are not there, as tracks and true angles."""
    for rig, count in COUNT.items():
        for k in range(count):
            folder = bench / f"{rig}-{k + 1:02d}"
            if not folder.exists():
                _job(name, rig, k).run(folder, threads=1)
    if name == "sloped-left-out":
        for toml in bench.glob("roll-*/recording.toml"):
            told = tomllib.loads(toml.read_text(encoding="utf8"))
            told["roll"].pop("slope_deg", None)
            toml.write_text(tomli_w.dumps(told), encoding="utf8")


def _job(name: str, rig: str, k: int) -> Job:
    """Repeat k of a rig."""
    number = BENCHES[name]
    of = truth(number)
    own = np.random.default_rng([SEED, number, COUNT[rig], k])
    single = (
        {n: of[n] + own.normal(0, sd) for n, sd in FROM_RUN_TO_RUN.items()}
        if rig != "pile"
        else {}
    )
    slope = {"slope_deg": SLOPE_DEG} if name.startswith("sloped") else {}
    sections = {
        "drop": {"height_mm": 310.0},
        "slide": {
            "travel_mm": 60.0,
            "start_deg": float(
                np.floor(np.degrees(np.arctan(of["static_friction"])) - 2.0)
            ),
        },
        "roll": {
            "incline_deg": 15.0,
            "incline_length_mm": 20.0,
            "axis_sd_deg": 1.0,
            **slope,
        },
        "pile": SLAB,
    }
    camera = {"camera": {"fps": FPS[rig]}} if rig in FPS else {}
    description = {rig: sections[rig], "seed": LOT, **camera}
    return Job(
        rig,
        Parameters(**of | single),
        description,
        (SEED, number, COUNT[rig], k),
        rendered=False,
    )


def calibrated(name: str) -> Path:
    """The folder of a bench's quick calibration."""
    out = OUT / name / "calibrated"
    if not (out / "result.json").is_file():
        make(OUT / name / "bench", name)
        calibrate(OUT / name / "bench", out=out, quick=True, workers=1)
    return out


def checked(name: str, rig: str) -> pd.DataFrame:
    """A row a quantity: the prediction, the mean and sd of PACKINGS runs of the twin
    that made the bench, and z: their difference over the sd with which the mean of so
    many packings is predicted."""
    of = rig_named(rig)[0]
    settings = {f"{of}.{key}": value for key, value in SYSTEMS[rig].items()}
    found = predict(
        calibrated(name),
        rig,
        out=OUT / name / rig,
        settings=settings,
        workers=1,
        overwrite=True,
    )
    description, number = {of: SYSTEMS[rig], "seed": LOT}, BENCHES[name]
    own = [seed_numbers(SEED, name, rig, k) for k in range(PACKINGS)]
    with campaign(OUT / name / "truth", workers=1) as simulate:
        runs = simulate([Run(of, truth(number), rng, description) for rng in own])
    beside = []
    for quantity, p in found.details.of.items():
        angles = runs[f"true_{quantity}"].dropna()
        z = (angles.mean() - p.mean) / (p.half_width(len(angles)) / NORMAL_95)
        beside.append({"true_mean": angles.mean(), "true_sd": angles.std(), "z": z})
    return pd.concat([found.quantities, pd.DataFrame(beside)], axis=1).assign(
        bench=name
    )


def main(names: list[str]) -> None:
    """A row is written as soon as it is there, in the place of an older one of the same
    bench and system."""
    for name in names:
        for rig in SYSTEMS:
            new = checked(name, rig)
            old = (
                pd.read_csv(TABLE)
                if TABLE.exists()
                else pd.DataFrame({"bench": [], "rig": []})
            )
            kept = old[~(old["bench"].eq(name) & old["rig"].eq(rig))]
            table = pd.concat([kept, new], ignore_index=True) if len(kept) else new
            order = ["bench", *(c for c in table if c != "bench")]
            table[order].to_csv(TABLE, index=False, float_format="%.4g")
            print(new.to_string(index=False), flush=True)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("bench", nargs="*", choices=[*BENCHES, []], default=[])
    main(parser.parse_args().bench or list(BENCHES))
