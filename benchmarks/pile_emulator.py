"""Surfaces of simulated heaps against what the diagnosis of piles holds for usual
(diagnose/rigs/pile/heap_priors.py).

    python benchmarks/pile_emulator.py [RUNS]      to add, default all; 0: what is there

One core, about a minute a heap; what has been run is kept in benchmark-runs/heaps/ and
not run again."""

import argparse
import json
from pathlib import Path

import numpy as np
import pandas as pd
from scipy.ndimage import uniform_filter1d

from benchtwin.rigs.pile import heap_priors
from benchtwin.rigs.pile.flanks import photo_of
from benchtwin.rigs.pile.read import SeenPile
from benchtwin.sim.rigs.profile import outline
from benchtwin.twin import Parameters
from benchtwin.twin.job import Job
from benchtwin.twin.run import run

STORE = Path("benchmark-runs/heaps")
SEED_MM = 8.7
SLAB = {
    "box_mm": [105, 30, 200],
    "gate_mm": [30, 200],
    "plate_mm": [300, 30],
    "fill_height_mm": 60,
    "slab": True,
}
WALLED = {**SLAB, "plate_mm": [300, 200], "slab": False}
ROUND = {"cylinder_mm": [70.0, 150.0], "fill_height_mm": 60, "plate_mm": [300, 300]}
STEP_MM = 1.0
CASES: list[tuple[str, dict, dict]] = [  # what it shows, contact parameters, [pile]
    ("usual", {}, SLAB),
    ("usual", {"seed_static_friction": 0.3, "seed_rolling_friction": 0.02}, SLAB),
    ("usual", {"seed_static_friction": 0.55, "seed_rolling_friction": 0.1}, SLAB),
    ("usual", {"seed_static_friction": 0.3, "seed_rolling_friction": 0.1}, SLAB),
    ("usual", {}, ROUND),
    ("gate-speed", {}, {**SLAB, "gate_speed_mm_s": 200}),
    ("usual", {"seed_static_friction": 0.3, "seed_rolling_friction": 0.02}, ROUND),
    ("wall-friction", {}, WALLED),
    ("cohesion", {"laws": {"cohesion_jkr": {"work": 0.3}}}, SLAB),
    ("particle-shape", {"spheres": 1}, SLAB),
    ("gate-speed", {}, {**SLAB, "gate_speed_mm_s": 25}),
    ("usual", {"seed_static_friction": 0.55, "seed_rolling_friction": 0.1}, ROUND),
]
PACKINGS = 2


def jobs() -> list[tuple[str, Job]]:
    """All heaps, the first packing of each case before the second."""
    made = []
    for packing in range(PACKINGS):
        made += [
            (
                what,
                Job(
                    "pile",
                    Parameters(**p),
                    {"pile": pile},
                    (9, packing),
                    rendered=False,
                ),
            )
            for what, p, pile in CASES
        ]
    return made


def heap(what: str, job: Job) -> None:
    """Run one heap and keep its outline."""
    file = STORE / f"{job.key}.json"
    if file.exists():
        return
    motion, _ = run(
        job.recording(Path("heap")),
        job.parameters,
        rng=np.random.default_rng(list(job.rng)),
        threads=1,
    )
    places = 1e3 * motion.positions_m[-1, :, 0]
    x = np.arange(np.floor(np.nanmin(places)) - 12, np.nanmax(places) + 12, STEP_MM)
    surface = 1e3 * outline(motion, 1e-3 * x)
    kept = {
        "what": what,
        "input": job.input,
        "truth": motion.truth,
        "x_mm": x.tolist(),
        "z_mm": surface.tolist(),
    }
    part = file.with_suffix(".part")
    part.write_text(json.dumps(kept))
    part.replace(file)


def seen(kept: dict) -> SeenPile:
    """The outline as a photo at table height would show it: its plate level, its plumb
    line known."""
    two = "cylinder_mm" in kept["input"]["description"]["pile"]
    x = np.arange(kept["x_mm"][0] if two else 0.0, kept["x_mm"][-1], 0.25)
    z = np.interp(x, kept["x_mm"], kept["z_mm"])
    smooth = uniform_filter1d(z, len(z) // 50 | 1)
    crest, low = int(smooth.argmax()), np.flatnonzero(smooth < 0.02 * z.max())
    right = x[min(low[low > crest], default=len(x) - 1)]
    left = x[max(low[low < crest], default=0)] if two else None
    description = {
        "camera": {"plumb_deg": 0.0, "plumb_sd_deg": 0.05},
        "pile": {},
        "seed": {"length_mm": SEED_MM},
    }
    return SeenPile(
        kept["what"],
        "",
        x,
        z,
        "mm",
        0.0,
        0.0,
        0.02,
        "plate",
        x[crest],
        (left, right),
        description,
    )


def departures(kept: dict) -> pd.DataFrame:
    """Departure from the straight flank over what is usual, in sd of what is, by tenths
    of the flank's way; one row a flank."""
    rows = []
    for flank in photo_of(seen(kept)).flanks:
        high = flank.height / SEED_MM
        rest = (
            flank.v - heap_priors.straight(flank.u) - heap_priors.mean(flank.u, high)
        ) / heap_priors.spread(flank.u, high)
        tenth = np.floor(10 * flank.u).astype(int)
        row = {"what": kept["what"], "angle_deg": flank.angle_deg, "seeds_high": high}
        rows.append(
            row
            | {
                f"{k / 10:.1f}": float(rest[tenth == k].mean())
                for k in range(12)
                if (tenth == k).any()
            }
        )
    return pd.DataFrame(rows)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("runs", type=int, nargs="?")
    runs = parser.parse_args().runs
    STORE.mkdir(parents=True, exist_ok=True)
    every = jobs()
    left = [
        (what, job) for what, job in every if not (STORE / f"{job.key}.json").exists()
    ]
    for done, (what, job) in enumerate(left[:runs], start=1):
        heap(what, job)
        print(f"{done} of {len(left)}: {what}", flush=True)
    kept = [
        json.loads(file.read_text())
        for file in (STORE / f"{job.key}.json" for _, job in every)
        if file.exists()
    ]
    print(pd.concat([departures(k) for k in kept]).round(1).to_string(index=False))
