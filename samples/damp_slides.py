"""A bench of damp seeds, samples/damp-slides: slides filmed with the plate's angle
beside them, and angles that somebody read to half a degree, at moistures that the
recordings state. Made by the twin with a law that they do not state.

    .venv/bin/python samples/damp_slides.py FOLDER      # make it anew (a minute)

No camera distance, no plumb line, no resolution of the reading is stated: a bench as
people first write it down. The key stands beside the recordings; `samples/concealed.py
reveal samples/damp-slides` reads it."""

import sys
import tempfile
from pathlib import Path

import numpy as np
import pandas as pd
import tomli_w
from concealed import begin, conceal, noise

from benchtwin.twin import Parameters
from benchtwin.twin.job import Job

AT_12_PCT, PER_PCT, FROM_RUN_TO_RUN = (
    0.36,
    -0.008,
    0.003,
)  # static friction, its change by moisture, sd about that
FILMED_PCT = (
    11.9,
    8.1,
    15.2,
    13.0,
    9.3,
    16.0,
    10.4,
    14.3,
    8.8,
    12.6,
)  # in no order, so that time is not moisture in disguise
READ_PCT = (12.3, 15.6, 8.4)
REPEATS = 6  # of a reading
TO_DEG = 0.5  # what a protractor is read to
TILT_SD_DEG = 0.02  # of the sensor on the plate
SEED_KEYS = {
    "length_mm": 7.5,
    "width_mm": 7.1,
    "thickness_mm": 6.9,
    "density_kg_m3": 1250.0,
    "count": 4,
}
PLATE = {"tilt_rate_deg_s": 2.0, "travel_mm": 60.0}
CAMERA = {"fps": 100.0, "mm_per_px": 0.25, "mm_per_px_sd": 0.0005}
START_DEG = 12.0  # where the plate begins to turn
SEED = 2044


def make(folder: Path) -> None:
    """All recordings, bench.toml and the key."""
    begin(
        folder,
        tomli_w.dumps({"provenance": "simulated", "seed": SEED_KEYS, "slide": PLATE}),
    )
    with tempfile.TemporaryDirectory() as scratch:
        for k, moisture in enumerate(FILMED_PCT):
            run = job(k, moisture).run(Path(scratch) / f"{k}")
            told = {
                "rig": "slide",
                "camera": CAMERA,
                "conditions": {"moisture_pct": moisture},
            }
            table = pd.read_csv(run.path / "track.csv")
            write(
                folder / f"film-{k + 1:02d}",
                told,
                "track.csv",
                seen(table, np.random.default_rng([SEED, k, 1])),
            )
            print(f"film-{k + 1:02d}", flush=True)
    for k, moisture in enumerate(READ_PCT):
        rng = np.random.default_rng([SEED, k, 2])
        angles = np.degrees(
            np.arctan([friction(moisture, rng) for _ in range(REPEATS)])
        )
        readings = pd.DataFrame({"slide_angle_deg": TO_DEG * np.round(angles / TO_DEG)})
        write(
            folder / f"read-{k + 1:02d}",
            {"rig": "slide", "conditions": {"moisture_pct": moisture}},
            "readings.csv",
            readings,
        )
    effect = {
        "rig": "slide",
        "effect": "static_friction-follows-moisture_pct",
        "parameter": PER_PCT,
        "unit": "1/pct",
    }
    conceal(
        folder,
        effect
        | {
            "parameters": {
                "static_friction at moisture_pct 12": AT_12_PCT,
                "its sd from run to run": FROM_RUN_TO_RUN,
            }
        },
    )


def friction(moisture_pct: float, rng: np.random.Generator) -> float:
    """Static friction of one run: AT_12_PCT + PER_PCT (moisture − 12), with its
    scatter."""
    return (
        AT_12_PCT
        + PER_PCT * (moisture_pct - 12)
        + FROM_RUN_TO_RUN * float(rng.standard_normal())
    )


def job(number: int, moisture_pct: float) -> Job:
    """The slide filmed as the recording of this number."""
    own = np.random.default_rng([SEED, number])
    description = {
        "slide": PLATE | {"start_deg": START_DEG},
        "seed": SEED_KEYS,
        "camera": {"fps": CAMERA["fps"]},
    }
    return Job(
        "slide",
        Parameters(static_friction=friction(moisture_pct, own)),
        description,
        (SEED, number),
        rendered=False,
    )


def seen(table: pd.DataFrame, rng: np.random.Generator) -> pd.DataFrame:
    """A twin's track as a tracker and a tilt sensor give it."""
    place = {
        name: (table[name] + noise(len(table), rng)).round(3)
        for name in ("x_mm", "y_mm")
    }
    tilt = (table["tilt_deg"] + rng.normal(0, TILT_SD_DEG, len(table))).round(2)
    return pd.DataFrame({"t_s": table["t_s"].round(4), **place, "tilt_deg": tilt})


def write(folder: Path, told: dict, name: str, table: pd.DataFrame) -> None:
    folder.mkdir()
    (folder / "recording.toml").write_text(tomli_w.dumps(told), encoding="utf8")
    table.to_csv(folder / name, index=False)


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__.strip())
    make(Path(sys.argv[1]))
