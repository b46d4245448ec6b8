"""Draws samples/imported-drop: one steel ball's drops as other tools leave them, their
true answers in truth.csv.

    .venv/bin/python samples/imported_drop.py FOLDER      # draw it anew

film.txt is a table as Tracker exports it (tabs, decimal commas, metres that it does not
name), clap.csv the acoustic stopwatch of phyphox in German (semicolons, decimal
commas). Both are read as they are: by `benchtwin measure` and by `benchtwin import`.
"""

import sys
from pathlib import Path

import numpy as np
import pandas as pd

G, AIR_KG_M3, DRAG = 9.80665, 1.2, 0.44
DIAMETER_MM, MASS_G = 10.0, 4.11
HEIGHT_MM, RESTITUTION = 310.0, 0.62
FPS, NOISE_MM = 120.0, 0.3  # of the film, and of the places clicked in it
STOPWATCH_SD_S = 5e-5
STEP_S = 1e-5
SEED = 22

BENCH = f"""\
# A drawn bench: nothing here was filmed or heard. True answers: truth.csv. \
Made by samples/imported_drop.py.
rig = "drop"

[seed]
length_mm = {DIAMETER_MM}
width_mm = {DIAMETER_MM}
thickness_mm = {DIAMETER_MM}
mass_g = {MASS_G}

[drop]
height_mm = {HEIGHT_MM}
"""


def fall(impacts: int) -> tuple[np.ndarray, np.ndarray, list[float]]:
    """Times [s] and heights of the ball above the plate [m] from the release to the
    last of some impacts, and their times [s]."""
    k = AIR_KG_M3 * DRAG * np.pi * (DIAMETER_MM / 1000) ** 2 / (8 * MASS_G / 1000)
    t, y, v = 0.0, HEIGHT_MM / 1000, 0.0
    times, heights, struck = [t], [y], []
    while len(struck) < impacts:
        a = -G - k * v * abs(v)
        t, y, v = t + STEP_S, y + v * STEP_S + a * STEP_S**2 / 2, v + a * STEP_S
        if y < 0:  # back to the moment of contact
            late = y / v
            struck.append(t - late)
            v = -RESTITUTION * (v - a * late)
            y = v * late
        times.append(t)
        heights.append(y)
    return np.array(times), np.array(heights), struck


def draw(folder: Path) -> pd.DataFrame:
    """Write the bench into `folder`; returns truth.csv's rows."""
    rng = np.random.default_rng(SEED)
    folder.mkdir(parents=True)
    time, height, struck = fall(5)
    film = np.arange(0, struck[2], 1 / FPS)
    x = 0.0123 + 0.004 * film + rng.normal(0, NOISE_MM / 1000, film.size)
    y = np.interp(film, time, height) + rng.normal(0, NOISE_MM / 1000, film.size)
    rows = [f"{a:.6E}\t{b:.6E}\t{c:.6E}" for a, b, c in zip(film, x, y)]
    (folder / "film.txt").write_text(
        "\n".join(["\tmass A\t\t", "t\tx\ty\t", *rows]).replace(".", ",") + "\n",
        encoding="utf8",
    )
    heard = 1.7 + np.array(struck) + rng.normal(0, STOPWATCH_SD_S, len(struck))
    events = [
        f"{a:.9E};{b:.9E}".replace(".", ",")
        for a, b in zip(heard, [*np.diff(heard), 0.0])
    ]
    (folder / "clap.csv").write_text(
        "\n".join(['"Ereigniszeit (s)";"Intervall (s)"', *events]) + "\n",
        encoding="utf8",
    )
    (folder / "bench.toml").write_text(BENCH, encoding="utf8")
    rebound = 1000 * height[(time > struck[0]) & (time < struck[1])].max()
    true = {
        "rebound_height": (rebound, "mm"),
        "restitution": (np.sqrt(rebound / HEIGHT_MM), "1"),
        "restitution_normal": (RESTITUTION, "1"),
    }
    truth = pd.DataFrame(
        [
            (name, q, value, unit)
            for name in ("film", "clap")
            for q, (value, unit) in true.items()
        ],
        columns=["recording", "quantity", "value", "unit"],
    )
    truth.to_csv(folder / "truth.csv", index=False, float_format="%.6g")
    return truth


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__.strip())
    draw(Path(sys.argv[1]))
