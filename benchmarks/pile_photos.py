"""Path-traced photos of heaps: how many are measured, how far off, by background; then
again with the pile's frame and foot given.

    python benchmarks/pile_photos.py [--set N] [--pictures DIR] [--width PX]
                                     [--overlays DIR]

Needs mitsuba (the extra `bench`) for pictures that are not yet in DIR. Each set has 6
backgrounds × camera level or 5° above the plate × dull or mirror-like plate = 24
photos, six of which with a box wall that the heap leans on; sets differ in every seed,
colour and lamp."""

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
from benchtwin.vision.measurement import GOOD, MeasurementError
from benchtwin.vision.overlay.pile import draw_repose
from benchtwin.vision.pile.repose import PileOptions, Repose, measure_repose
from path_traced import BACKGROUNDS, Photo, Shot, load, save, take
from PIL import Image

cv2.setNumThreads(1)
FAR_DEG, FAR_SD = 1.0, 3.0  # called good and farther off than both: wrong


def shots(which: int) -> Iterator[Shot]:
    """The 24 photos of one set."""
    for i, background in enumerate(BACKGROUNDS):
        for j, (camera, mirror) in enumerate(
            ((0.0, False), (0.0, True), (5.0, False), (5.0, True))
        ):
            yield Shot(background, camera, mirror, (i + j) % 4 == 0, which)


def photo_of(shot: Shot, folder: Path, width: int) -> Photo:
    """From the folder, or rendered into it."""
    file = folder / f"{shot.name}-{width}.png"
    if not file.with_suffix(".txt").is_file():
        if find_spec("mitsuba") is None:
            raise SystemExit(
                "benchmarks/pile_photos.py: mitsuba is not installed; it is in the"
                " extra bench: pip install -e '.[bench]'"
            )
        save(take(shot, width), file)
    return load(file)


@dataclass(frozen=True)
class Row:
    """One photo measured: the angle's error and sd [deg], nan where there is none; the
    reason for doubt or refusal."""

    shot: Shot
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


def measure(
    shot: Shot, photo: Photo, options: PileOptions
) -> tuple[Row, Repose | None]:
    """The photo through the reader."""
    start = time.process_time()
    try:
        found = measure_repose(photo.pixels, None, options)
    except MeasurementError as error:
        return (
            Row(shot, np.nan, np.nan, False, str(error), time.process_time() - start),
            None,
        )
    q = found.quantities[0]
    return (
        Row(
            shot,
            q.value - photo.angle_deg,
            q.sd,
            q.quality == GOOD,
            q.reason,
            time.process_time() - start,
        ),
        found,
    )


def summary_line(name: str, rows: list[Row]) -> str:
    """One line of figures."""
    seen = [r for r in rows if r.measured]
    off = np.array([abs(r.error) for r in seen]) if seen else np.array([np.nan])
    return (
        f"{name:28s} n {len(rows):3d}  measured {len(seen):3d}  good"
        f" {sum(r.good for r in seen):3d}  good and wrong"
        f" {sum(r.wrong for r in seen):2d}  median |error| {np.median(off):5.2f}° "
        f" worst {off.max():5.2f}°  within 1.96 sd {sum(r.held for r in seen):3d} "
        f" {np.mean([r.seconds for r in rows]):.2f} s"
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--set", type=int, default=1)
    parser.add_argument(
        "--pictures", type=Path, default=Path(tempfile.gettempdir()) / "pile-photos"
    )
    parser.add_argument("--width", type=int, default=1400)
    parser.add_argument("--overlays", type=Path)
    parser.add_argument("--only", default="", help="names that contain this")
    chosen = parser.parse_args()
    chosen.pictures.mkdir(parents=True, exist_ok=True)
    alone, helped = [], []
    for shot in shots(chosen.set):
        if chosen.only not in shot.name:
            continue
        photo = photo_of(shot, chosen.pictures, chosen.width)
        side = "right" if shot.wall else ""
        row, found = measure(shot, photo, PileOptions(side=side))
        alone.append(row)
        by_hand, with_hand = measure(
            shot, photo, PileOptions(side=side, roi=photo.roi, baseline=photo.baseline)
        )
        helped.append(by_hand)
        for r, how in ((alone[-1], "alone"), (helped[-1], "roi, baseline")):
            mark = (
                "WRONG"
                if r.wrong
                else "good"
                if r.good
                else "doubtful"
                if r.measured
                else "failed"
            )
            print(
                f"{shot.name:32s} {photo.angle_deg:5.1f}°  {how:13s} {r.error:+6.2f} ±"
                f" {r.sd:4.2f}  {mark:8s} {r.reason}",
                flush=True,
            )
        if chosen.overlays:
            chosen.overlays.mkdir(parents=True, exist_ok=True)
            for name, one in ((shot.name, found), (f"{shot.name}-by-hand", with_hand)):
                picture = (
                    photo.pixels if one is None else draw_repose(photo.pixels, one)
                )
                Image.fromarray(picture).save(chosen.overlays / f"{name}.png")
    print()
    for background in BACKGROUNDS:
        if some := [r for r in alone if r.shot.background == background]:
            print(summary_line(background, some))
    print(summary_line("all", alone))
    print(summary_line("all, roi and baseline given", helped))


if __name__ == "__main__":
    main()
