"""Graph paper and spread seeds: bias, scatter and coverage on drawn truth, and the time of a 12-megapixel photo on one core.

python benchmarks/sizes.py [PICTURES]      a row, default 40
"""

import argparse
import os
import time

for threads in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"):
    os.environ.setdefault(threads, "1")

import cv2
import numpy as np
from synthetic.paper import Paper, draw_paper, true_scale
from synthetic.seeds import Spread, draw_seeds

from vision.measurement import MeasurementError
from vision.paper.scale import read_scale
from vision.shape.grains import measure_seeds

cv2.setNumThreads(1)
SHAPE = (600, 800)


def any_paper(rng: np.random.Generator, **options) -> Paper:
    """A paper of random pitch, turn, lean and place, with `options` laid over."""
    plain = dict(
        mm_per_px=1 / float(np.exp(rng.uniform(np.log(4), np.log(30)))), tilt_deg=float(rng.uniform(-44, 44)),
        lean_deg=tuple(rng.normal(0, 5, 2)), offset_mm=tuple(rng.uniform(0, 10, 2)), blur_px=float(rng.uniform(0.4, 1.2)),
    )  # fmt: skip
    return Paper(**{**plain, **options})


def strip(rng: np.random.Generator) -> Paper:
    """A strip 10 to 20 mm high, anywhere near the middle."""
    px_per_mm, high = float(rng.uniform(6, 20)), float(rng.uniform(10, 20))
    top, half = float(rng.uniform(-0.3, 0.1)) * SHAPE[0] / px_per_mm, float(rng.uniform(0.25, 0.6)) * SHAPE[1] / px_per_mm
    return any_paper(rng, mm_per_px=1 / px_per_mm, tilt_deg=float(rng.uniform(-10, 10)), strip_mm=(-half, top, half, top + high))


PAPERS = {
    "clean": any_paper,
    "noise 8 %": lambda rng: any_paper(rng, noise=0.08, mm_per_px=1 / float(rng.uniform(8, 30))),
    "light ±40 %": lambda rng: any_paper(rng, light=0.8),
    "40 % covered": lambda rng: any_paper(rng, cover=0.4),
    "barrel or pincushion 5 %": lambda rng: any_paper(rng, barrel=float(rng.choice([-0.05, 0.05]))),
    "lean 20°": lambda rng: any_paper(rng, lean_deg=(20.0, 10.0)),
    "orange ink": lambda rng: any_paper(rng, ink=(0.1, 0.5, 0.9)),
    "strip": strip,
}
SEEDS = {
    "light on dark": Spread(),
    "dark on light": Spread(seed=0.2, ground=0.8),
    "noise 6 %": Spread(noise=0.06),
    "13 px long": Spread(length_px=(13, 0.5), width_px=(11, 0.5)),
    "22 px long": Spread(length_px=(22, 1.5), width_px=(17, 1)),
    "three times as long as wide": Spread(length_px=(90, 5), width_px=(30, 2)),
    "touching": Spread(groups=(1, 1, 2, 2, 3)),
    "all touching": Spread(groups=(2, 2, 3, 2)),
    "light ±30 %": Spread(light=0.6),
    "blur 2.5 px": Spread(blur_px=2.5),
    "light seeds with shadows": Spread(shadow=0.5, seed=0.75, ground=0.5),
    "rim 40 % darker, blotches 25 %": Spread(texture=0.25, limb=0.4),
}


def paper_row(name: str, count: int) -> str:
    errors, shares, scores, wrong = [], [], [], 0
    for i in range(count):
        rng = np.random.default_rng(10_000 + i)
        paper = PAPERS[name](rng)
        try:
            scale = read_scale(draw_paper(paper, SHAPE, rng), paper_sd=0)
        except MeasurementError:
            wrong += 1
            continue
        truth = true_scale(paper, SHAPE, *scale.region.mean(0))
        errors.append(scale.paper_mm_per_px / truth - 1)
        shares.append(scale.paper_mm_per_px_sd / truth)
        scores.append(abs(errors[-1] / shares[-1]))
        wrong += abs(errors[-1]) > 0.01
    rms, covered = 1e6 * np.sqrt(np.mean(np.square(errors))), 100 * np.mean(np.array(scores) < 1.96)
    return f"{name:28} {rms:9.0f} {1e6 * np.median(shares):9.0f} {covered:9.0f} {wrong:9d} / {count}"


def seed_row(name: str, count: int) -> str:
    errors, covered, missed, invented, doubtful = [], [], 0, 0, 0
    for i in range(max(1, count // 4)):
        image, truth = draw_seeds(SEEDS[name], (700, 900), np.random.default_rng(20_000 + i))
        found = list(measure_seeds(image).measured)
        for row in truth.itertuples():
            away = [np.hypot(g.x_px - row.x_px, g.y_px - row.y_px) for g in found]
            if not away or min(away) > 0.25 * row.width_px:
                missed += 1
                continue
            g = found.pop(int(np.argmin(away)))
            errors.append((g.length_px - row.length_px, g.width_px - row.width_px))
            covered += [abs(errors[-1][0]) < 1.96 * g.length_sd_px, abs(errors[-1][1]) < 1.96 * g.width_sd_px]
            doubtful += g.quality != "good"
        invented += len(found)
    (lb, wb), (ls, ws) = np.mean(errors, 0), np.std(errors, 0)
    sizes = f"{lb:+8.2f} {ls:6.2f} {wb:+8.2f} {ws:6.2f} {100 * np.mean(covered):8.0f}"
    return f"{name:31} {sizes} {missed:7d} {invented:9d} {doubtful:9d} {len(errors):6d}"


def seconds(work) -> float:
    """The faster of two runs."""
    times = []
    for _ in range(2):
        start = time.perf_counter()
        work()
        times.append(time.perf_counter() - start)
    return min(times)


def main(count: int) -> None:
    print("Graph paper, drawn: errors of mm_per_px at the paper's centre in parts per million; wrong: not found or off by 1 %")
    print(f"{'':28} {'rms':>9} {'sd said':>9} {'covered %':>9} {'wrong':>9}")
    for name in PAPERS:
        print(paper_row(name, count), flush=True)
    print("\nSpread seeds, drawn: errors in px (mean, scatter); covered: by ±1.96 sd, %")
    print(f"{'':31} {'length':>15} {'width':>15} {'covered':>8} {'missed':>7} {'invented':>9} {'doubtful':>9} {'seeds':>6}")
    for name in SEEDS:
        print(seed_row(name, count), flush=True)
    rng = np.random.default_rng(0)
    for px_per_mm in (5, 12, 40):
        image = draw_paper(Paper(mm_per_px=1 / px_per_mm, tilt_deg=4, blur_px=1.0), (3000, 4000), rng)
        print(
            f"\n12-megapixel graph paper, {px_per_mm} px per mm: {seconds(lambda image=image: read_scale(image)):.2f} s", end=""
        )
    image, _ = draw_seeds(Spread(length_px=(200, 12), width_px=(160, 10), groups=(1,) * 14 + (2, 3, 3)), (3000, 4000), rng)
    print(f"\n12-megapixel photo of 22 seeds: {seconds(lambda: measure_seeds(image)):.2f} s")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("pictures", type=int, nargs="?", default=40)
    main(parser.parse_args().pictures)
