"""A whole bench of one lot of soybeans, samples/soybean-bench: drops, slides, rolls
both ways, weighed piles, and drops and slides on a plate of seeds, made by the twin
with parameters that the recordings do not state, and with something concealed in
them.

    .venv/bin/python samples/soybean_bench.py samples/soybean-bench

That makes it anew, in its place (some five minutes).

The key stands beside the recordings; `samples/concealed.py reveal
samples/soybean-bench` reads it."""

import shutil
import sys
import tempfile
from pathlib import Path

import cv2
import numpy as np
import pandas as pd
import tomli_w
from concealed import KEY, begin, conceal, noise

from benchtwin.twin import Parameters
from benchtwin.twin.job import Job

TRUTH = {"restitution": 0.52, "static_friction": 0.36, "rolling_friction": 0.032}
OF_SEEDS = {
    "seed_restitution": 0.58,
    "seed_static_friction": 0.50,
    "seed_rolling_friction": 0.045,
}
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
}  # sd about TRUTH
SLOPE_DEG = -0.2  # how far the level plate falls towards +x: it rises
RIGS = {
    "drop": {"height_mm": 310.0},
    "slide": {"tilt_rate_deg_s": 2.0, "travel_mm": 60.0, "start_deg": 15.0},
    "roll": {"incline_deg": 15.0, "incline_length_mm": 20.0},
    "pile": {
        "box_mm": [110, 32, 200],
        "gate_mm": [32, 200],
        "plate_mm": [300, 32],
        "fill_height_mm": 60,
        "gate_speed_mm_s": 200,
        "slab": True,
    },
}
COVERAGE = 0.78  # of the plate of seeds, and of two cards
ON_SEEDS = {
    "seed-drop-01": {"drop": {"plate": "seeds", "height_mm": 310.0, "drops": 40}},
    **{
        f"seed-slide-{k:02d}": {
            "slide": {
                "plate": "seeds",
                "card_mm": [25, 25],
                "tilt_rate_deg_s": 2.0,
                "slides": 15,
            }
        }
        for k in (1, 2)
    },
}
READ_TO = {"rebound_height_mm": 1.0, "slide_angle_deg": 0.5}
CONCEALED = {"roll": {"slope_deg": SLOPE_DEG, "axis_sd_deg": 1.0}}
FPS = {"drop": 1000.0, "slide": 100.0, "roll": 200.0}
COUNT = {"drop": 8, "slide": 5, "roll": 8, "pile": 10}
PHOTO = {
    "width_px": 3200,
    "height_px": 900,
    "mm_per_px": 0.1,
    "target_mm": [148, 0, 33],
}
TOLD = ("length_mm", "width_mm", "thickness_mm", "mass_g")
SEED = 2031


def make(folder: Path) -> None:
    """All recordings, bench.toml and the key; a bench that was made before is replaced
    when the new one is complete."""
    if folder.exists() and not (folder / KEY).is_file():
        sys.exit(
            f"{folder} is there, and no bench made by this script: it is not replaced"
        )
    rng = np.random.default_rng(SEED)
    with tempfile.TemporaryDirectory() as scratch:
        made = Path(scratch) / "bench"
        begin(made, tomli_w.dumps(_bench()))
        for rig, count in COUNT.items():
            for k in range(count):
                name = f"{rig}-{k + 1:02d}"
                _write(
                    made / name, _job(rig, k).run(Path(scratch) / name, threads=1), rng
                )
                print(name, flush=True)
        for name in ON_SEEDS:
            _write_readings(made / name, _job_on_seeds(name).run(Path(scratch) / name))
            print(name, flush=True)
        conceal(
            made,
            {
                "rig": "roll",
                "effect": "slope",
                "parameter": SLOPE_DEG,
                "unit": "deg",
                "parameters": TRUTH | OF_SEEDS,
            },
        )
        shutil.rmtree(folder, ignore_errors=True)
        shutil.copytree(made, folder)


