"""Benches of real flights in which nothing is missing, and drawn ones beside them: how
often does a diagnosis of drops raise an alarm, and is its p uniform?

    git clone https://github.com/DAIRLab/contact-nets CLONES/contact-nets
    .venv/bin/python benchmarks/null_drops.py CLONES OUT [--benches 100] [--keys exact]
        [--flights real] [--sizes 5 10]

A cube is tossed; some of its flights, drawn at random, are a bench, in the plane
in which each moves. What all of them have in common is taken away first: lengths that
are 1.8 % short and the cube's drag. What is left, by which each flight differs, stays:
the point that is tracked lies 6 mm beside the centre of mass of a turning body.

Keys: none, rough (scale ± 1 %, plumb ± 0.5°) or exact (scale ± 0.2 %, the camera 20 m
away); scale and plumb line are off by as much. Flights: real; white (parabolas from the
same starts, and noise); scatter (and to each its own force); force (and one upwards
that all have). OUT/…csv holds each bench's alarm, p and verdict; printed are sums."""

import argparse
import tempfile
from pathlib import Path

import numpy as np
import pandas as pd
from learn_priors import FPS, SIDE_M, TOSSES, G, tensor
from scipy import stats

from benchtwin.infer.finding import Finding
from benchtwin.rigs.drop.diagnose import diagnose_drop
from benchtwin.rigs.drop.read import read_drops

LEAST_ROWS, GAP_M = 12, 0.004
NOISE_M = 2e-5  # of a row of these tracks
OWN_M_S2 = 0.08  # of a flight's own force, each way
SHARED_M_S2 = 0.25  # of one that all flights have: SNR 7 to 10 beside their own
KEYS = {  # what is stated, and by how much (sd) scale and plumb line are then off
    "none": ("", 0.01, 1.0),
    "rough": ("mm_per_px = 1.0\nplumb_deg = 0.0\n", 0.01, 0.5),
    "exact": (
        "mm_per_px = 1.0\nmm_per_px_sd = 0.002\ndistance_mm = 20000\n",
        0.002,
        1.0,
    ),
}
BENCH = """rig = "drop"

[seed]
length_mm = 104.8
width_mm = 104.8
thickness_mm = 104.8
mass_g = 370

[air]
density_kg_m3 = 0.0

[camera]
fps = 148.0
"""


def flights_of(clones: Path) -> list[np.ndarray]:
    """Places (n, 2) [m] of each flight, along its level way and up."""
    out = []
    for number in range(TOSSES):
        file = clones / "contact-nets" / "data" / "tosses_processed" / f"{number}.pt"
        rows = tensor(file)[0]
        place, q = rows[:, :3] * SIDE_M / 2, rows[:, 3:7]
        w, x, y, z = (q / np.linalg.norm(q, axis=1)[:, None]).T
        up = [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)]
        gap = place[:, 2] - SIDE_M / 2 * np.abs(np.column_stack(up)).sum(1)
        end = int(np.argmax(gap < GAP_M)) or len(gap)
        if end - 2 >= LEAST_ROWS:
            own = place[1 : end - 1]
            level = own[:, :2] - own[0, :2]
            way = np.polyfit(np.arange(len(level)), level, 1)[0]
            along = level @ (way / np.linalg.norm(way))
            out.append(np.column_stack([along, own[:, 2]]))
    return out


def freed(flights: list[np.ndarray]) -> list[np.ndarray]:
    """The flights without what all have in common: a gravity other than G, and a drag
    k |v| v; by least squares, each flight from its own start."""
    parts = []
    for places in flights:
        t = np.arange(len(places)) / FPS
        line = np.linalg.qr(np.column_stack([np.ones_like(t), t]))[0]
        curve = np.polyfit(t, places, 2)
        speed = 2 * curve[0] * t[:, None] + curve[1]
        pull = -np.linalg.norm(speed, axis=1)[:, None] * speed
        slowed = np.cumsum(np.cumsum(pull, axis=0), axis=0) / FPS**2
        fallen = np.column_stack([0 * t, -(t**2) / 2])
        columns = [c - line @ (line.T @ c) for c in (fallen, slowed, places)]
        parts.append((slowed, np.column_stack([c.T.ravel() for c in columns])))
    rows = np.vstack([p for _, p in parts])
    gravity, drag = np.linalg.lstsq(rows[:, :2], rows[:, 2], rcond=None)[0]
    print(f"gravity {gravity:.3f} m/s², drag over mass {drag:.4f} 1/m taken away")
    return [
        (places - drag * slowed) * G / gravity
        for places, (slowed, _) in zip(flights, parts, strict=True)
    ]


