"""Path-traced photos of heaps: how far off every quantity is, by background and camera;
then again with the pile's frame and foot given, and on other crops.

    python benchmarks/pile_photos.py [--set N] [--kind KIND] [--crops N]
                                     [--pictures DIR] [--width PX] [--overlays DIR]

Needs mitsuba (the extra `bench`) for pictures that are not yet in DIR. A set of the
usual kind has 6 backgrounds × camera level or 5° above the plate × dull or mirror-like
plate = 24 photos, six of which with a box wall that the heap leans on; low: heaps of 10
to 20°; above: a camera 10 to 25° above the plate; grains: rice, wheat, lentils; strewn:
single grains about the heap, few or a layer. Sets differ in every seed, colour and
lamp. --crops reads each photo on as many crops of 60 to 100 % of its sides as well."""

import argparse
import os
import tempfile
import time
from collections.abc import Iterator
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path

for threads in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"):
    os.environ.setdefault(threads, "1")

import cv2
import numpy as np
from path_traced import BACKGROUNDS, GRAINS, Photo, Shot, load, save, take
from PIL import Image

from benchtwin.vision.measurement import FAILED, GOOD, MeasurementError
from benchtwin.vision.overlay.pile import draw_repose
from benchtwin.vision.pile.repose import PileOptions, Repose, measure_repose

cv2.setNumThreads(1)
FAR_DEG, FAR_SD = 1.0, 3.0  # called good and farther off than both: wrong
MAIN = "repose_angle"
KINDS = ("usual", "low", "above", "grains", "strewn")


def shots(which: int, kind: str) -> Iterator[Shot]:
    """The photos of one set."""
    for i, background in enumerate(BACKGROUNDS):
        if kind == "usual":
            for j, (camera, mirror) in enumerate(
                ((0.0, False), (0.0, True), (5.0, False), (5.0, True))
            ):
                yield Shot(background, camera, mirror, (i + j) % 4 == 0, which)
        elif kind == "low":
            camera, mirror = 5.0 * (i % 2), i % 3 == 0
            yield Shot(background, camera, mirror, i == 4, which, (10.0, 20.0))
        elif kind == "grains":
            for j in (0, 1):
                grain = list(GRAINS)[(i + j) % 3]
                yield Shot(background, 5.0 * j, False, i == 4, which, grain=grain)
        elif kind == "strewn":
            share = 0.6 if i % 2 else 0.15
            yield Shot(background, 5.0 * (i % 3 > 0), False, False, which, strewn=share)
        else:
            for camera in (10.0 + 3 * (i % 3), 18.0 + 3 * (i % 3)):
                yield Shot(background, camera, i == 5, i % 3 == 1, which)


def photo_of(shot: Shot, folder: Path, width: int) -> Photo:
    """From the folder, or rendered into it."""
    file = folder / f"{shot.name}-{width}.png"
    if not file.with_suffix(".json").is_file():
        if find_spec("mitsuba") is None:
            raise SystemExit(
                "benchmarks/pile_photos.py: mitsuba is not installed; it is in the"
                " extra bench: pip install -e '.[bench]'"
            )
        save(take(shot, width), file)
    return load(file)


@dataclass(frozen=True)
class Row:
    """One quantity of one photo: its error and sd [deg], nan where there is none; the
    reason for doubt or refusal."""

    shot: Shot
    name: str
    error: float
    sd: float
    good: bool
    reason: str
    seconds: float

    @property
    def measured(self) -> bool:
        return bool(np.isfinite(self.error))

    @property
    def wrong(self) -> bool:
        return self.good and abs(self.error) > max(FAR_SD * self.sd, FAR_DEG)

    @property
    def held(self) -> bool:
        return abs(self.error) <= 1.96 * self.sd

    @property
    def mark(self) -> str:
        if not self.measured:
            return "failed"
        return "WRONG" if self.wrong else "good" if self.good else "doubtful"


def measure(
    shot: Shot, photo: Photo, options: PileOptions
) -> tuple[list[Row], Repose | None]:
    """Every quantity whose truth is known, as the reader gives it."""
    start = time.process_time()
    found, trouble = None, ""
    try:
        found = measure_repose(photo.pixels, None, options)
    except MeasurementError as error:
        trouble = str(error)
    spent = time.process_time() - start
    given = {} if found is None else {q.name: q for q in found.quantities}
    rows = []
    for name, true in photo.truth.items():
        if (q := given.get(name)) is None or q.quality == FAILED:
            why = trouble if q is None else q.reason
            rows.append(Row(shot, name, np.nan, np.nan, False, why, spent))
        else:
            good = q.quality == GOOD
            rows.append(Row(shot, name, q.value - true, q.sd, good, q.reason, spent))
    return rows, found