def _bench() -> dict:
    """What holds for every recording."""
    camera = {
        "mm_per_px": 0.25,
        "mm_per_px_sd": 0.0002,
        "plumb_deg": 0.0,
        "plumb_sd_deg": 0.05,
    }
    return {
        "session": "soybeans",
        "provenance": "simulated",
        "seed": LOT,
        "camera": camera,
    }


def _job(rig: str, k: int) -> Job:
    """Repeat k of a rig, with what is concealed."""
    section = (
        RIGS[rig]
        | CONCEALED.get(rig, {})
        | ({"direction": ("+x", "-x")[k % 2]} if rig == "roll" else {})
    )
    camera = PHOTO if rig == "pile" else {"fps": FPS[rig]}
    description = {
        rig: section,
        "seed": LOT | ({"count": 4} if rig == "slide" else {}),
        "camera": camera,
    }
    own = np.random.default_rng([SEED, COUNT[rig], k])
    values = (
        TRUTH
        if rig == "pile"
        else {
            name: value + own.normal(0, FROM_RUN_TO_RUN[name])
            for name, value in TRUTH.items()
        }
    )
    return Job(
        rig,
        Parameters(**values, **OF_SEEDS),
        description,
        (SEED, COUNT[rig], k),
        rendered=rig == "pile",
    )


def _job_on_seeds(name: str) -> Job:
    """A recording on a plate of seeds."""
    ((rig, section),) = ON_SEEDS[name].items()
    number = list(ON_SEEDS).index(name)
    return Job(
        rig,
        Parameters(**TRUTH, **OF_SEEDS),
        {rig: section | {"coverage": COVERAGE}, "seed": LOT},
        (SEED, sum(COUNT.values()), number),
        rendered=False,
    )


def _write_readings(folder: Path, run) -> None:
    """A recording as somebody would have read it off; nobody reads a rise of nothing.
    How often it was done is what the rows say."""
    folder.mkdir()
    section = ON_SEEDS[folder.name][run.rig]
    stated = {k: v for k, v in section.items() if k not in ("drops", "slides")}
    told = {"rig": run.rig, run.rig: stated | {"coverage": COVERAGE}}
    table = pd.read_csv(run.path / "readings.csv")
    for column, step in READ_TO.items():
        if column in table:
            read = step * (table[column] / step).round()
            table[column] = read.clip(lower=step)
    table.to_csv(folder / "readings.csv", index=False)
    (folder / "recording.toml").write_text(tomli_w.dumps(told), encoding="utf8")


def _write(folder: Path, run, rng: np.random.Generator) -> None:
    """A recording as a bench would have left it: of the track with a tracker's errors,
    or of the photo and the scales."""
    folder.mkdir()
    told = {"rig": run.rig, run.rig: dict(RIGS[run.rig])}
    if run.rig == "pile":
        told[run.rig] |= {
            "filled_mass_g": run.pile.filled_mass_g,
            "retained_mass_g": run.pile.retained_mass_g,
        }
        told |= {"camera": {"mm_per_px": PHOTO["mm_per_px"]}}
        photo = cv2.imread(str(run.path / "photo.png"))
        cv2.imwrite(str(folder / "photo.jpg"), photo, [cv2.IMWRITE_JPEG_QUALITY, 92])
    else:
        told |= {"camera": {"fps": FPS[run.rig]}}
        table = pd.read_csv(run.path / "track.csv")
        for column in ("x_mm", "y_mm"):
            table[column] = (table[column] + noise(len(table), rng)).round(3)
        table.round({"t_s": 4, "tilt_deg": 3}).to_csv(folder / "track.csv", index=False)
        if run.rig == "slide":
            told |= {"seed": {"count": 4}}
        else:
            told |= {"seed": {name: getattr(run.seed, name) for name in TOLD}}
        if run.rig == "roll":
            told["roll"] |= {"direction": run.roll.direction}
    (folder / "recording.toml").write_text(tomli_w.dumps(told), encoding="utf8")


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__.strip())
    make(Path(sys.argv[1]))
