"""`benchtwin shape`: photos of spread seeds in, a lot of measured shapes out; whole or not at all."""

import math
import os
import shutil
import sys
from pathlib import Path

import tomli_w
from PIL import Image
from rich.console import Console

from vision.evidence.photo import PHOTO_SUFFIXES
from vision.measurement import MeasurementError
from vision.overlay.lot import draw_outlines, draw_sizes
from vision.shape.lot import OUTLINES, SEEDS, SIZES, SUMMARY, WHOLE, read_lot, summary
from vision.shape.spread import View, measure_spread, with_thickness

DONE, NOTHING, MISUSED = 0, 1, 2
OWN = {SEEDS, OUTLINES, SUMMARY, "overlays", "outlines.png", "sizes.png"}


def shape_command(
    photos: list[Path], out: Path, side: list[Path], mm_per_px: float | None, mm_per_px_sd: float | None,
    distance_mm: float | None, scanner: bool, overwrite: bool, quiet: bool,
) -> int:  # fmt: skip
    """Measure the seeds of all photos and write the lot into the folder `out`; returns the exit code."""
    console = Console(stderr=True, quiet=quiet)
    try:
        _check(out, overwrite)
        if scanner and distance_mm is not None:
            raise MeasurementError("--scanner and --distance-mm: a scanner has no distance; give one of them")
        if distance_mm is not None and not distance_mm > 50:
            raise MeasurementError(f"--distance-mm {distance_mm:g}: must be above 50; it is the lens's distance from the paper")
        view = View(mm_per_px, mm_per_px_sd, math.inf if scanner else distance_mm)
        found, turned = _photos(photos), _photos(side) if side else []
    except MeasurementError as error:
        print(f"benchtwin shape: {error}", file=sys.stderr)
        return MISUSED
    part = out.with_name(f".{out.name}.part-{os.getpid()}")
    try:
        with console.status("measuring") as status:
            spread, thickness = measure_spread(found, view, lambda name: status.update(f"measuring {name}")), None
            if turned:
                spread, thickness = with_thickness(spread, measure_spread(turned, view, lambda name: status.update(f"measuring {name}")))
        (part / "overlays").mkdir(parents=True)
        spread.seeds.to_csv(part / SEEDS, index=False)
        spread.outlines.to_csv(part / OUTLINES, index=False)
        lot = read_lot(part)
        content = summary(spread.seeds, lot, spread.scale, spread.common, thickness)
        (part / SUMMARY).write_text(tomli_w.dumps(content), encoding="utf8")
        for name, picture in spread.pictures.items():
            Image.fromarray(picture).save(part / "overlays" / f"{Path(name).stem}.png")
        Image.fromarray(draw_outlines(lot)).save(part / "outlines.png")
        Image.fromarray(draw_sizes(lot)).save(part / "sizes.png")
        if out.exists():
            shutil.rmtree(out)
        part.rename(out)
    except MeasurementError as error:
        print(f"benchtwin shape: {error}", file=sys.stderr)
        return NOTHING
    except OSError as error:
        print(f"benchtwin shape: cannot write to {out}: {error.strerror or error}", file=sys.stderr)
        return MISUSED
    except KeyboardInterrupt:
        print(f"\nbenchtwin shape: stopped; nothing was written to {out}", file=sys.stderr)
        return NOTHING
    finally:
        shutil.rmtree(part, ignore_errors=True)
    if not quiet:
        _show(content, spread.notes, out)
    return DONE


def _check(out: Path, overwrite: bool) -> None:
    if not out.exists():
        return
    names = {p.name for p in out.iterdir()} if out.is_dir() else {out.name}
    if names and not names <= OWN:
        raise MeasurementError(f"{out}: holds something else than a lot ({min(names - OWN)}); choose another --out")
    if names and not overwrite:
        raise MeasurementError(f"{out}: exists and is not empty; choose another --out, or say --overwrite")


def _photos(paths: list[Path]) -> list[Path]:
    found: list[Path] = []
    for path in paths:
        if path.is_dir():
            inside = sorted(p for p in path.iterdir() if p.suffix.lower() in PHOTO_SUFFIXES)
            if not inside:
                raise MeasurementError(f"{path}: no photo in it ({', '.join(PHOTO_SUFFIXES)})")
            found += inside
        elif path.is_file():
            found.append(path)
        else:
            raise MeasurementError(f"{path}: no such file or folder")
    if twice := {p.name for p in found if sum(q.name == p.name for q in found) > 1}:
        raise MeasurementError(f"{min(twice)}: two photos of one name; seeds are named by their photo")
    return found


def _show(content: dict, notes: tuple[str, ...], out: Path) -> None:
    counts = ", ".join(f"{n} {kind}" for kind, n in sorted(content["counts"].items(), key=lambda item: item[0] != WHOLE))
    print(counts)
    for name in SIZES:
        if name in content:
            of = content[name]
            interval = " ({:.3f} to {:.3f})".format(*of["mean_low_high_mm"]) if of["mean_low_high_mm"] else ""
            print(f"{name:9}  {of['mean_mm']:.3f}{interval} mm, sd {of['sd_mm']:.3f}, n = {of['n']}")
    for note in notes:
        print(note)
    print(f"Seeds: {out / SEEDS}; summary: {out / SUMMARY}; look at {out / 'overlays'} and {out / 'outlines.png'}")
