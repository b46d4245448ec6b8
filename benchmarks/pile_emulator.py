"""Surfaces of usual heaps that lean on a wall, simulated, and the table of them that a
diagnosis of piles holds heaps against (rigs/pile/usual_heaps.csv).

    python benchmarks/pile_emulator.py [FIRST LAST]    runs of that numbers; 0 0: none

Boxes in a slice or a channel, of drawn size, filling, speed of the gate, frictions and
seeds. One core, about ten seconds a heap; what has been run is kept in
benchmark-runs/heaps/ and not run again. Each heap is then held against a table of all
others: the share of heaps beyond 2 sd, along the flank."""

import argparse
import json
from pathlib import Path

import numpy as np
import pandas as pd
from scipy.ndimage import gaussian_filter1d

from benchtwin.bench.whole_file import write_whole
from benchtwin.rigs.pile import heap_priors
from benchtwin.rigs.pile.flanks import photo_of
from benchtwin.rigs.pile.simulated_heaps import heap_of
from benchtwin.twin import Parameters
from benchtwin.twin.job import Job

STORE = Path("benchmark-runs/heaps")
RUNS = 80
MOST_SEEDS, PACKED = 1100, 0.62
FLOOR_MM = 500.0
MODES = 8
SMOOTH = 1.5  # steps of AT: single grains are no shape
AT = np.arange(0.0, 1.41, 0.05)  # of the flank's way


def drawn(number: int) -> Job:
    """A heap: half of them in a channel, half in a slice between smooth sides."""
    rng = np.random.default_rng([77, number])
    seed_mm, longer = rng.uniform(6, 10), rng.choice([1.0, rng.uniform(1, 1.4)])
    length, fill, width = rng.uniform((60, 50, 30), (120, 130, 60))
    volume = np.pi / 6 * seed_mm**3
    while PACKED * length * fill * width > MOST_SEEDS * volume:
        length, fill, width = 0.97 * length, 0.95 * fill, max(3 * seed_mm, 0.9 * width)
    floor = [FLOOR_MM, width]
    pile = {
        "box_mm": [length, width, 200.0],
        "gate_mm": [width, 200.0],
        "plate_mm": floor,
        "fill_height_mm": fill,
        "gate_speed_mm_s": np.exp(rng.uniform(np.log(30), np.log(2000))),
        **({"slab": True} if number % 2 else {"channel_mm": floor}),
    }
    thick = seed_mm / longer**0.5
    seed = {"length_mm": seed_mm * longer, "width_mm": thick, "thickness_mm": thick}
    parameters = Parameters(
        seed_static_friction=_digits(rng.uniform(0.2, 0.8)),
        static_friction=_digits(rng.uniform(0.1, 0.5)),
        seed_rolling_friction=_digits(np.exp(rng.uniform(np.log(0.005), np.log(0.1)))),
    )
    description = {"pile": pile, "seed": seed | {"density_kg_m3": 1050.0}}
    return Job("pile", parameters, _rounded(description), (9, number), rendered=False)


def _digits(value: float) -> float:
    return float(f"{value:.4g}")


def _rounded(given):
    """The same with numbers of four digits."""
    if isinstance(given, dict):
        return {name: _rounded(value) for name, value in given.items()}
    if isinstance(given, list):
        return [_rounded(value) for value in given]
    return given if isinstance(given, bool) else _digits(given)


def heap(job: Job, file: Path) -> None:
    """Run one heap and keep its flanks' surfaces."""
    photo = photo_of(heap_of(job))
    kept = [
        {
            "angle_deg": f.angle_deg,
            "seeds_high": f.height / photo.seed_mm,
            "surface": np.interp(AT, f.u, f.v).tolist(),
        }
        for f in photo.flanks
    ]
    write_whole(file, json.dumps({"input": job.input, "flanks": kept}))


def table_of(heaps: pd.DataFrame) -> pd.DataFrame:
    """Mean departure from the straight flank of a flat heap many seeds high, its slopes
    by seeds per height and by degrees, and principal components, each times its sd."""
    rest = np.array([*heaps.surface]) - heap_priors.straight(AT)
    rest = gaussian_filter1d(rest, SMOOTH, axis=1, mode="nearest")
    by = np.column_stack([np.ones(len(heaps)), 1 / heaps.seeds_high, heaps.angle_deg])
    line = np.linalg.lstsq(by, rest, rcond=None)[0]
    _, sizes, axes = np.linalg.svd(rest - by @ line, full_matrices=False)
    modes = sizes[:MODES, None] * axes[:MODES] / np.sqrt(len(heaps) - by.shape[1])
    columns = dict(zip(("flat", "per_seed", "per_deg"), line, strict=True))
    columns |= {f"mode_{k + 1}": mode for k, mode in enumerate(modes)}
    return pd.DataFrame({"u": AT} | columns).round(5)


def beyond(heaps: pd.DataFrame) -> pd.Series:
    """Share of heaps that are 2 sd and more off the mean of all others, by place."""
    z = []
    for k in heaps.index:
        own, usual = heaps.loc[k], heap_priors.at_a_wall(table_of(heaps.drop(k)))
        mean = usual.mean(AT, own.seeds_high, own.angle_deg)
        rest = own.surface - heap_priors.straight(AT) - mean
        z.append(rest / usual.spread(AT, own.seeds_high))
    return pd.Series((np.abs(z) > 2).mean(axis=0), AT.round(2))


if __name__ == "__main__":
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("runs", type=int, nargs="*", default=[0, RUNS])
    numbers = range(*parser.parse_args().runs)
    STORE.mkdir(parents=True, exist_ok=True)
    for number in numbers:
        job = drawn(number)
        if not (file := STORE / f"{job.key}.json").exists():
            heap(job, file)
            print(f"heap {number} of {RUNS}", flush=True)
    files = [STORE / f"{drawn(number).key}.json" for number in range(RUNS)]
    kept = pd.DataFrame(
        flank
        for file in files
        if file.exists()
        for flank in json.loads(file.read_text())["flanks"]
    )
    if len(kept) < RUNS / 2:
        raise SystemExit(f"{len(kept)} of {RUNS} heaps: too few for a table")
    table_of(kept).to_csv(heap_priors.TABLE, index=False)
    print(beyond(kept).round(2).to_string())