def drawn(places: np.ndarray, own: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """A flight from the start of another one, by a force `own` (2,) [m/s²] beside
    gravity, with noise."""
    t = np.arange(len(places)) / FPS
    fall = np.outer(t**2 / 2, own - np.array([0.0, G]))
    line = np.polyfit(t, places - np.outer(t**2 / 2, [0.0, -G]), 1)
    straight = np.outer(t, line[0]) + line[1]
    return straight + fall + NOISE_M * rng.standard_normal(places.shape)


def flights_for(kind: str, places: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """A flight of the kind asked for."""
    if kind == "real":
        return places
    own = OWN_M_S2 * rng.standard_normal(2) * (kind != "white")
    shared = np.array([0.0, SHARED_M_S2]) * (kind == "force")
    return drawn(places, own + shared, rng)


def diagnosed(bench: list[np.ndarray], keys: str, rng) -> Finding:
    """The finding of a bench of flights."""
    stated, scale_sd, plumb_sd = KEYS[keys]
    times = 1 + scale_sd * rng.standard_normal()
    angle = np.radians(plumb_sd * rng.standard_normal())
    c, s = times * np.cos(angle), times * np.sin(angle)
    bench = [places @ np.array([[c, s], [-s, c]]) for places in bench]
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "bench.toml").write_text(BENCH + stated)
        for k, places in enumerate(bench):
            (folder / f"toss-{k}").mkdir()
            table = np.column_stack([np.arange(len(places)) / FPS, 1e3 * places])
            pd.DataFrame(table, columns=["t_s", "x_mm", "y_mm"]).to_csv(
                folder / f"toss-{k}" / "track.csv", index=False, float_format="%.6f"
            )
        with np.errstate(all="ignore"):
            return diagnose_drop(read_drops(folder), rng)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("clones", type=Path)
    parser.add_argument("out", type=Path)
    parser.add_argument("--benches", type=int, default=100)
    parser.add_argument("--keys", choices=[*KEYS], default="exact")
    kinds = ("real", "white", "scatter", "force")
    parser.add_argument("--flights", choices=kinds, default="real")
    parser.add_argument("--sizes", type=int, nargs=2, default=(5, 10), help="flights")
    parser.add_argument("--rng", type=int, default=1)
    told = parser.parse_args()
    flights, found = freed(flights_of(told.clones)), []
    told.out.mkdir(parents=True, exist_ok=True)
    for number in range(told.benches):
        rng = np.random.default_rng([told.rng, number])
        least, most = told.sizes
        size = rng.integers(least, most + 1)
        some = rng.choice(len(flights), size, replace=False)
        bench = [flights_for(told.flights, flights[k], rng) for k in some]
        one = diagnosed(bench, told.keys, rng)
        likely = " + ".join(one.explanations[0][0])
        said = one.alarm, one.p_global, one.verdict, " ".join(one.names)
        found.append((len(some), *said, likely, one.explanations[0][1]))
        columns = ["flights", "alarm", "p", "verdict", "names", "likeliest", "prob"]
        table = pd.DataFrame(found, columns=columns)
        name = f"{told.flights}-{told.keys}-{'-'.join(map(str, told.sizes))}.csv"
        table.to_csv(told.out / name, index=False)
    p = stats.kstest(table.p, "uniform")
    print(
        f"{told.flights}, keys {told.keys}: {table.alarm.sum()} of {len(table)} alarm,"
        f" {(table.p < 0.05).mean():.0%} with p < 0.05, KS {p.statistic:.2f}"
        f" (p {p.pvalue:.2g}); {(table.verdict == 'name').sum()} names"
    )


if __name__ == "__main__":
    main()
