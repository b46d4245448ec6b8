"""Pile photos: bias, scatter and coverage of the angle on drawn truth, and the time of
a 12-megapixel photo on one core.

python benchmarks/piles.py [PICTURES]      a row, default 100
"""

import argparse
import io
import os
import time

for threads in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"):
    os.environ.setdefault(threads, "1")

import cv2
import numpy as np
from PIL import Image
from synthetic.piles import PileScene, draw_pile

from benchtwin.vision.measurement import GOOD, MeasurementError
from benchtwin.vision.pile.repose import measure_repose
from benchtwin.vision.recording import Camera

cv2.setNumThreads(1)


def random_scene(rng: np.random.Generator, **options) -> PileScene:
    """A scene of random angle, size, place of the wall, polarity and roll, with
    `options` laid over."""
    light, dark = rng.uniform(170, 230), rng.uniform(25, 60)
    swap = rng.random() < 0.5
    plain = dict(
        angle_deg=rng.uniform(15, 45),
        sides=str(rng.choice(["two", "right", "left"])),
        roll_deg=rng.uniform(-3, 3),
        pile_tone=dark if swap else light,
        ground_tone=light if swap else dark,
        plate_tone=rng.uniform(80, 140),
        size=(1600, 900),
        blur_px=rng.uniform(0.5, 1.5),
    )
    scene = {**plain, **options}
    base = 1450 * (0.5 if scene["sides"] == "two" else 0.8)
    scene.setdefault(
        "pile_height", min(520.0, base * np.tan(np.radians(scene["angle_deg"])))
    )
    return PileScene(**scene)


def hard_scene(rng: np.random.Generator) -> PileScene:
    """Mirror image, box wall, stray seeds, grains, noise and uneven light, each drawn
    at random."""
    sides = str(rng.choice(["two", "right", "left"]))
    wall = None if sides == "two" else float(rng.uniform(60, 200))
    return random_scene(
        rng,
        sides=sides,
        wall_tone=wall,
        wall_height=float(rng.uniform(1.15, 2.5)),
        mirror=float(rng.uniform(0.2, 0.7)),
        strays=int(rng.integers(0, 7)),
        noise=float(rng.uniform(0, 0.04)),
        light=float(rng.uniform(-0.15, 0.15)),
        light_direction_deg=float(rng.uniform(0, 180)),
        roughness_px=float(rng.uniform(0, 2)),
    )


ROWS = {
    "clean": lambda rng: random_scene(rng),
    "noise 5 %": lambda rng: random_scene(rng, noise=0.05),
    "salt and pepper 5 %": lambda rng: random_scene(rng, salt=0.05),
    "light ±15 %": lambda rng: random_scene(
        rng, light=0.15, light_direction_deg=float(rng.uniform(0, 360))
    ),
    "no plate to be seen": lambda rng: random_scene(rng, plate_tone=None, roll_deg=0.0),
    "roughness 4 px": lambda rng: random_scene(rng, roughness_px=4.0),
    "roughness 4 px, length 20 px": lambda rng: random_scene(
        rng, roughness_px=4.0, roughness_length_px=20.0
    ),
    "grains of 12 px": lambda rng: random_scene(rng, grain_px=12.0),
    "grains of 40 px": lambda rng: random_scene(rng, grain_px=40.0),
    "mirror, wall, strays": hard_scene,
}


def measure_row(make, n: int, seed: int) -> dict:
    """Errors, claimed sds and qualities over n drawn pictures."""
    errors, sds, good, failures = [], [], [], 0
    for i in range(n):
        rng = np.random.default_rng([seed, i])
        scene = make(rng)
        camera = (
            Camera(plumb_deg=0.0, plumb_sd_deg=0.0)
            if scene.plate_tone is None
            else Camera()
        )
        try:
            angle = measure_repose(draw_pile(scene, rng), camera).quantities[0]
        except MeasurementError:
            failures += 1
            continue
        errors.append(angle.value - scene.angle_deg)
        sds.append(angle.sd)
        good.append(angle.quality == GOOD)
    off, sound = np.array(errors), np.array(good)
    return dict(
        n=n,
        failed=failures,
        bias=off.mean(),
        sd=off.std(ddof=1),
        worst=np.abs(off).max(),
        claimed=np.median(sds),
        covered=(np.abs(off) <= 1.96 * np.array(sds)).mean(),
        within=((np.abs(off) <= 0.3).sum()) / n,
        worst_good=np.abs(off[sound]).max() if sound.any() else np.nan,
        good=sound.mean(),
    )


def time_photo() -> None:
    """Decode and measure a 12-megapixel colour JPEG, one core, median of 7."""
    scene = PileScene(
        size=(4000, 3000),
        pile_height=1100,
        noise=0.02,
        pile_tone=(200, 170, 90),
        ground_tone=(40, 50, 70),
    )
    buffer = io.BytesIO()
    Image.fromarray(draw_pile(scene, np.random.default_rng(0))).save(
        buffer, "JPEG", quality=92
    )
    decoding, measuring = [], []
    for _ in range(7):
        start = time.process_time()
        image = np.asarray(Image.open(io.BytesIO(buffer.getvalue())))
        middle = time.process_time()
        measure_repose(image)
        decoding.append(middle - start)
        measuring.append(time.process_time() - middle)
    decode, read = np.median(decoding), np.median(measuring)
    print(
        "\n12-megapixel colour JPEG, processor seconds on one core: decode"
        f" {decode:.2f}, measure {read:.2f}"
    )


def main(n: int) -> None:
    heading = (
        "   n fail   bias     sd  claimed  |err|max  ≤0.3°  95% covers  good  worst"
        " good"
    )
    print(f"{'drawn piles, 15–45°, true angle known':32s} {heading}")
    for seed, (name, make) in enumerate(ROWS.items()):
        r = measure_row(make, n, seed)
        print(
            f"{name:32s} {r['n']:4d} {r['failed']:4d} {r['bias']:+.3f}  {r['sd']:.3f}  "
            f"  {r['claimed']:.3f}     {r['worst']:.3f}  {100 * r['within']:4.0f}%     "
            f"   {100 * r['covered']:3.0f}%  {100 * r['good']:3.0f}%      "
            f" {r['worst_good']:.2f}",
            flush=True,
        )
    time_photo()


if __name__ == "__main__":
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("pictures", type=int, nargs="?", default=100)
    main(parser.parse_args().pictures)
