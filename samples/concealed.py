"""Bench folders in which something is concealed: made by the twin with one thing in it
that the recordings do not state.

    .venv/bin/python samples/concealed.py reveal samples/concealed-drop
    .venv/bin/python samples/concealed.py make FOLDER

The first says what it was: diagnose it before. The second makes both of these anew.

The keys stand beside the recordings in base64, so that nobody reads them by accident.
"""

import base64
import json
import sys
from pathlib import Path

import numpy as np
import pandas as pd

KEY = ".key.b64"  # hidden, so that it is no file which benchtwin names as not read
HEADER = """provenance = "simulated"

[camera]
fps = {fps}
mm_per_px = 0.25
mm_per_px_sd = 0.0002
plumb_deg = 0.0
plumb_sd_deg = 0.05
"""
SEEDS = (
    (8.6, 7.3, 6.9),
    (8.2, 7.0, 6.6),
    (8.9, 7.5, 7.0),
    (8.4, 7.2, 6.7),
    (8.0, 6.9, 6.5),
    (8.7, 7.1, 6.8),
)
NEARLY_ROUND = (
    (7.4, 7.1, 7.0),
    (7.2, 6.9, 6.8),
    (7.6, 7.3, 7.1),
    (7.3, 7.0, 6.9),
    (7.1, 6.8, 6.7),
    (7.5, 7.2, 7.0),
)


def reveal(folder: Path) -> dict:
    """The concealed effect and its size."""
    return json.loads(base64.b64decode((folder / KEY).read_text(encoding="ascii")))


def make(out: Path) -> None:
    """Both folders under `out`."""
    make_drop(out / "concealed-drop")
    make_roll(out / "concealed-roll")


def make_drop(folder: Path) -> None:
    """Drops whose recordings state no air."""
    from benchtwin.twin import Parameters
    from benchtwin.twin.paths import like
    from benchtwin.twin.run import run

    begin(folder, HEADER.format(fps=1000.0) + "\n[air]\ndensity_kg_m3 = 0.0\n")
    rng = np.random.default_rng(2027)
    for k, sizes in enumerate(SEEDS):
        height = (310, 450, 310, 450, 310, 450)[k]
        told = {
            "seed": _seed(sizes),
            "drop": {"height_mm": height, "bounces": 1, "spin_sd_rad_s": 3.0},
            "camera": {"fps": 1000.0},
        }
        motion, _ = run(like("drop", told), Parameters(restitution=0.55), rng=rng)
        x, z = 1e3 * motion.positions_m[:, 0, 0], 1e3 * motion.positions_m[:, 0, 2]
        _write(
            folder / f"drop-{k + 1:02d}",
            "drop",
            {"seed": told["seed"], "drop": {"height_mm": height}},
            motion.t_s,
            x,
            z,
            rng,
        )
    conceal(
        folder,
        {
            "rig": "drop",
            "effect": "drag",
            "parameter": round(float(np.mean([share_at(s, 2.0) for s in SEEDS])), 4),
            "unit": "1",
        },
    )


def make_roll(folder: Path) -> None:
    """Rolls both ways over a plate that is called level."""
    from benchtwin.twin import Parameters
    from benchtwin.twin.paths import like, run_path

    begin(folder, HEADER.format(fps=200.0))
    rng = np.random.default_rng(2028)
    for k, sizes in enumerate(NEARLY_ROUND):
        way = {
            "incline_deg": 15.0,
            "incline_length_mm": 20.0,
            "direction": ("+x", "-x")[k % 2],
        }
        told = {
            "seed": _seed(sizes),
            "roll": way | {"slope_deg": -0.25, "axis_sd_deg": 1.0},
            "camera": {"fps": 200.0},
        }
        path = run_path(like("roll", told), Parameters(rolling_friction=0.03), k)
        still = np.zeros(20)  # filmed from a moment before the release
        x = np.concatenate([still, path.way - path.way[0]])
        t = np.arange(len(x)) / 200.0
        _write(
            folder / f"roll-{k + 1:02d}",
            "roll",
            {"seed": told["seed"], "roll": way},
            t,
            x,
            np.zeros(len(x)),
            rng,
        )
    conceal(
        folder, {"rig": "roll", "effect": "slope", "parameter": -0.25, "unit": "deg"}
    )


def share_at(sizes, speed: float) -> float:
    """Drag over weight of a sphere of the same volume in the twin's air."""
    from benchtwin.sim.laws import LAWS
    from benchtwin.sim.rigs.bench import Bench
    from benchtwin.sim.seed import Seed

    seed, bench = (
        Seed.from_dimensions(*(1e-3 * s for s in sizes), density_kg_m3=1250.0),
        Bench(),
    )
    diameter = (6 * seed.volume_m3 / np.pi) ** (1 / 3)
    air = (bench.air_density_kg_m3, bench.air_viscosity_pa_s)
    force = LAWS["drag"].function(
        speed, 0.0, 0.0, 0.0, 0.0, 0.0, diameter, *air, 1.0, 0.0, 0.0, 0.0
    )[0]
    return round(abs(force) / (seed.mass_kg * 9.80665), 4)


def _seed(sizes) -> dict:
    return dict(zip(("length_mm", "width_mm", "thickness_mm"), sizes, strict=True)) | {
        "density_kg_m3": 1250.0
    }


def begin(folder: Path, defaults: str) -> None:
    folder.mkdir(parents=True)
    (folder / "bench.toml").write_text(defaults, encoding="utf8")


def _write(
    folder: Path, rig: str, told: dict, t, x, y, rng: np.random.Generator
) -> None:
    """A recording whose tracker erred by 0.04 mm, from frame to frame alike by half."""
    import tomli_w

    folder.mkdir()
    (folder / "recording.toml").write_text(
        tomli_w.dumps({"rig": rig} | told), encoding="utf8"
    )
    table = pd.DataFrame(
        {"t_s": t, "x_mm": x + noise(len(t), rng), "y_mm": y + noise(len(t), rng)}
    )
    table.round({"t_s": 4, "x_mm": 3, "y_mm": 3}).to_csv(
        folder / "track.csv", index=False
    )


def noise(
    n: int, rng: np.random.Generator, sd: float = 0.04, alike: float = 0.5
) -> np.ndarray:
    out = rng.normal(size=n)
    for i in range(1, n):
        out[i] = alike * out[i - 1] + np.sqrt(1 - alike**2) * out[i]
    return sd * out


def conceal(folder: Path, key: dict) -> None:
    (folder / KEY).write_text(
        base64.b64encode(json.dumps(key).encode()).decode() + "\n", encoding="ascii"
    )


def main(arguments: list[str]) -> int:
    if (
        len(arguments) == 2
        and arguments[0] == "reveal"
        and (Path(arguments[1]) / KEY).is_file()
    ):
        key = reveal(Path(arguments[1]))
        print(
            f"{key['rig']}: {key['effect']}, {key['parameter']}"
            f" {key['unit'] if key['unit'] != '1' else ''}".rstrip()
        )
        for name, value in key.get("parameters", {}).items():
            print(f"{name} = {value}")
        return 0
    if len(arguments) == 2 and arguments[0] == "make":
        make(Path(arguments[1]))
        return 0
    print(__doc__.strip(), file=sys.stderr)
    return 2


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
