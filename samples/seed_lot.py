"""A photo of fifty seeds spread beside a printed board, samples/seed-lot, drawn with
known sizes.

.venv/bin/python samples/seed_lot.py FOLDER      # draw it anew
.venv/bin/benchtwin shape samples/seed-lot/spread.jpg --out lot --scanner
"""

import sys
from pathlib import Path

import numpy as np
import pandas as pd
from PIL import Image

sys.path.insert(0, str(Path(__file__).parent.parent / "benchmarks"))
from drawn_seed_photos import Scene, draw

SCENE = Scene("superellipse", groups=(1,) * 50, board="A6", size_px=(2400, 1550))


def make(folder: Path) -> pd.DataFrame:
    """spread.jpg and truth.csv: where each seed lies [px], its length and width
    [mm]."""
    folder.mkdir(parents=True, exist_ok=True)
    picture, seeds = draw(SCENE, np.random.default_rng(5))
    Image.fromarray(picture).save(folder / "spread.jpg", quality=90)
    rows = [
        (*(seed.centre_mm / SCENE.mm_per_px - 0.5), *seed.sizes_mm) for seed in seeds
    ]
    truth = pd.DataFrame(rows, columns=["x_px", "y_px", "length_mm", "width_mm"]).round(
        4
    )
    truth.to_csv(folder / "truth.csv", index=False)
    return truth


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__.strip())
    make(Path(sys.argv[1]))