def summary_line(name: str, rows: list[Row]) -> str:
    """One line of figures."""
    seen = [r for r in rows if r.measured]
    off = np.array([abs(r.error) for r in seen] or [np.nan])
    return (
        f"{name:36s} n {len(rows):3d}  measured {len(seen):3d}  good"
        f" {sum(r.good for r in seen):3d}  wrong {sum(r.wrong for r in seen):2d} "
        f" median {np.median(off):5.2f}° rms {np.sqrt(np.mean(off**2)):5.2f}° worst"
        f" {off.max():5.2f}°  ≤ 0.5, 1, 2° {(off <= 0.5).sum():3d}"
        f" {(off <= 1).sum():3d} {(off <= 2).sum():3d}  held"
        f" {sum(r.held for r in seen):3d}  {np.mean([r.seconds for r in rows]):.2f} s"
    )


def crops(photo: Photo, count: int, shot: Shot) -> Iterator[PileOptions]:
    """Frames that hold the pile and some of what is around it."""
    rng = np.random.default_rng([count, shot.seed])
    height, width = photo.pixels.shape[:2]
    x, y, w, h = photo.roi
    for _ in range(count):
        left, top = (int(v * rng.uniform(0.1, 0.9)) for v in (x, y))
        right = int(x + w + (width - x - w) * rng.uniform(0.1, 0.9))
        bottom = int(y + h + (height - y - h) * rng.uniform(0.1, 0.9))
        side = "right" if shot.wall else ""
        yield PileOptions(roi=(left, top, right - left, bottom - top), side=side)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--set", type=int, default=1)
    parser.add_argument("--kind", choices=KINDS, default="usual")
    parser.add_argument("--crops", type=int, default=0)
    parser.add_argument(
        "--pictures", type=Path, default=Path(tempfile.gettempdir()) / "pile-photos"
    )
    parser.add_argument("--width", type=int, default=1400)
    parser.add_argument("--overlays", type=Path)
    parser.add_argument("--only", default="", help="names that contain this")
    chosen = parser.parse_args()
    chosen.pictures.mkdir(parents=True, exist_ok=True)
    read: dict[str, list[Row]] = {"alone": [], "roi, baseline": [], "crops": []}
    for shot in shots(chosen.set, chosen.kind):
        if chosen.only not in shot.name:
            continue
        photo = photo_of(shot, chosen.pictures, chosen.width)
        side = "right" if shot.wall else ""
        by_hand = PileOptions(side=side, roi=photo.roi, baseline=photo.baseline)
        ways = [("alone", PileOptions(side=side)), ("roi, baseline", by_hand)]
        ways += [("crops", crop) for crop in crops(photo, chosen.crops, shot)]
        for how, options in ways:
            rows, found = measure(shot, photo, options)
            read[how] += rows
            for r in rows:
                if r.name == MAIN or r.wrong:
                    print(
                        f"{shot.name:30s} {photo.truth[r.name]:5.1f}°  {how:13s}"
                        f" {r.name:24s} {r.error:+6.2f} ± {r.sd:4.2f}  {r.mark:8s}"
                        f" {r.reason}",
                        flush=True,
                    )
            if chosen.overlays and how != "crops":
                chosen.overlays.mkdir(parents=True, exist_ok=True)
                drawn = (
                    photo.pixels if found is None else draw_repose(photo.pixels, found)
                )
                file = f"{shot.name}-{how.split(',')[0]}.png"
                Image.fromarray(drawn).save(chosen.overlays / file)
    print()
    for background in BACKGROUNDS:
        some = [r for r in read["alone"] if r.shot.background == background]
        if some := [r for r in some if r.name == MAIN]:
            print(summary_line(background, some))
    for how, rows in read.items():
        for name in dict.fromkeys(r.name for r in rows):
            print(summary_line(f"{how}: {name}", [r for r in rows if r.name == name]))


if __name__ == "__main__":
    main()
