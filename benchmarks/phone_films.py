"""Measures drawn films whose truth is known (drawn_films.py): how often intervals hold,
what is called good and is wrong.

python benchmarks/phone_films.py [--n 8] [--rng 1] [--keep FOLDER] [--rigs drop roll
slide]"""

import argparse
import math
import os
import tempfile
from collections.abc import Callable
from pathlib import Path

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import cv2
import numpy as np
import pandas as pd
from drawn_films import DRAWN, LOOKS, RIGS, Film, draw
from measure_all import measure

WITHIN, WRONG = (
    1.96,
    3.0,
)  # sds: of a 95 % interval; of what no honest interval misses in a few hundred


Drawer = Callable[[Film, str, np.random.Generator, Path], None]


def write(
    film: Film, look: str, rng: np.random.Generator, folder: Path, drawer: Drawer
) -> None:
    """The recording: its video and what somebody would state of it, each number off by
    its own sd."""
    folder.mkdir(parents=True, exist_ok=True)
    film.distance_mm = float(rng.uniform(400, 2000))
    drawer(film, look, rng, folder / "film.mp4")
    scale_sd = 0.003
    camera: dict[str, float | str] = {
        "fps": film.fps,
        "plumb_deg": 0.0,
        "plumb_sd_deg": 0.2,
        "mm_per_px_sd": film.mm_per_px * scale_sd,
    }
    camera["mm_per_px"] = film.mm_per_px * (1 + rng.normal(0, scale_sd))
    lines = [f'rig = "{film.rig}"']
    for name, section in {**film.keys, "camera": camera}.items():
        lines += [
            "",
            f"[{name}]",
            *(
                f'{k} = "{v}"' if isinstance(v, str) else f"{k} = {v:.6g}"
                for k, v in section.items()
            ),
        ]
    (folder / "recording.toml").write_text("\n".join(lines) + "\n", encoding="utf8")


def found_in(folder: Path) -> pd.DataFrame:
    """Value, sd and quality of every quantity and later bounce of the recordings in
    `folder`."""
    rows = []
    for seen in measure(folder):
        rows += [
            (seen.recording, q.name, q.value, q.sd, q.quality, q.reason)
            for q in seen.quantities
        ]
        if seen.bounces is None:
            continue
        for b in seen.bounces.iloc[1:].to_dict("records"):
            name = f"restitution_bounce_{int(b['bounce'])}"
            rows.append(
                (
                    seen.recording,
                    name,
                    b["restitution"],
                    b["restitution_sd"],
                    b.get("quality", "unstated"),
                    "",
                )
            )
    return pd.DataFrame(
        rows, columns=["recording", "quantity", "value", "sd", "quality", "reason"]
    )


def study(folder: Path, count: int, seed: int, rigs: list[str]) -> None:
    truth = []
    for rig in rigs:
        for k in range(count):
            rng = np.random.default_rng([seed, RIGS.index(rig), k])
            film, look = DRAWN[rig](rng), LOOKS[k % len(LOOKS)]
            name = f"{rig}-{k + 1:02d}"
            write(film, look, rng, folder / name, draw)
            truth += [(name, rig, look, q, v) for q, v in film.truth.items()]
    table = pd.DataFrame(
        truth, columns=["recording", "rig", "look", "quantity", "truth"]
    )
    table.to_csv(folder / "truth.csv", index=False)
    report(table.merge(found_in(folder), how="left", on=["recording", "quantity"]))


def report(table: pd.DataFrame) -> None:
    """One line a rig and quantity, then all that is off by more than 1.96 sd or was not
    measured."""
    table["off"] = table.value - table.truth
    table["sds"] = table.off / table.sd
    table["kind"] = table.quantity.str.replace(
        r"_bounce_\d", " of later bounces", regex=True
    )
    print(
        f"{'rig':6s} {'quantity':30s} {'n':>4s} {'measured':>8s} {'good':>5s}"
        f" {'within 1.96 sd':>14s} {'good, > 3 sd':>12s} {'rms':>8s}"
    )
    for (rig, kind), rows in table.groupby(["rig", "kind"], sort=False):
        known = rows[np.isfinite(rows.value)]
        good = known[known.quality == "good"]
        share = (
            f"{100 * (known.sds.abs() < WITHIN).mean():.0f} %" if len(known) else "-"
        )
        rms = math.sqrt((known.off**2).mean()) if len(known) else math.nan
        wrong = int((good.sds.abs() > WRONG).sum())
        print(
            f"{rig:6s} {kind:30s} {len(rows):4d} {len(known):8d} {len(good):5d}"
            f" {share:>14s} {wrong:12d} {rms:8.4g}"
        )
    odd = table[~(table.sds.abs() < WITHIN)]
    print(
        odd[
            [
                "recording",
                "look",
                "quantity",
                "truth",
                "value",
                "sd",
                "sds",
                "quality",
                "reason",
            ]
        ].to_string(index=False)
    )


if __name__ == "__main__":
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--n", type=int, default=8, help="films a rig")
    parser.add_argument(
        "--rng",
        type=int,
        default=1,
        help="start of the random numbers; another set is another number",
    )
    parser.add_argument(
        "--keep",
        type=Path,
        help="write the films here, a folder that is not there yet, and leave them",
    )
    parser.add_argument("--rigs", nargs="+", choices=RIGS, default=list(RIGS))
    arguments = parser.parse_args()
    cv2.setNumThreads(1)
    if arguments.keep:
        arguments.keep.mkdir(parents=True)
        study(arguments.keep, arguments.n, arguments.rng, arguments.rigs)
    else:
        with tempfile.TemporaryDirectory() as made:
            study(Path(made), arguments.n, arguments.rng, arguments.rigs)
